//! The program with a local stack: what it says when the agent is dead, and when nobody reads.

#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

mod support;

use std::io::Read;
use std::process::Stdio;
use std::time::{Duration, Instant};

use support::Stack;

/// A system of nothing: it needs no modules.
const NOTHING: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:rtsctl:nothing:1.0" rts:version="0.2" rts:creationDate="2026-01-01T00:00:00"
  rts:updateDate="2026-01-01T00:00:00" xmlns:rts="http://www.openrtp.org/namespaces/rts"/>
"#;
/// Longest time for what is to be seen at once.
const SOON: Duration = Duration::from_secs(20);
const STARTS: &str =
    "help: the agent of this machine (node local) does not run: `rtsctl up` starts it again\n";

/// A stack with the file `nothing.xml` in its folder.
fn up() -> Stack {
    let stack = Stack::up();
    std::fs::write(stack.folder.path().join("nothing.xml"), NOTHING).unwrap();
    stack
}

#[test]
fn a_dead_agent_comes_with_what_starts_it_again() {
    let stack = up();
    stack.kill_agent();
    let end = Instant::now() + SOON;
    let (code, _, stderr) = stack.run(&["logs", "Nobody"]);
    assert_eq!(code, 4, "{stderr}");
    assert!(stderr.ends_with(STARTS), "{stderr}");
    while !stack.run(&["get", "nodes"]).1.contains("Unknown") {
        assert!(Instant::now() < end, "its node is not Unknown");
        std::thread::sleep(Duration::from_millis(100));
    }
    let (code, _, stderr) = stack.run(&["logs", "Nobody"]);
    assert_eq!((code, stderr.ends_with(STARTS)), (4, true), "{stderr}");
    let (_, page, _) = stack.run(&["describe", "node/local"]);
    assert!(page.contains("`rtsctl up` starts it again"), "{page}");
    assert_eq!(stack.run(&["up"]).0, 0);
    let (code, _, stderr) = stack.run(&["logs", "Nobody"]);
    assert_eq!(code, 2, "{stderr}");
}

#[test]
fn a_node_to_be_forgotten_that_nobody_knows_is_a_slip() {
    let stack = up();
    let (code, _, stderr) = stack.run(&["apply", "nothing.xml"]);
    assert_eq!(code, 0, "{stderr}");
    let (code, _, stderr) = stack.run(&["teardown", "nothing", "--yes", "--forget-node", "nope"]);
    assert_eq!(code, 2, "{stderr}");
    insta::assert_snapshot!(stderr, @r"
    error: node/nope is not there
    help: there are: local
    ");
    assert_eq!(stack.run(&["describe", "system/nothing"]).0, 0);
    let (code, _, stderr) = stack.run(&["teardown", "nothing", "--yes", "--forget-node", "local"]);
    assert_eq!(code, 0, "{stderr}");
}

#[test]
fn a_backup_that_cannot_be_written_is_2() {
    let stack = up();
    let (code, _, stderr) = stack.run(&["controller", "backup", "no/folder"]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("cannot write no/folder: "), "{stderr}");
}

#[test]
fn a_watch_that_nobody_reads_ends_though_nothing_changes() {
    let stack = up();
    for args in [
        &["get", "nodes", "-w"][..],
        &["get", "nodes", "--watch-only", "-o", "json"],
        &["events", "-w"],
    ] {
        let mut command = stack.command(args);
        let piped = command.stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = piped.spawn().unwrap();
        let mut stdout = child.stdout.take().unwrap();
        let mut first = [0];
        assert_eq!(stdout.read(&mut first).unwrap(), 1, "{args:?}");
        drop(stdout);
        let end = Instant::now() + SOON;
        let status = loop {
            if let Some(status) = child.try_wait().unwrap() {
                break status;
            }
            if Instant::now() >= end {
                let _ = child.kill();
                let _ = child.wait();
                panic!("{args:?} goes on");
            }
            std::thread::sleep(Duration::from_millis(20));
        };
        assert_eq!(status.code(), Some(141), "{args:?}");
    }
}
