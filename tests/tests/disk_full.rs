//! A full disk under `state/`: a clear error, nothing that was acknowledged is lost, and free space is enough to go on.

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Output};

use rts_tests::{Stack, program};

const HELLO: &str = "manifests/hello/system.xml";
const CHANGED: &str = "manifests/hello/changed.xml";

/// Whether this process may mount; elsewhere the test says that it was skipped.
fn may_mount() -> bool {
    let tried = Command::new("unshare")
        .args(["-m", "true"])
        .output()
        .is_ok_and(|o| o.status.success());
    if !tried {
        eprintln!("skipped: needs the right to mount (unshare -m)");
    }
    tried
}

/// Brings the stack up with a small file system of its own on `state/`, which only its daemons see.
fn up_on_small_disk(stack: &Stack) {
    stack.expect(0, &["up"]);
    stack.expect(0, &["down", "--yes"]);
    let script = r#"mount -t tmpfs -o size=3m,mode=700 tmpfs "$RTSCTL_HOME/state" && exec "$0" up"#;
    let mut command = Command::new("unshare");
    command
        .args(["-m", "--propagation", "private", "sh", "-c", script])
        .arg(program("rtsctl"))
        .env("RTSCTL_HOME", stack.home());
    succeeded(&command.output().expect("unshare starts"));
}

/// `rtsctl up` where the agent lives.
fn up_again(stack: &Stack) -> Output {
    let agent = stack.daemons("rts-agent")[0];
    let mut command = Command::new("nsenter");
    command
        .args(["-m", "-t", &agent.to_string()])
        .arg(program("rtsctl"))
        .arg("up")
        .env("RTSCTL_HOME", stack.home());
    command.output().expect("nsenter starts")
}

fn succeeded(output: &Output) {
    assert!(output.status.success(), "{output:?}");
}

/// `state/` as a daemon sees it.
fn state(stack: &Stack, daemon: &str) -> PathBuf {
    let pids = stack.daemons(daemon);
    let home = stack.home();
    let inside = home.strip_prefix("/").expect("an absolute home");
    PathBuf::from(format!("/proc/{}/root", pids[0]))
        .join(inside)
        .join("state")
}

fn fill(file: &PathBuf) {
    let mut file = OpenOptions::new()
        .create_new(true)
        .write(true)
        .open(file)
        .expect("a file to fill the disk");
    let block = [b'x'; 4096];
    // Until nothing more fits, not even a byte.
    while file.write_all(&block).is_ok() {}
    while file.write_all(b"x").is_ok() {}
    let _ = File::sync_all(&file);
}

#[test]
fn a_full_disk_is_told_and_loses_nothing() {
    if !may_mount() {
        return;
    }
    let stack = Stack::new();
    up_on_small_disk(&stack);
    stack.expect(0, &["apply", HELLO]);
    let before = stack.witness();
    let filler = state(&stack, "rts-controller").join("filler");
    fill(&filler);

    let said = stack.rtsctl(&["apply", CHANGED]);
    assert!(said.code != 0, "{said:#?}");
    assert!(said.err.contains("full"), "{said:#?}");
    before.goes_on_undisturbed(&stack);
    assert_eq!(stack.named("systems", "hello")["metadata"]["generation"], 1);

    // What was acknowledged is still there after both have died, though nothing can be written.
    stack.kill_9("rts-controller");
    let up = up_again(&stack);
    before.goes_on_undisturbed(&stack);
    if up.status.success() {
        assert_eq!(stack.named("systems", "hello")["metadata"]["generation"], 1);
    } else {
        let text = String::from_utf8_lossy(&up.stderr).into_owned();
        assert!(text.contains("full"), "{text}");
    }

    let inside = state(&stack, "rts-agent").join("filler");
    std::fs::remove_file(inside).expect("the filler goes");
    succeeded(&up_again(&stack));
    before.goes_on_undisturbed(&stack);
    stack.expect(0, &["apply", CHANGED]);
    assert_eq!(stack.named("systems", "hello")["metadata"]["generation"], 2);
    stack.leaves_nothing();
}
