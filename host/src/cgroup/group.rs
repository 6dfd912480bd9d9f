//! One control group: who is in it, and its end.

use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rustix::process::Signal;

use super::hierarchy::Version;
use super::{kill, survey};
use crate::process::Process;

/// How long the kernel may take to let go of a group that has become empty.
const RELEASE: Duration = Duration::from_millis(500);

/// A control group. The value does not keep it alive, and dropping it removes nothing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cgroup {
    path: PathBuf,
    version: Version,
}

impl Cgroup {
    pub(super) fn new(path: PathBuf, version: Version) -> Self {
        Self { path, version }
    }

    /// `<node>.<run folder>`.
    pub fn name(&self) -> &str {
        let name = self.path.file_name().and_then(|name| name.to_str());
        name.unwrap_or_default()
    }

    /// Its folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Which sort it is.
    pub fn version(&self) -> Version {
        self.version
    }

    /// Makes a new one beside it, also when it is gone by now; an error when one of that name is there.
    pub fn beside(&self, name: &str) -> io::Result<Self> {
        let path = self.path.with_file_name(name);
        let mut made = std::fs::create_dir(&path);
        if matches!(&made, Err(e) if e.kind() == io::ErrorKind::NotFound)
            && let Some(parent) = path.parent()
        {
            // The last group of the home was removed, and the folder with it.
            let _ = std::fs::create_dir(parent);
            made = std::fs::create_dir(&path);
        }
        made.map(|()| Self::new(path, self.version))
    }

    /// Puts a process into it; what the process starts from then on is in it too.
    pub fn join(&self, pid: u32) -> io::Result<()> {
        std::fs::write(self.path.join("cgroup.procs"), pid.to_string())
    }

    /// Live processes in it and in what it has below. Zombies do not count.
    pub fn processes(&self) -> Vec<Process> {
        // A number read may come to mean another process before it is opened; one that is still in the list after
        // that is the one that is meant.
        let opened: Vec<_> = self.pids().into_iter().filter_map(Process::open).collect();
        let still = self.pids();
        let meant = |process: &Process| {
            u32::try_from(process.pid()).is_ok_and(|pid| still.contains(&pid))
                && !process.ended(Duration::ZERO)
        };
        opened.into_iter().filter(meant).collect()
    }

    fn pids(&self) -> Vec<u32> {
        let mut pids = self.listed();
        pids.retain(|pid| *pid != 0);
        pids
    }

    fn listed(&self) -> Vec<u32> {
        let mut pids: Vec<u32> = Vec::new();
        for folder in survey::below(&self.path) {
            // Gone meanwhile, or threaded: then its processes are listed above it.
            let text = std::fs::read_to_string(folder.join("cgroup.procs")).unwrap_or_default();
            pids.extend(text.lines().filter_map(|pid| pid.parse::<u32>().ok()));
        }
        pids
    }

    /// True while somebody lives in it.
    pub fn is_populated(&self) -> bool {
        if self.version == Version::V2
            && let Ok(events) = std::fs::read_to_string(self.path.join("cgroup.events"))
        {
            return events.lines().any(|line| line == "populated 1");
        }
        !self.processes().is_empty()
    }

    /// True unless all that tell are of another process namespace. One that is just dying tells nothing.
    pub(super) fn is_near(&self) -> bool {
        let namespace = |pid: &str| std::fs::read_link(format!("/proc/{pid}/ns/pid")).ok();
        let own = namespace("self");
        let listed = self.listed();
        let near = |pid: &u32| match namespace(&pid.to_string()) {
            // 0 is a process that this namespace does not see.
            _ if *pid == 0 => Some(false),
            Some(its) => Some(Some(its) == own),
            None => None,
        };
        let told: Vec<bool> = listed.iter().filter_map(near).collect();
        told.is_empty() || told.contains(&true)
    }

    /// Sends a signal to each that lives in it now.
    pub fn signal(&self, signal: Signal) {
        for process in self.processes() {
            process.signal(signal);
        }
    }

    /// Kills all in it once, without waiting.
    pub fn kill(&self) {
        kill::kill(&self.path, self.version, &|| self.signal(Signal::KILL));
    }

    /// Kills all in it until nobody is left; false when somebody is at the end of the time.
    pub fn kill_within(&self, limit: Duration) -> bool {
        let end = Instant::now() + limit;
        let mut pause = Duration::from_millis(1);
        while self.is_populated() {
            self.kill();
            if Instant::now() >= end {
                return !self.is_populated();
            }
            std::thread::sleep(pause);
            pause = (pause * 2).min(Duration::from_millis(50));
        }
        true
    }

    /// Removes it, with what a process in it may have made below it, and the folder above it when it is the last one.
    /// One that is gone is fine; one with processes is refused.
    pub fn remove(&self) -> io::Result<()> {
        let end = Instant::now() + RELEASE;
        loop {
            match self.remove_once() {
                Err(e)
                    if e.kind() == io::ErrorKind::ResourceBusy
                        && !self.is_populated()
                        && Instant::now() < end =>
                {
                    std::thread::sleep(Duration::from_millis(5));
                }
                other => break other?,
            }
        }
        self.remove_parent();
        Ok(())
    }

    /// The same without waiting for a kernel that has not let go of it yet.
    pub fn remove_now(&self) -> io::Result<()> {
        self.remove_once()?;
        self.remove_parent();
        Ok(())
    }

    fn remove_parent(&self) {
        if let Some(parent) = self.path.parent() {
            // Refused while others are in it.
            let _ = std::fs::remove_dir(parent);
        }
    }

    fn remove_once(&self) -> io::Result<()> {
        for folder in survey::below(&self.path).iter().rev() {
            match std::fs::remove_dir(folder) {
                Err(e) if e.kind() == io::ErrorKind::NotFound => {}
                other => other?,
            }
        }
        Ok(())
    }
}
