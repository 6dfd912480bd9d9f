//! With the control groups of this machine, where they are permitted.

use std::os::unix::process::CommandExt;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use super::*;
use crate::process::{Process, signal_group};
use rustix::process::Signal;

const PATIENCE: Duration = Duration::from_secs(10);

struct Fixture {
    _home: tempfile::TempDir,
    groups: Cgroups,
}

impl Drop for Fixture {
    fn drop(&mut self) {
        for group in self.groups.find() {
            group.kill_within(PATIENCE);
            let _ = group.remove();
        }
    }
}

/// The groups of a new home; `None`, and a word, where they are not permitted.
fn fixture(choice: Choice) -> Option<Fixture> {
    let home = tempfile::tempdir().unwrap();
    let groups = Cgroups::of(home.path(), choice);
    let fixture = Fixture {
        groups: groups.clone(),
        _home: home,
    };
    match groups.create("probe") {
        Ok(probe) => {
            probe.remove().unwrap();
            Some(fixture)
        }
        Err(e) => {
            eprintln!("skipped: {e}");
            None
        }
    }
}

/// A shell, in the group before it does anything.
fn shell(group: &Cgroup, script: &str) -> Child {
    let mut child = Command::new("/bin/sh")
        .args(["-c", &format!("read go; {script}")])
        .stdin(std::process::Stdio::piped())
        .process_group(0)
        .spawn()
        .unwrap();
    group.join(child.id()).unwrap();
    drop(child.stdin.take());
    child
}

