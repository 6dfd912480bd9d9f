//! Starting and stopping the local stack itself.

use std::os::unix::fs::{FileTypeExt, PermissionsExt};
use std::path::Path;
use std::process::{Child, Stdio};

use rts_tests::{Stack, processes_of};

#[path = "stack/nodes.rs"]
mod nodes;

const HELLO: &str = "manifests/hello/system.xml";

#[test]
fn ten_applies_at_once_start_one_controller() {
    let stack = Stack::new();
    let spawn = |_| -> Child {
        stack
            .command(&["apply", HELLO])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("rtsctl starts")
    };
    let applies: Vec<Child> = (0..10).map(spawn).collect();
    let mut starters = 0;
    for apply in applies {
        let output = apply.wait_with_output().expect("rtsctl ends");
        let err = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{err}");
        starters += usize::from(err.contains("started a local controller"));
    }
    assert_eq!(starters, 1, "one of them starts the stack and says so");
    let named = |name: &str| {
        let pids = processes_of(&stack.home());
        let name_of =
            |pid: &u32| std::fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default();
        pids.iter()
            .filter(|pid| name_of(pid).trim() == name)
            .count()
    };
    assert_eq!(named("rts-controller"), 1);
    assert_eq!(named("rts-agent"), 1);
    assert_eq!(stack.get("components").len(), 3);
    stack.leaves_nothing();
}

#[test]
fn everything_lies_under_the_home_and_is_private() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    let mut sockets = 0;
    walk(&stack.home(), &mut |path, metadata| {
        let mode = metadata.permissions().mode() & 0o777;
        assert_eq!(mode & 0o077, 0, "{} has mode {mode:o}", path.display());
        sockets += usize::from(metadata.file_type().is_socket());
    });
    assert_eq!(sockets, 4, "controller, agent, two managers");
    stack.expect(2, &["down"]);
    assert_eq!(
        stack.get("components").len(),
        3,
        "down without --yes touches nothing while a system runs"
    );
    stack.expect(0, &["down", "--yes"]);
    assert!(!stack.home().join("run").exists());
    assert!(stack.home().join("state").exists(), "state outlives down");
    assert!(processes_of(&stack.home()).is_empty());
    stack.expect(0, &["up"]);
    stack.until(
        "components",
        "the system of the kept state runs again",
        |components| {
            components.len() == 3 && components.iter().all(|c| c["status"]["state"] == "Active")
        },
    );
    stack.leaves_nothing();
}

#[test]
fn without_a_controller_a_question_says_how_to_start_one() {
    let stack = Stack::new();
    let said = stack.expect(4, &["get", "components"]);
    insta::assert_snapshot!(said.err);
    assert!(!stack.home().exists(), "a question starts nothing");
}

#[test]
fn a_home_too_long_for_a_socket_is_refused() {
    let stack = Stack::new();
    let long = format!("{}/{}", stack.home().display(), "x".repeat(90));
    let said = stack.expect(2, &["--home", &long, "up"]);
    assert!(said.err.contains("RTSCTL_HOME"), "{said:#?}");
}

#[test]
fn down_works_with_every_daemon_dead() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    for pid in processes_of(&stack.home()) {
        let comm = std::fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default();
        if comm.trim() != "rts-manager" {
            rts_tests::kill(pid);
        }
    }
    stack.leaves_nothing();
}

#[test]
fn daemons_that_were_killed_are_started_again_and_disturb_nothing() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    let incarnations = |stack: &Stack| -> Vec<String> {
        stack
            .get("components")
            .iter()
            .map(|c| c["status"]["incarnation"].to_string())
            .collect()
    };
    let before = incarnations(&stack);
    for pid in processes_of(&stack.home()) {
        let comm = std::fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default();
        if comm.trim() != "rts-manager" {
            rts_tests::kill(pid);
        }
    }
    let said = stack.expect(0, &["apply", HELLO]);
    assert!(said.err.contains("started a local controller"), "{said:#?}");
    assert_eq!(incarnations(&stack), before, "no component restarts");
    stack.leaves_nothing();
}

fn walk(folder: &Path, visit: &mut impl FnMut(&Path, &std::fs::Metadata)) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let metadata = path.symlink_metadata().expect("metadata");
        visit(&path, &metadata);
        if metadata.is_dir() {
            walk(&path, visit);
        }
    }
}
