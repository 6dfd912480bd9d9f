//! Smoke tests that are ended before they have ended.

use std::io::{BufRead, BufReader, Read};
use std::process::Child;

use rts_tests::{Stack, signal};
use rustix::process::Signal;

use super::{HELLO, home, leaves_nothing, smoke, start};

/// Reads its messages up to the one that contains this.
#[track_caller]
fn until(child: &mut Child, part: &str) -> (BufReader<std::process::ChildStderr>, String) {
    let mut stderr = BufReader::new(child.stderr.take().expect("stderr"));
    let mut text = String::new();
    while !text.contains(part) {
        let read = stderr.read_line(&mut text).expect("a line");
        assert!(read > 0, "it ended without {part:?}: {text}");
    }
    (stderr, text)
}

/// Ended by a signal once it has said so much.
#[track_caller]
fn stopped(by: Signal, after: &str) {
    let stack = Stack::new();
    let mut child = start(&stack, &[HELLO]);
    let (mut stderr, mut text) = until(&mut child, after);
    signal(child.id(), by);
    stderr.read_to_string(&mut text).expect("the rest");
    let status = child.wait().expect("it ends");
    assert_eq!(status.code(), Some(130), "{text}");
    assert!(text.contains("taking the stack down"), "{text}");
    leaves_nothing(&home(&text));
    assert!(!stack.home().exists());
}

#[test]
fn ctrl_c_takes_the_stack_down() {
    stopped(Signal::INT, "check apply passed");
}

#[test]
fn ctrl_c_while_it_starts_leaves_nothing() {
    stopped(Signal::INT, "rtsctl: smoke test of");
}

#[test]
fn the_end_of_a_job_takes_the_stack_down() {
    stopped(Signal::TERM, "check samples passed");
}

#[test]
fn one_that_was_killed_is_tidied_up_as_it_said_and_disturbs_no_other() {
    let stack = Stack::new();
    let mut child = start(&stack, &[HELLO]);
    let (_stderr, text) = until(&mut child, "check samples passed");
    child.kill().expect("it lives");
    child.wait().expect("it ends");
    let left = home(&text);
    assert!(left.join("run").exists());
    smoke(&stack, 0, &[HELLO, "--no-faults", "--steady", "10ms"]);
    let home = left.display().to_string();
    let command = ["--home", &home, "down", "--purge", "--yes"];
    assert!(text.contains(&command.join(" ")), "{text}");
    stack.expect(0, &command);
    leaves_nothing(&left);
}