fn until(what: &str, done: impl Fn() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !done() {
        assert!(Instant::now() < end, "{what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Grandchildren that ignore SIGTERM, and one that leaves its process group.
const FAMILY: &str =
    "trap '' TERM; (sleep 1000; true) & setsid sh -c \"trap '' TERM; sleep 1000; true\" & wait";

fn nobody_survives(choice: Choice) {
    let Some(fixture) = fixture(choice) else {
        return;
    };
    let group = fixture.groups.create("local.01234567").unwrap();
    assert!(!group.is_populated());
    let mut child = shell(&group, FAMILY);
    until("all five are there", || group.processes().len() == 5);
    let all = group.processes();
    assert_eq!(
        fixture.groups.holding("local.01234567", child.id()),
        Some(group.clone())
    );
    assert_eq!(fixture.groups.holding("local.0", child.id()), None);
    signal_group(child.id(), Signal::KILL).unwrap();
    child.wait().unwrap();
    until("its process group dies", || group.processes().len() == 2);
    assert!(group.is_populated());
    assert!(group.remove().is_err(), "it is in use");
    assert!(group.kill_within(PATIENCE));
    assert!(all.iter().all(|process| process.ended(PATIENCE)));
    group.remove().unwrap();
    assert!(!group.path().exists());
    assert!(!group.path().parent().unwrap().exists(), "the last one");
}

#[test]
fn nobody_survives_version_2() {
    nobody_survives(Choice::V2);
}

#[test]
fn nobody_survives_version_1() {
    nobody_survives(Choice::V1);
}

#[test]
fn nobody_survives_where_the_kernel_cannot_kill_a_group() {
    for choice in [Choice::V2, Choice::V1] {
        let Some(fixture) = fixture(choice) else {
            continue;
        };
        let group = fixture.groups.create("x").unwrap();
        // Those of an older kernel, or of the hierarchy without a freezer.
        for version in [Version::Freezer, Version::Pids] {
            let mut child = shell(&group, FAMILY);
            until("all five are there", || group.processes().len() == 5);
            let old = Cgroup::new(group.path().to_owned(), version);
            assert!(old.is_populated());
            assert!(old.kill_within(PATIENCE));
            child.wait().unwrap();
            assert!(!group.is_populated());
        }
    }
}

#[test]
fn a_group_that_keeps_forking_is_ended() {
    for choice in [Choice::V2, Choice::V1] {
        let Some(fixture) = fixture(choice) else {
            continue;
        };
        let group = fixture.groups.create("x").unwrap();
        let script = "f() { setsid sh -c 'sleep 0.01' & }; while :; do f; f; sleep 0.001; done";
        let mut child = shell(&group, script);
        until("they fork", || group.processes().len() > 3);
        assert!(group.kill_within(PATIENCE));
        child.wait().unwrap();
        group.remove().unwrap();
    }
}

#[test]
fn groups_within_a_group_go_with_it_and_frozen_ones_too() {
    for choice in [Choice::V2, Choice::V1] {
        let Some(fixture) = fixture(choice) else {
            continue;
        };
        let group = fixture.groups.create("x").unwrap();
        let below = group.path().join("a/b");
        std::fs::create_dir_all(&below).unwrap();
        let inner = Cgroup::new(below.clone(), group.version());
        let mut child = shell(&inner, "sleep 1000; true");
        until("it sleeps", || group.processes().len() == 2);
        let freeze = match group.version() {
            Version::V2 => ("cgroup.freeze", "1"),
            _ => ("freezer.state", "FROZEN"),
        };
        let _ = std::fs::write(below.join(freeze.0), freeze.1);
        assert!(group.is_populated());
        assert!(group.kill_within(PATIENCE));
        child.wait().unwrap();
        group.remove().unwrap();
        assert!(!group.path().exists());
    }
}

#[test]
fn groups_of_a_home_are_found_by_its_path_alone_and_only_its_own() {
    let Some(fixture) = fixture(Choice::Auto) else {
        return;
    };
    let names = |groups: &Cgroups| -> Vec<String> {
        let found = groups.find();
        found.iter().map(|g| g.name().to_owned()).collect()
    };
    for name in ["local.1", "local.2"] {
        fixture.groups.create(name).unwrap();
    }
    let again = Cgroups::of(fixture._home.path(), Choice::Auto);
    assert_eq!(names(&again), ["local.1", "local.2"]);
    let other = Cgroups::of(&fixture._home.path().join("x"), Choice::Auto);
    assert_eq!(names(&other), Vec::<String>::new());
    let off = Cgroups::of(fixture._home.path(), Choice::Off);
    assert_eq!(names(&off), Vec::<String>::new());
    assert!(off.create("x").is_err());
    // Made twice is made once.
    let one = fixture.groups.create("local.1").unwrap();
    let mut child = shell(&one, "sleep 1000; true");
    assert!(one.remove().is_err());
    assert!(Process::open(child.id()).is_some());
    assert!(one.kill_within(PATIENCE));
    child.wait().unwrap();
}

#[test]
fn what_the_variable_says() {
    assert_eq!(Choice::parse(""), Some(Choice::Auto));
    assert_eq!(Choice::parse("off"), Some(Choice::Off));
    assert_eq!(Choice::parse("v3"), None);
    let refused = NotPermitted(vec![
        ("/a".into(), io::Error::from_raw_os_error(13)),
        ("/b".into(), io::Error::from_raw_os_error(30)),
    ]);
    assert_eq!(
        refused.to_string(),
        "cannot make a control group: /a: Permission denied (os error 13), /b: Read-only file system (os error 30)"
    );
}

#[test]
fn a_group_of_another_process_namespace_is_not_meant() {
    let Some(fixture) = fixture(Choice::Auto) else {
        return;
    };
    let group = fixture.groups.create("local.1").unwrap();
    // As a container's first process: seen from here, of a namespace of its own. The waiting parent is outside.
    let mut child = Command::new("unshare")
        .args(["--pid", "--fork", "--kill-child", "sh", "-c", "read go"])
        .stdin(std::process::Stdio::piped())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let inner = format!("/proc/{0}/task/{0}/children", child.id());
    let end = Instant::now() + PATIENCE;
    let inner: u32 = loop {
        let text = std::fs::read_to_string(&inner).unwrap_or_default();
        if let Ok(pid) = text.trim().parse() {
            break pid;
        }
        if child.try_wait().unwrap().is_some() || Instant::now() > end {
            return eprintln!("skipped: no process namespaces here");
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    group.join(inner).unwrap();
    assert_eq!(fixture.groups.find(), []);
    group.join(child.id()).unwrap();
    assert_eq!(fixture.groups.find(), std::slice::from_ref(&group));
    drop(child.stdin.take());
    child.wait().unwrap();
}

#[test]
fn one_is_made_beside_another_that_is_there_or_gone_but_not_twice() {
    let Some(fixture) = fixture(Choice::Auto) else {
        return;
    };
    let first = fixture.groups.create("first").unwrap();
    let second = first.beside("second").unwrap();
    assert_eq!(second.path().parent(), first.path().parent());
    let refused = first.beside("second").unwrap_err();
    assert_eq!(refused.kind(), io::ErrorKind::AlreadyExists);
    first.remove().unwrap();
    second.remove().unwrap();
    assert_eq!(fixture.groups.folders(), Vec::<PathBuf>::new());
    let again = second.beside("second").unwrap();
    assert_eq!(again, second);
    again.remove().unwrap();
}
