//! The program at its edges: exit codes and messages where no daemon runs.

#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::path::Path;
use std::process::{Command, Output, Stdio};

#[path = "edge/convert.rs"]
mod convert;

const NO_PORT: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:v:edge:1.0" rts:version="0.2"
  xmlns:rts="http://www.openrtp.org/namespaces/rts">
"#;

#[path = "edge/profiles.rs"]
mod profiles;

struct Edge {
    folder: tempfile::TempDir,
}

impl Edge {
    fn new() -> Self {
        Self {
            folder: tempfile::tempdir().unwrap(),
        }
    }

    fn home(&self) -> std::path::PathBuf {
        self.folder.path().join("h")
    }

    fn command(&self, program: &Path) -> Command {
        let mut command = Command::new(program);
        command
            .env_clear()
            .env("RTSCTL_HOME", self.home())
            .current_dir(self.folder.path())
            .stdin(Stdio::null());
        command
    }

    /// Runs; gives exit code, stdout and stderr.
    fn run(&self, args: &[&str]) -> (i32, String, String) {
        let program = Path::new(env!("CARGO_BIN_EXE_rtsctl"));
        self.said(self.command(program).args(args).output().unwrap())
    }

    fn said(&self, output: Output) -> (i32, String, String) {
        let folder = self.folder.path().to_str().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).replace(folder, "DIR");
        (
            output.status.code().unwrap(),
            text(&output.stdout),
            text(&output.stderr),
        )
    }
}

