//! The processes of a server's sessions, found in `/proc`.

use std::path::Path;

use rustix::process::{Pid, Signal, kill_process};

/// Those that a listener forked and their children of the same program, which serve one connection each. Orphans of a
/// listener that has ended are known by nothing but what they were started with, so they are found before it ends.
pub(super) fn sessions(listener: Option<u32>, settings: &Path) -> Vec<u32> {
    let all = processes();
    let started_with = |pid: u32| {
        let line = std::fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
        let needle = settings.as_os_str().as_encoded_bytes();
        line.windows(needle.len()).any(|window| window == needle)
    };
    let mut found: Vec<u32> = all
        .iter()
        .filter(|(pid, _)| Some(*pid) != listener && started_with(*pid))
        .map(|(pid, _)| *pid)
        .collect();
    // A session's process overwrites its arguments (`sshd: user@notty`): known by its parent then.
    let mut parents: Vec<u32> = listener.into_iter().chain(found.iter().copied()).collect();
    while let Some(parent) = parents.pop() {
        for (pid, of) in &all {
            let new = *of == parent && Some(*pid) != listener && !found.contains(pid);
            if new && is_server(*pid) {
                found.push(*pid);
                parents.push(*pid);
            }
        }
    }
    found
}

/// SIGKILL; one that has ended is fine.
pub(super) fn kill(pid: u32) {
    if let Some(pid) = i32::try_from(pid).ok().and_then(Pid::from_raw) {
        let _ = kill_process(pid, Signal::KILL);
    }
}

/// Every process with its parent.
fn processes() -> Vec<(u32, u32)> {
    let Ok(entries) = std::fs::read_dir("/proc") else {
        return Vec::new();
    };
    let pids = entries.filter_map(|entry| entry.ok()?.file_name().to_str()?.parse().ok());
    pids.filter_map(|pid: u32| Some((pid, parent(pid)?)))
        .collect()
}

fn parent(pid: u32) -> Option<u32> {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    let fields = stat.rsplit_once(')')?.1;
    fields.split_whitespace().nth(1)?.parse().ok()
}

fn is_server(pid: u32) -> bool {
    let exe = std::fs::read_link(format!("/proc/{pid}/exe")).unwrap_or_default();
    let name = exe.file_name().unwrap_or_default().to_string_lossy();
    name.starts_with("sshd")
}
