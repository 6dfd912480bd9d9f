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
fn a_full_device_is_2_and_nothing_is_said_of_a_part() {
    let stack = up();
    for args in [&["plan", "nothing.xml"][..], &["get", "nodes"]] {
        let full = std::fs::File::options().write(true).open("/dev/full");
        let output = stack.command(args).stdout(full.unwrap()).output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        let said = "error: cannot write to stdout: No space left on device";
        assert!(stderr.contains(said), "{stderr}");
    }
}

#[test]
fn a_dry_run_prints_what_plan_prints() {
    let stack = up();
    for format in ["text", "json", "yaml", "dot", "mermaid"] {
        let format = ["-o", format, "--steps"];
        let planned = stack.run(&[&["plan", "nothing.xml"], &format[..]].concat());
        let dry = [&["apply", "--dry-run", "nothing.xml"], &format[..]].concat();
        let (code, stdout, stderr) = stack.run(&dry);
        assert_eq!((code, stdout), (planned.0, planned.1), "{stderr}");
        let said = format!("{}dry run: nothing was changed\n", planned.2);
        assert_eq!(stderr, said);
    }
    assert_eq!(stack.run(&["apply", "nothing.xml"]).0, 0);
    let (code, stdout, stderr) = stack.run(&["diff", "nothing.xml", "--steps"]);
    assert_eq!(code, 0, "{stdout}{stderr}");
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