#[test]
fn verbs_that_start_nothing_say_how_to_start() {
    let edge = Edge::new();
    let hello = include_str!("../../manifests/hello/system.xml");
    std::fs::write(edge.folder.path().join("hello.xml"), hello).unwrap();
    for args in [
        &["get", "components"][..],
        &["logs", "Sine0"],
        &["teardown", "hello", "--yes"],
        &["manager", "list"],
        &["events"],
        &["describe", "component/Sine0"],
        &["diff", "hello.xml"],
        &["plan", "hello.xml"],
        &["apply", "--dry-run", "hello.xml"],
    ] {
        let (code, stdout, stderr) = edge.run(args);
        assert_eq!((code, stdout.as_str()), (4, ""), "{args:?}");
        insta::allow_duplicates! {
            insta::assert_snapshot!(stderr, @r"
            error: no controller is running in DIR/h
            help: start one with `rtsctl up`
            ");
        }
    }
    assert!(!edge.home().exists(), "looking made the home");
}

#[test]
fn a_controller_that_was_named_and_is_not_there_is_unreachable_and_none_is_started() {
    let edge = Edge::new();
    let (code, _, stderr) = edge.run(&["get", "nodes", "--controller", "nobody.sock"]);
    assert_eq!(code, 4);
    assert!(stderr.contains("nobody.sock"), "{stderr}");
    let (code, _, _) = edge.run(&["up", "--controller", "nobody.sock"]);
    assert_eq!(code, 2);
    assert!(!edge.home().exists());
}

#[test]
fn wrong_usage_is_2() {
    let edge = Edge::new();
    for args in [
        &[][..],
        &["aply"],
        &["apply"],
        &["apply", "x", "--timeout", "soon"],
        &["get", "robots"],
        &["describe", "component"],
        &["describe", "robot/R2"],
        &["manager", "create", "?x=1"],
        &["apply", "-", "-f", "-"],
        &["apply", "x", "-o", "json"],
        &["apply", "x", "--steps"],
    ] {
        let (code, stdout, _) = edge.run(args);
        assert_eq!((code, stdout.as_str()), (2, ""), "{args:?}");
    }
}

#[test]
fn a_home_that_is_too_long_names_the_variable() {
    let edge = Edge::new();
    let long = format!("/tmp/{}", "h".repeat(100));
    let (code, _, stderr) = edge.run(&["up", "--home", &long]);
    assert_eq!(code, 2);
    assert!(stderr.contains("RTSCTL_HOME"), "{stderr}");
    assert!(!Path::new(&long).exists());
}

#[test]
fn a_file_that_cannot_be_read_or_is_no_profile_is_3_and_starts_nothing() {
    let edge = Edge::new();
    let (code, _, stderr) = edge.run(&["apply", "nothing.xml"]);
    assert_eq!(code, 3);
    insta::assert_snapshot!(stderr, @"error: cannot read nothing.xml: No such file or directory (os error 2)");
    std::fs::write(edge.folder.path().join("cut.xml"), NO_PORT).unwrap();
    for verb in ["apply", "diff", "plan"] {
        let (code, stdout, stderr) = edge.run(&[verb, "cut.xml"]);
        assert_eq!((code, stdout.as_str()), (3, ""), "{verb}");
        assert!(stderr.starts_with("error["), "{stderr}");
        assert!(
            stderr.ends_with("cut.xml cannot be deployed: 1 error\n"),
            "{stderr}"
        );
    }
    assert!(!edge.home().exists());
}

#[test]
fn down_where_nothing_runs_is_done_at_once() {
    let edge = Edge::new();
    let (code, stdout, _) = edge.run(&["down", "--purge"]);
    assert_eq!(code, 0);
    assert_eq!(stdout, "nothing was running: there is no DIR/h\n");
    std::fs::create_dir_all(edge.home().join("run")).unwrap();
    let (code, stdout, _) = edge.run(&["down", "--purge"]);
    assert_eq!((code, stdout.as_str()), (0, "nothing was running\n"));
    assert!(!edge.home().exists());
}

#[test]
fn programs_that_are_not_beside_it_are_named() {
    let edge = Edge::new();
    let alone = edge.folder.path().join("rtsctl");
    std::fs::copy(env!("CARGO_BIN_EXE_rtsctl"), &alone).unwrap();
    let (code, _, stderr) = edge.said(edge.command(&alone).arg("up").output().unwrap());
    assert_eq!(code, 4);
    insta::assert_snapshot!(stderr, @r"
    error: cannot start DIR/rts-controller: No such file or directory (os error 2)
    help: rtsctl looks for the other programs beside itself: `cargo build --workspace` builds them
    ");
}

#[test]
fn a_reader_that_goes_away_is_no_error_message() {
    let edge = Edge::new();
    let program = Path::new(env!("CARGO_BIN_EXE_rtsctl"));
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let output = edge
        .command(program)
        .args(["completion", "bash"])
        .stdout(writer)
        .stderr(Stdio::piped())
        .output()
        .unwrap();
    assert_eq!(edge.said(output), (141, String::new(), String::new()));
}

#[test]
fn colour_is_only_where_it_is_wanted() {
    let edge = Edge::new();
    let (_, _, plain) = edge.run(&["get", "nodes"]);
    let (_, _, colored) = edge.run(&["get", "nodes", "--color", "always"]);
    assert!(!plain.contains('\u{1b}'));
    assert!(colored.contains('\u{1b}'));
}

#[test]
fn an_empty_variable_counts_as_none() {
    let edge = Edge::new();
    let program = Path::new(env!("CARGO_BIN_EXE_rtsctl"));
    let mut command = edge.command(program);
    command
        .env("RTSCTL_HOME", "")
        .env("RTSCTL_CONTROLLER", "")
        .env("XDG_STATE_HOME", edge.folder.path())
        .env("HOME", edge.folder.path());
    let said = edge.said(command.args(["get", "nodes"]).output().unwrap());
    assert_eq!(said.0, 4);
    assert!(
        said.2.contains("no controller is running in DIR/rtsctl"),
        "{said:?}"
    );
}

#[test]
fn a_home_that_cannot_be_made_is_2() {
    let edge = Edge::new();
    std::fs::write(edge.home(), "a file").unwrap();
    let below = edge.home().join("x");
    let (code, _, stderr) = edge.run(&["up", "--home", below.to_str().unwrap()]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("RTSCTL_HOME"), "{stderr}");
}

#[test]
fn a_variable_that_is_set_is_no_part_of_a_usage_line() {
    let edge = Edge::new();
    let (code, _, stderr) = edge.run(&["logs"]);
    assert_eq!(code, 2);
    assert!(
        stderr.contains("Usage: rtsctl logs <NAME>...\n"),
        "{stderr}"
    );
}

#[test]
fn what_cannot_be_restored_is_said_once() {
    let edge = Edge::new();
    let (code, _, stderr) = edge.run(&["controller", "restore", "nothing.json", "--yes"]);
    assert_eq!(code, 3);
    insta::assert_snapshot!(stderr, @"error: cannot read DIR/nothing.json: No such file or directory (os error 2)");
    std::fs::write(edge.folder.path().join("cut.json"), "{").unwrap();
    let (code, _, stderr) = edge.run(&["controller", "restore", "cut.json", "--yes"]);
    assert_eq!(code, 3);
    insta::assert_snapshot!(stderr, @"error: cannot restore DIR/cut.json: it is damaged or no backup at all: EOF while parsing an object at line 1 column 1");
    assert!(!edge.home().exists());
}
