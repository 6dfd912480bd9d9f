//! The program with a local stack: what it says when the agent is dead, and when nobody reads.

#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::io::Read;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

/// A system of nothing: it needs no modules.
const NOTHING: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:rtsctl:nothing:1.0" rts:version="0.2" rts:creationDate="2026-01-01T00:00:00"
  rts:updateDate="2026-01-01T00:00:00" xmlns:rts="http://www.openrtp.org/namespaces/rts"/>
"#;
/// Longest time for what is to be seen at once.
const SOON: Duration = Duration::from_secs(20);
const STARTS: &str =
    "help: the agent of this machine (node local) does not run: `rtsctl up` starts it again\n";

struct Stack {
    folder: tempfile::TempDir,
}

impl Stack {
    fn up() -> Self {
        let folder = tempfile::Builder::new().prefix("rts").tempdir_in("/tmp");
        let stack = Self {
            folder: folder.unwrap(),
        };
        std::fs::write(stack.folder.path().join("nothing.xml"), NOTHING).unwrap();
        assert_eq!(stack.run(&["up"]).0, 0);
        stack
    }

    fn home(&self) -> PathBuf {
        self.folder.path().join("h")
    }

    fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rtsctl"));
        command
            .args(args)
            .env_clear()
            .env("RTSCTL_HOME", self.home())
            .current_dir(self.folder.path())
            .stdin(Stdio::null());
        command
    }

    /// Runs; gives exit code, stdout and stderr.
    fn run(&self, args: &[&str]) -> (i32, String, String) {
        let output = self.command(args).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (
            output.status.code().unwrap(),
            text(&output.stdout),
            text(&output.stderr),
        )
    }

    fn kill_agent(&self) {
        let text = std::fs::read(self.home().join("run/local/agent.json")).unwrap();
        let identity: serde_json::Value = serde_json::from_slice(&text).unwrap();
        let pid = i32::try_from(identity["pid"].as_i64().unwrap()).unwrap();
        kill_process(Pid::from_raw(pid).unwrap(), Signal::KILL).unwrap();
    }
}

impl Drop for Stack {
    fn drop(&mut self) {
        let _ = self.command(&["down", "--purge", "--yes"]).output();
    }
}

#[test]
fn a_dead_agent_comes_with_what_starts_it_again() {
    let stack = Stack::up();
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
    let stack = Stack::up();
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
    let stack = Stack::up();
    let (code, _, stderr) = stack.run(&["controller", "backup", "no/folder"]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("cannot write no/folder: "), "{stderr}");
}

#[test]
fn a_watch_that_nobody_reads_ends_though_nothing_changes() {
    let stack = Stack::up();
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
