//! Processes that a component started.

use std::path::Path;
use std::time::{Duration, Instant};

use rts_host::cgroup::{Cgroups, Choice};
use rts_tests::{Stack, alive, kill, kill_9};

use super::lab::*;

/// Whether control groups may be made here; without, what leaves its process group outlives its manager.
fn cgroups_are_permitted() -> bool {
    let nobody = format!("/tmp/rts-nobody-{}", std::process::id());
    match Cgroups::of(Path::new(&nobody), Choice::Auto).create("probe") {
        Ok(probe) => probe.remove().is_ok(),
        Err(e) => {
            eprintln!("only process groups are looked at: {e}");
            false
        }
    }
}

/// Live processes that components of this stack started.
pub fn left_by_components(stack: &Stack) -> Vec<u32> {
    let is_theirs = |pid: &u32| {
        let comm = std::fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default();
        ["sh", "sleep"].contains(&comm.trim())
    };
    family(stack).into_iter().filter(is_theirs).collect()
}

/// Its processes: those in the process group of the manager, and those that left it.
fn children(stack: &Stack, manager: u32) -> (Vec<u32>, Vec<u32>) {
    let group = |pid: u32| {
        let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
        let rest = stat.rsplit_once(") ").map_or("", |(_, rest)| rest);
        rest.split(' ').nth(2).and_then(|g| g.parse::<u32>().ok())
    };
    let all = left_by_components(stack);
    all.into_iter()
        .partition(|pid| group(*pid) == group(manager))
}

fn grandchildren(cgroups: &str) -> (Lab, Vec<u32>, Vec<u32>) {
    let mut lab = Lab::new("grandchildren", &[]);
    cgroups.clone_into(&mut lab.cgroups);
    lab.apply("0");
    let manager = lab.stack.witness().of(BAD).pid;
    let deadline = Instant::now() + SOON;
    loop {
        let (beside, away) = children(&lab.stack, manager);
        if beside.len() == 2 && away.len() == 2 {
            return (lab, beside, away);
        }
        assert!(Instant::now() < deadline, "{beside:?} {away:?}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Waits until none of them lives.
#[track_caller]
fn all_end(pids: &[u32]) {
    let deadline = Instant::now() + SOON;
    while pids.iter().any(|pid| alive(*pid)) {
        assert!(Instant::now() < deadline, "of {pids:?} some live");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Ends the manager, and all that it started; what left its process group only where control groups hold it.
fn they_end(cgroups: &str, crash: bool) {
    let (lab, beside, away) = grandchildren(cgroups);
    let held = cgroups == "auto";
    if crash {
        let bystanders = lab.bystanders();
        kill_9(lab.stack.witness().of(BAD).pid);
        all_end(&beside);
        lab.stack
            .until_seen("it runs again", |now| now.all_active(5));
        bystanders.goes_on_undisturbed(&lab.stack);
    }
    lab.stack.expect(0, &["teardown", "misbehaving", "--yes"]);
    assert!(beside.iter().all(|pid| !alive(*pid)), "{beside:?}");
    assert!(away.iter().all(|pid| alive(*pid) != held), "{away:?}");
    lab.stack.expect(0, &["down", "--yes"]);
    let left = family(&lab.stack);
    assert_eq!(left.is_empty(), held, "processes are left: {left:?}");
    left.into_iter().for_each(kill);
    lab.stack.leaves_nothing();
}

#[test]
fn grandchildren_end_with_their_manager() {
    let mut cases = vec!["off teardown", "off crash"];
    if cgroups_are_permitted() {
        cases.extend(["auto teardown", "auto crash"]);
    }
    all(&cases, |[cgroups, end]| they_end(cgroups, end == "crash"));
}
