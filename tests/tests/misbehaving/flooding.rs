//! Too many samples, and too much memory.

use std::time::{Duration, Instant};

use rts_tests::Witness;
use serde_json::Value;

use super::lab::*;

#[test]
fn a_flood_drowns_nobody_and_every_sample_is_accounted_for() {
    let mut lab = Lab::new("flood", &[]);
    lab.apply("0");
    let (before, bystanders) = (lab.stack.witness(), lab.bystanders());
    let flooded = lab.stack.until_seen("many samples are lost", |now| {
        let source = now.of(BAD).info.connectors[0].drops;
        source + now.of("Sink0").info.bindings[0].drops > 10_000
    });
    assert_eq!(flooded.of("Sink0").info.state, "Active");
    lab.stack.until("connectors", "the drops are shown", |all| {
        all.iter().any(|c| {
            c["metadata"]["name"] == "Misbehaving0.out-Sink0.in"
                && c["status"]["drops"].as_u64() > Some(10_000)
        })
    });
    bystanders.goes_on_undisturbed(&lab.stack);
    // Told to stop while it floods, it stops.
    lab.set("none", &[("after", "3600")]);
    lab.apply("0");
    let still = |now: &Witness| {
        let (sent, came) = (
            &now.of(BAD).info.connectors[0],
            &now.of("Sink0").info.bindings[0],
        );
        (
            sent.samples_sent,
            sent.drops + came.drops + came.samples_received,
        )
    };
    // The source sends on, so that the two may differ by what is under way.
    let now = lab
        .stack
        .until_seen("what was sent came or was dropped", |now| {
            let (sent, accounted) = still(now);
            sent.abs_diff(accounted) < 10
        });
    assert_eq!(
        now.of(BAD).info.incarnation,
        before.of(BAD).info.incarnation,
        "a parameter is set in place"
    );
    lab.neighbours_are_kept(&before);
    lab.ends_within(SOON);
}

#[test]
fn what_an_in_port_drops_is_shown_at_its_connector() {
    let lab = Lab::new("error-execute", &[]);
    lab.apply("0|5");
    lab.until("Error", "told to fail on_execute");
    let status = |all: &[Value]| {
        let mut all = all.iter();
        let connector = all.find(|c| c["metadata"]["name"] == "Source0.out-Misbehaving0.in");
        connector.map_or(Value::Null, |c| c["status"].clone())
    };
    // Nobody reads any more: its queue is full, and each new sample drops an old one.
    let seen = lab.stack.until("connectors", "drops are shown", |all| {
        status(all)["drops"].as_u64() > Some(20)
    });
    let [sent, received, drops] =
        ["samplesSent", "samplesReceived", "drops"].map(|key| status(&seen)[key].as_u64());
    let waiting = sent.zip(received).zip(drops);
    let waiting = waiting.map(|((sent, received), drops)| sent - received - drops);
    assert!(waiting <= Some(80), "{seen:#?}");
    lab.ends_within(SOON);
}

#[test]
fn a_leak_is_of_its_own_process() {
    let mut lab = Lab::new("leak", &[]);
    lab.set("leak", &[("after", "0"), ("leak_limit", "48")]);
    lab.apply("0");
    let (before, bystanders) = (lab.stack.witness(), lab.bystanders());
    let leaks = before.of(BAD).pid;
    let deadline = Instant::now() + SOON;
    while memory(leaks) < 48 {
        assert!(Instant::now() < deadline, "{} MiB", memory(leaks));
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(
        memory(before.of("Sink0").pid) < 40,
        "another has no part in it"
    );
    bystanders.goes_on_undisturbed(&lab.stack);
    before.goes_on_undisturbed(&lab.stack);
    assert!(memory(leaks) < 96, "it is bounded: {} MiB", memory(leaks));
    lab.ends_within(SOON);
}

/// MiB of memory that a process holds.
fn memory(pid: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:"));
    let kib = line.and_then(|l| l.split_whitespace().next()?.parse::<u64>().ok());
    kib.unwrap_or(0) / 1024
}
