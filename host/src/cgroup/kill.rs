//! Killing all processes of a control group at once.
//!
//! The kernel does it where it can (`cgroup.kill`, since 5.14). Elsewhere the group is frozen, so that nobody forks
//! between the look at the list and the signals.

use std::path::Path;
use std::time::Duration;

use super::hierarchy::Version;
use super::survey;

/// Looks whether all are frozen, and the time between two of them. Whoever is not by then is met in the next round.
const LOOKS: (u32, Duration) = (20, Duration::from_millis(1));

/// Kills what is in a group and below it. `signal` sends SIGKILL to each that is listed.
pub(super) fn kill(path: &Path, version: Version, signal: &dyn Fn()) {
    if version == Version::V2 && std::fs::write(path.join("cgroup.kill"), "1").is_ok() {
        return;
    }
    let Some(freezer) = Freezer::of(version) else {
        return signal();
    };
    freezer.freeze(path);
    signal();
    freezer.thaw(path);
}

/// The files by which a group is frozen.
struct Freezer {
    file: &'static str,
    on: &'static str,
    off: &'static str,
    /// File and line that tell that all are frozen.
    done: (&'static str, &'static str),
}

impl Freezer {
    fn of(version: Version) -> Option<Self> {
        match version {
            Version::V2 => Some(Self {
                file: "cgroup.freeze",
                on: "1",
                off: "0",
                done: ("cgroup.events", "frozen 1"),
            }),
            Version::Freezer => Some(Self {
                file: "freezer.state",
                on: "FROZEN",
                off: "THAWED",
                done: ("freezer.state", "FROZEN"),
            }),
            Version::Pids => None,
        }
    }

    fn freeze(&self, path: &Path) {
        if std::fs::write(path.join(self.file), self.on).is_err() {
            return;
        }
        for _ in 0..LOOKS.0 {
            let state = std::fs::read_to_string(path.join(self.done.0));
            if state.is_ok_and(|text| text.lines().any(|line| line == self.done.1)) {
                return;
            }
            std::thread::sleep(LOOKS.1);
        }
    }

    /// With all below it: a process in a frozen group does not die before it is thawed.
    fn thaw(&self, path: &Path) {
        for folder in survey::below(path) {
            let _ = std::fs::write(folder.join(self.file), self.off);
        }
    }
}
