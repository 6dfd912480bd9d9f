//! `rtsctl up` and `rtsctl down` that are interrupted or killed at any moment: the next one goes on from there.

#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use rts_host::cgroup::{Cgroups, Choice};
use rustix::process::{Pid, Signal, kill_process, kill_process_group};

/// Interrupted commands.
const ROUNDS: u64 = 20;
/// Longest life of one before it is interrupted.
const LIFE_MS: u64 = 400;
/// Longest time that a whole command may take: no lock is left, so it waits for nobody.
const PATIENCE: Duration = Duration::from_secs(60);

struct Home {
    folder: tempfile::TempDir,
}

impl Home {
    fn new() -> Self {
        let folder = tempfile::Builder::new().prefix("rts").tempdir_in("/tmp");
        let folder = folder.unwrap();
        std::fs::write(folder.path().join("libnothing.so"), "no library").unwrap();
        Self { folder }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("h")
    }

    fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rtsctl"));
        command
            .args(args)
            .env_clear()
            .env("RTSCTL_HOME", self.path())
            .env("RTSCTL_MODULE_PATH", self.folder.path())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            // As a shell does: Ctrl-C goes to this group.
            .process_group(0);
        command
    }

    #[track_caller]
    fn runs(&self, args: &[&str]) {
        let begun = Instant::now();
        let mut command = self.command(args);
        let piped = command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let Output { status, stderr, .. } = piped.output().unwrap();
        let stderr = String::from_utf8_lossy(&stderr);
        assert_eq!(status.code(), Some(0), "rtsctl {args:?}: {stderr}");
        assert!(begun.elapsed() < PATIENCE, "{:?}", begun.elapsed());
    }

    /// A manager process: there is one although it cannot load what it is asked for.
    fn start_manager(&self) {
        let _ = self
            .command(&["manager", "load", "bench", "Nothing"])
            .output();
    }

    /// Live processes that name the home.
    fn processes(&self) -> Vec<String> {
        let home = self.path();
        let needle = home.to_str().unwrap();
        let entries = std::fs::read_dir("/proc").unwrap().flatten();
        let lines = entries.filter_map(|entry| {
            let line = std::fs::read(entry.path().join("cmdline")).ok()?;
            let line = String::from_utf8_lossy(&line).replace('\0', " ");
            let stat = std::fs::read_to_string(entry.path().join("stat")).ok()?;
            let zombie = stat.rsplit_once(") ")?.1.starts_with('Z');
            (line.contains(needle) && !zombie).then_some(line)
        });
        lines.collect()
    }

    #[track_caller]
    fn is_gone(&self) {
        assert!(!self.path().exists());
        assert_eq!(self.processes(), Vec::<String>::new());
        assert_eq!(Cgroups::of(&self.path(), Choice::Auto).find(), []);
    }
}

impl Drop for Home {
    fn drop(&mut self) {
        let _ = self.command(&["down", "--purge", "--yes"]).output();
    }
}

/// A generator of numbers that look random: the same in each run, so that a failure can be seen again.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self, below: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % below
    }
}

/// Ctrl-C, or an end without a chance to do anything.
fn interrupt(child: &mut Child, gently: bool) {
    let pid = Pid::from_raw(i32::try_from(child.id()).unwrap()).unwrap();
    let _ = if gently {
        kill_process_group(pid, Signal::INT)
    } else {
        kill_process(pid, Signal::KILL)
    };
    child.wait().unwrap();
}

fn seen(path: &Path) -> &'static str {
    if path.exists() { "is" } else { "is not" }
}

#[test]
fn up_and_down_that_are_killed_at_any_moment_leave_what_the_next_one_can_go_on_from() {
    let home = Home::new();
    let mut numbers = Numbers(0x9E37_79B9_7F4A_7C15);
    for round in 0..ROUNDS {
        let down = numbers.next(2) == 0;
        let args: &[&str] = if down { &["down", "--yes"] } else { &["up"] };
        if down && numbers.next(2) == 0 {
            home.start_manager();
        }
        let mut child = home.command(args).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(numbers.next(LIFE_MS)));
        let gently = numbers.next(2) == 0;
        interrupt(&mut child, gently);
        let run = seen(&home.path().join("run"));
        eprintln!("{round}: {args:?} interrupted, gently: {gently}; run/ {run} there");
    }
    home.runs(&["up"]);
    home.start_manager();
    home.runs(&["up"]);
    home.runs(&["down", "--purge", "--yes"]);
    home.is_gone();
}

#[test]
fn down_right_after_an_up_that_was_killed_leaves_nothing() {
    let home = Home::new();
    for life in [5, 15, 30, 60, 120] {
        let mut child = home.command(&["up"]).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(life));
        interrupt(&mut child, false);
        home.runs(&["down", "--purge", "--yes"]);
        assert_eq!(home.processes(), Vec::<String>::new(), "{life} ms");
    }
    home.runs(&["up"]);
    home.runs(&["down", "--purge", "--yes"]);
    home.is_gone();
}
