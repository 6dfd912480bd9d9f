//! What managers started and left behind: found by the control groups of the home, whose names need no run folder.

use std::collections::BTreeMap;

use rts_host::cgroup::{Cgroup, Cgroups, Choice};
use rts_host::process::Process;

use super::{KILLED, Stopped};
use crate::local::home::Home;

/// Kills all in the control groups of the home, and removes them. `names` are the managers by their groups.
pub(super) fn end(home: &Home, names: &BTreeMap<String, String>, stopped: &mut Stopped) {
    let cgroups = Cgroups::of(home.path(), Choice::from_env());
    for cgroup in cgroups.find() {
        let of = names
            .get(cgroup.name())
            .map_or(cgroup.name(), String::as_str);
        end_one(&cgroup, of, stopped);
    }
    cgroups.tidy();
}

fn end_one(cgroup: &Cgroup, of: &str, stopped: &mut Stopped) {
    let processes = cgroup.processes();
    if !cgroup.kill_within(KILLED) {
        let who: Vec<_> = cgroup.processes().iter().map(describe).collect();
        let who = who.join(", ");
        let left = format!("what manager {of} started does not die: {who}");
        return stopped.left.push(left);
    }
    let killed = processes
        .iter()
        .map(|process| format!("{} of manager {of}", describe(process)));
    stopped.killed.extend(killed);
    if let Err(e) = cgroup.remove() {
        let path = cgroup.path().display();
        stopped.left.push(format!("cannot remove {path}: {e}"));
    }
}

/// `sleep (pid 4711)`; without its name when it is gone.
fn describe(process: &Process) -> String {
    let pid = process.pid();
    let name = std::fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default();
    match name.trim() {
        "" => format!("pid {pid}"),
        name => format!("{name} (pid {pid})"),
    }
}
