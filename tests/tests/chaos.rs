//! Random faults against real processes, and that whoever watches them does notice.

use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use rts_tests::{alive, processes_of, programs, signal};
use rustix::process::Signal;

/// Seconds of the chaos, unless the environment says otherwise.
const SECONDS: &str = "20";

fn chaos(seconds: &str, more: &[&str]) -> Command {
    let seconds: f64 = seconds.parse().expect("RTSCTL_CHAOS_SECONDS is a number");
    // Programs and modules that it starts lie beside it.
    let mut command = Command::new(programs().join("chaos"));
    command.args(["--seed", "1", "--minutes"]);
    command.arg((seconds / 60.0).to_string()).args(more);
    command.stdin(Stdio::null());
    command
}

fn text(output: &Output) -> String {
    let [out, err] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    format!("{out}{err}")
}

/// The home that it names in its first line.
fn home(text: &str) -> &str {
    let rest = text.split("home ").nth(1).expect("the home");
    rest.lines().next().expect("a line").trim()
}

#[test]
fn nothing_is_violated_and_nothing_is_left() {
    let seconds = std::env::var("RTSCTL_CHAOS_SECONDS");
    let seconds = seconds.unwrap_or_else(|_| SECONDS.to_owned());
    let output = chaos(&seconds, &[]).output().expect("chaos starts");
    let text = text(&output);
    assert_eq!(output.status.code(), Some(0), "{text}");
    let count = |row: &str| -> u64 {
        let mut lines = text.lines();
        let line = lines.find(|l| l.starts_with(row)).expect("a row");
        let last = line.split_whitespace().next_back();
        last.and_then(|n| n.parse().ok()).expect("a number")
    };
    assert_eq!(count("violations"), 0, "{text}");
    assert!(count("faults") > 3, "{text}");
    assert!(count("actions") > 3, "{text}");
    assert!(processes_of(home(&text).as_ref()).is_empty());
    assert!(!std::path::Path::new(home(&text)).exists());
}

/// It breaks an invariant by its own hand after the second round: it must end with 1 and say what.
#[track_caller]
fn is_noticed(sabotage: &str, what: &str) {
    let output = chaos("20", &["--sabotage", sabotage])
        .output()
        .expect("chaos starts");
    let text = text(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    let violated = text
        .split("VIOLATED in round")
        .nth(1)
        .expect("it says what");
    assert!(violated.contains(what), "{text}");
    assert!(violated.contains("of seed 1"), "{text}");
    assert!(violated.contains("round 2"), "what was done: {text}");
    assert!(violated.contains("--seed 1"), "how to do it again: {text}");
    let home = std::path::Path::new(home(&text));
    assert!(processes_of(home).is_empty(), "it ends what it started");
    assert!(home.join("logs").is_dir(), "it keeps the logs");
    let folder = home.parent().expect("the folder of the stack");
    std::fs::remove_dir_all(folder).expect("it goes");
}

#[test]
fn a_second_process_of_a_manager_is_noticed() {
    is_noticed("second-manager", "two live processes of one manager");
}

#[test]
fn the_death_of_a_process_that_nobody_touched_is_noticed() {
    is_noticed("kill", "its process has ended, and nobody touched it");
}

#[test]
fn lost_samples_are_noticed() {
    is_noticed("lose-samples", "lost samples of");
}

#[test]
fn an_acknowledged_apply_that_is_lost_is_noticed() {
    is_noticed("lose-apply", "lost: system");
}

#[test]
fn what_is_left_behind_is_noticed() {
    is_noticed("leave-behind", "forgotten is left behind");
}

#[test]
fn a_signal_ends_all_that_was_started() {
    for (number, code) in [(Signal::TERM, 143), (Signal::INT, 130)] {
        let mut command = chaos("60", &[]);
        let child = command
            .stdout(Stdio::piped())
            .spawn()
            .expect("chaos starts");
        std::thread::sleep(Duration::from_millis(2500));
        let begin = Instant::now();
        signal(child.id(), number);
        let pid = child.id();
        let output = child.wait_with_output().expect("it ends");
        let text = text(&output);
        assert_eq!(output.status.code(), Some(code), "{text}");
        assert!(
            begin.elapsed() < Duration::from_secs(10),
            "{:?}",
            begin.elapsed()
        );
        assert!(!alive(pid));
        assert!(processes_of(home(&text).as_ref()).is_empty());
        assert!(!std::path::Path::new(home(&text)).exists());
    }
}
