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

#[test]
fn a_change_is_played_through_and_nothing_is_changed() {
    let stack = up();
    let fault = "agent local drops at 1s for 10s";
    let simulate = ["plan", "--simulate", "nothing.xml", "--fault", fault];
    let (code, stdout, stderr) = stack.run(&simulate);
    assert_eq!(code, 0, "{stdout}{stderr}");
    for said in [
        &format!("fault: {fault}\n"),
        " NodeUnknown ",
        " FaultOver ",
        " NodeReady ",
        "(seed 1)",
    ] {
        assert!(stdout.contains(said), "{said} is missing in {stdout}");
    }
    assert_eq!(stack.run(&simulate).1, stdout, "the same again");
    let (_, systems, _) = stack.run(&["get", "systems", "-o", "json"]);
    assert!(!systems.contains("nothing"), "{systems}");
    let log = std::fs::read_to_string(stack.home().join("logs/controller.log"));
    assert!(
        !log.unwrap().contains("no heartbeat"),
        "nothing of it is in the log"
    );
}

#[test]
fn a_simulation_that_does_not_converge_is_1_and_a_fault_that_cannot_be_is_2() {
    let stack = up();
    let simulate = |fault: &str| {
        let args = [
            "plan",
            "--simulate",
            "nothing.xml",
            "--limit",
            "30",
            "--fault",
            fault,
        ];
        stack.run(&args)
    };
    let (code, stdout, stderr) = simulate("controller crashes at 1s");
    assert_eq!(code, 1, "{stdout}{stderr}");
    assert!(
        stdout.contains("undone: controller: it is down"),
        "{stdout}"
    );
    let (code, stdout, stderr) = simulate("agent mars drops");
    assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
    let error = stderr.find("(local), found `mars` at character 7");
    let grammar = stderr.find("help: Faults:\n  agent NODE drops ");
    assert!(error.is_some() && error < grammar, "{stderr}");
    let (code, _, stderr) = stack.run(&["plan", "nothing.xml", "--fault", "agent local drops"]);
    assert_eq!(code, 2, "only with --simulate: {stderr}");
    let (code, _, stderr) = stack.run(&["plan", "--simulate", "nothing.xml", "-o", "dot"]);
    assert_eq!(code, 2, "{stderr}");
}
