//! Who a process is: pid, start time and boot together name one process for good.

use std::path::Path;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

/// Names one process: contents of `controller.json` and `agent.json`, and a part of `manager.json`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Identity {
    /// Process id.
    pub pid: u32,
    /// Field 22 of `/proc/PID/stat`: start in clock ticks since boot.
    pub start_ticks: u64,
    /// `/proc/sys/kernel/random/boot_id`.
    pub boot_id: String,
    /// Program version.
    #[serde(default)]
    pub version: String,
}

impl Identity {
    /// Of the process that has this pid now; `None` when there is none.
    pub fn of(pid: u32) -> Option<Self> {
        Some(Self {
            pid,
            start_ticks: start_ticks(pid)?,
            boot_id: boot_id()?,
            version: String::new(),
        })
    }

    /// Of this process, with the version of its program; `None` where there is no `/proc`.
    pub fn own(version: &str) -> Option<Self> {
        Some(Self {
            version: version.to_owned(),
            ..Self::of(std::process::id())?
        })
    }

    /// Reads it from a file; `None` when there is none or it makes no sense.
    pub fn read(path: &Path) -> Option<Self> {
        serde_json::from_slice(&std::fs::read(path).ok()?).ok()
    }

    /// True when this very process still has its pid (it may be a zombie).
    pub fn is_now(&self) -> bool {
        boot_id().is_some_and(|boot| boot == self.boot_id.trim())
            && start_ticks(self.pid) == Some(self.start_ticks)
    }
}

/// Id of the present boot. It is read once: no process outlives it.
pub fn boot_id() -> Option<String> {
    static BOOT: OnceLock<String> = OnceLock::new();
    if let Some(known) = BOOT.get() {
        return Some(known.clone());
    }
    let text = std::fs::read_to_string("/proc/sys/kernel/random/boot_id").ok()?;
    Some(BOOT.get_or_init(|| text.trim().to_owned()).clone())
}

/// When a process started, in clock ticks since boot; `None` when it does not exist.
pub fn start_ticks(pid: u32) -> Option<u64> {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    stat_fields(&stat)?.nth(19)?.parse().ok()
}

/// Fields of a stat file from the third (state) on; the second, the name, may hold blanks and parentheses.
pub(crate) fn stat_fields(stat: &str) -> Option<impl Iterator<Item = &str>> {
    Some(stat.rsplit_once(')')?.1.split_whitespace())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_with_blanks_and_parentheses_does_not_shift_the_fields() {
        let stat = "7 (a) b) (c) S 1 7 7 0 -1 4194560 1 0 0 0 0 0 0 0 20 0 1 0 4711 8 9";
        assert_eq!(
            stat_fields(stat).and_then(|mut fields| fields.nth(19)),
            Some("4711")
        );
        assert!(stat_fields("rubbish").is_none());
    }

    #[test]
    fn a_process_is_known_by_pid_start_time_and_boot() {
        let own = Identity::own("1.2.3").unwrap();
        assert!(own.is_now());
        assert!(
            !Identity {
                start_ticks: own.start_ticks + 1,
                ..own.clone()
            }
            .is_now()
        );
        assert!(
            !Identity {
                boot_id: "another".to_owned(),
                ..own
            }
            .is_now()
        );
        assert!(Identity::of(u32::MAX).is_none());
    }
}
