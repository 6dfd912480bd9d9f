//! What must be gone: after a teardown all of a system, in the end everything.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rts_host::cgroup::{Cgroups, Choice};

use super::stage::{Stage, Stop};
use super::table::managers;
use crate::{kill, processes_of};

/// How long the last of it may take to go.
const BOUND: Duration = Duration::from_secs(5);

impl Stage {
    /// Run folders and control groups are those of live managers, of systems that are wished.
    pub fn nothing_is_left_of_the_gone(&mut self) -> Result<(), Stop> {
        let begin = Instant::now();
        loop {
            let left = self.left_of_the_gone();
            if left.is_empty() {
                return Ok(());
            }
            if begin.elapsed() > BOUND {
                return Err(Stop::Violated(left));
            }
            self.sleep(Duration::from_millis(50))?;
        }
    }

    fn left_of_the_gone(&self) -> Vec<String> {
        let home = self.stack.home();
        let live = managers(&home);
        let mut left = Vec::new();
        let stored = |name: &str| self.candidates(name).iter().any(Option::is_some);
        for manager in live.iter().filter(|manager| !stored(&manager.system)) {
            left.push(format!("{} lives on after the teardown", manager.text()));
        }
        let folders: BTreeSet<PathBuf> = live.into_iter().map(|m| m.folder).collect();
        for folder in run_folders(&home) {
            if !folders.contains(&folder) {
                left.push(format!("{} is left behind", folder.display()));
            }
        }
        let ids: BTreeSet<_> = folders
            .iter()
            .filter_map(|f| f.file_name()?.to_str())
            .collect();
        for group in groups(&home) {
            let name = group
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned();
            let of = name.rsplit('.').next().unwrap_or_default();
            if name.contains('.') && !ids.contains(of) {
                left.push(format!("{} is left behind", group.display()));
            }
        }
        left
    }

    /// Ends the stack as a user does, and looks for what is left of it.
    pub fn nothing_is_left(&mut self) -> Result<(), Stop> {
        let home = self.stack.home();
        self.must(&["down", "--yes"])?;
        let mut left: Vec<String> = Vec::new();
        left.extend(
            processes_of(&home)
                .iter()
                .map(|pid| format!("process {pid} is left")),
        );
        left.extend(sockets(&home));
        if home.join("run").exists() {
            left.push(format!("{} is left", home.join("run").display()));
        }
        left.extend(
            groups(&home)
                .iter()
                .map(|g| format!("{} is left", g.display())),
        );
        let shared = std::fs::read_dir("/dev/shm")
            .into_iter()
            .flatten()
            .flatten();
        let names = shared.map(|entry| entry.file_name().to_string_lossy().into_owned());
        left.extend(
            names
                .filter(|n| n.contains("rts"))
                .map(|n| format!("/dev/shm/{n} is left")),
        );
        if !left.is_empty() {
            return Err(Stop::Violated(left));
        }
        self.disk.unmount();
        self.must(&["down", "--purge", "--yes"])?;
        match home.exists() {
            true => Err(Stop::Violated(vec![format!("{} is left", home.display())])),
            false => Ok(()),
        }
    }

    fn must(&mut self, arguments: &[&str]) -> Result<(), Stop> {
        let said = self.rtsctl(arguments)?;
        match said.code {
            0 => Ok(()),
            code => {
                let command = arguments.join(" ");
                let text = format!("`rtsctl {command}` ends with {code}: {}", said.err);
                Err(Stop::Violated(vec![text]))
            }
        }
    }

    /// Ends all without asking anybody: after this nothing of it runs.
    pub fn end_everything(&mut self) {
        self.watcher.stop();
        self.running.clear();
        let home = self.stack.home();
        let begin = Instant::now();
        // The killers of the killed first: an agent that lives starts managers anew.
        loop {
            let mut pids = Vec::new();
            for program in ["rts-controller", "rts-agent"] {
                pids.extend(self.stack.daemons(program));
            }
            pids.extend(processes_of(&home));
            pids.iter().for_each(|pid| kill(*pid));
            if pids.is_empty() || begin.elapsed() > BOUND {
                break;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        for mut agent in self.agents.drain(..) {
            let _ = agent.kill();
            let _ = agent.wait();
        }
        let cgroups = Cgroups::of(&home, Choice::Auto);
        for group in cgroups.find() {
            group.kill_within(BOUND);
            let _ = group.remove();
        }
        cgroups.tidy();
    }
}

/// `run/<node>/<8 digits>`.
fn run_folders(home: &Path) -> Vec<PathBuf> {
    let folders = |path: PathBuf| {
        let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
        entries
            .map(|entry| entry.path())
            .filter(|path| path.is_dir())
    };
    folders(home.join("run")).flat_map(folders).collect()
}

fn groups(home: &Path) -> Vec<PathBuf> {
    Cgroups::of(home, Choice::Auto).folders()
}

/// Unix sockets below the home that some process still has open.
fn sockets(home: &Path) -> Vec<String> {
    let text = std::fs::read_to_string("/proc/net/unix").unwrap_or_default();
    let home = home.display().to_string();
    let own = text.lines().filter(|line| line.contains(&home));
    own.map(|line| format!("a socket is left: {line}"))
        .collect()
}
