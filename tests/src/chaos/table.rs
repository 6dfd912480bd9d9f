//! The manager processes of a home, as `/proc` shows them.

use std::path::{Path, PathBuf};

use rts_host::identity::start_ticks;

use crate::processes_of;

/// A manager process that lives.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Manager {
    /// Its number.
    pub pid: u32,
    /// Start in clock ticks: with the number it names one process.
    pub ticks: u64,
    /// Its run folder.
    pub folder: PathBuf,
    /// Name of its system, or nothing.
    pub system: String,
    /// Uid of its system, or nothing.
    pub uid: String,
    /// Its name.
    pub name: String,
    /// Which start of it.
    pub incarnation: String,
    /// SIGSTOP has been sent to it.
    pub stopped: bool,
}

impl Manager {
    /// What no two live managers may have in common.
    pub fn key(&self) -> (&str, &str) {
        (&self.uid, &self.name)
    }

    /// For people.
    pub fn text(&self) -> String {
        format!("{}.{} (pid {})", self.system, self.name, self.pid)
    }

    /// The same process, still alive.
    pub fn lives(&self) -> bool {
        read(self.pid).is_some_and(|now| now.ticks == self.ticks)
    }
}

/// All that live now, by system and name.
pub fn managers(home: &Path) -> Vec<Manager> {
    let mut found: Vec<_> = processes_of(home).into_iter().filter_map(read).collect();
    found.retain(|manager| manager.folder.starts_with(home));
    found.sort_by(|a, b| (&a.system, &a.name, a.pid).cmp(&(&b.system, &b.name, b.pid)));
    found
}

/// None when it is no manager, or a zombie.
fn read(pid: u32) -> Option<Manager> {
    let line = std::fs::read(format!("/proc/{pid}/cmdline")).ok()?;
    let line = String::from_utf8_lossy(&line).into_owned();
    let words: Vec<_> = line.split('\0').collect();
    let value = |key: &str| {
        let at = words.iter().position(|word| *word == key)?;
        words.get(at + 1).map(|word| (*word).to_owned())
    };
    if !words.first()?.ends_with("rts-manager") {
        return None;
    }
    let state = state(pid)?;
    (!matches!(state, 'Z' | 'X')).then_some(())?;
    Some(Manager {
        pid,
        ticks: start_ticks(pid)?,
        folder: PathBuf::from(value("--dir")?),
        system: value("--system-name").unwrap_or_default(),
        uid: value("--system-uid").unwrap_or_default(),
        name: value("--name").unwrap_or_default(),
        incarnation: value("--incarnation").unwrap_or_default(),
        stopped: state == 'T',
    })
}

fn state(pid: u32) -> Option<char> {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    stat.rsplit_once(')')?.1.trim_start().chars().next()
}
