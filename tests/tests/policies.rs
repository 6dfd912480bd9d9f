//! Restart policies, lost peers and hanging callbacks, as the profile says what happens then.

use rts_tests::{Profile, Stack, kill_9, signal};
use rustix::process::Signal;
use serde_json::Value;

fn of<'a>(components: &'a [Value], name: &str) -> &'a Value {
    let found = components.iter().find(|c| c["metadata"]["name"] == name);
    found.unwrap_or(&Value::Null)
}

fn is(components: &[Value], name: &str, state: &str) -> bool {
    of(components, name)["status"]["state"] == state
}

fn waits(components: &[Value], name: &str, text: &str) -> bool {
    let why = &of(components, name)["status"]["waitingOn"];
    why.as_str().is_some_and(|why| why.contains(text))
}

/// Source → middle → sink in three processes.
fn three(policy: &str) -> Profile {
    Profile::new("three")
        .component("source", "SineSource")
        .with("manager", "a")
        .with("restart", "never")
        .component("middle", "LowPassFilter")
        .with("manager", "b")
        .with("onDisconnect", policy)
        .component("sink", "Printer")
        .with("manager", "c")
        .connect("source.out", "middle.in")
        .connect("middle.out", "sink.in")
}

#[test]
fn never_outlives_the_daemons() {
    let stack = Stack::new();
    let file = stack.write("three.xml", three("keep").xml());
    let file = file.to_string_lossy();
    stack.expect(0, &["apply", &file]);
    let before = stack.witness();
    kill_9(before.of("source").pid);
    stack.until("components", "it is said why it stays away", |components| {
        waits(components, "source", "never")
    });
    for daemons in [
        ["rts-controller"].as_slice(),
        &["rts-agent"],
        &["rts-agent", "rts-controller"],
    ] {
        for daemon in daemons {
            stack.kill_9(daemon);
        }
        stack.expect(0, &["up"]);
        stack.until("components", "it is still said", |components| {
            waits(components, "source", "never") && is(components, "sink", "Active")
        });
    }
    assert_eq!(stack.witness().names(), ["middle", "sink"]);
    let now = stack.witness();
    assert_eq!(
        now.of("middle").info.incarnation,
        before.of("middle").info.incarnation
    );
    stack.expect(1, &["diff", &file]);
    // A change brings it back.
    let changed = three("keep").xml().replace(
        "rtsctl.restart\" rtsExt:value=\"never",
        "rtsctl.restart\" rtsExt:value=\"always",
    );
    let changed = stack.write("changed.xml", changed);
    stack.expect(0, &["apply", &changed.to_string_lossy()]);
    stack.leaves_nothing();
}

#[test]
fn a_lost_peer_deactivates_at_once_and_without_daemons() {
    let stack = Stack::new();
    let file = stack.write("three.xml", three("deactivate").xml());
    stack.expect(0, &["apply", &file.to_string_lossy()]);
    stack.kill_9("rts-controller");
    stack.kill_9("rts-agent");
    let before = stack.witness();
    kill_9(before.of("source").pid);
    stack.until_seen("its manager deactivates it", |now| {
        now.of("middle").info.state == "Inactive"
    });
    assert_eq!(stack.witness().of("sink").info.state, "Active", "it keeps");
    // The source never comes back: so the middle waits for it, and says so.
    stack.expect(0, &["up"]);
    stack.until("components", "it waits for its connector", |components| {
        is(components, "middle", "Inactive") && waits(components, "middle", "onDisconnect")
    });
    stack.leaves_nothing();
}

#[test]
fn a_lost_peer_that_comes_back_brings_all_back() {
    for policy in ["deactivate", "stop"] {
        let stack = Stack::new();
        let profile = three(policy)
            .xml()
            .replace("value=\"never\"", "value=\"always\"");
        let file = stack.write("three.xml", profile);
        stack.expect(0, &["apply", &file.to_string_lossy()]);
        let before = stack.witness();
        kill_9(before.of("sink").pid);
        stack.until("components", "all run again", |components| {
            components.len() == 3
                && components.iter().all(|c| c["status"]["state"] == "Active")
                && of(components, "sink")["status"]["restarts"] == 1
        });
        let after = stack.witness();
        let kept = after.of("middle").info.incarnation == before.of("middle").info.incarnation;
        assert_eq!(kept, policy == "deactivate", "{policy}");
        assert_eq!(
            after.of("middle").pid,
            before.of("middle").pid,
            "its process lives on"
        );
        let events = stack.expect(0, &["events"]).out;
        assert!(events.contains("onDisconnect"), "{events}");
        stack.expect(0, &["diff", &file.to_string_lossy()]);
        stack.leaves_nothing();
    }
}

fn misbehaving(fault: &str, keys: &[(&str, &str)]) -> Profile {
    let profile = Profile::new("misbehaving")
        .component("bad", "Misbehaving")
        .with("manager", "bad")
        .parameter("after", "0")
        .parameter("fault", fault);
    let profile = keys
        .iter()
        .fold(profile, |p, (key, value)| p.with(key, value));
    profile
        .component("good", "SineSource")
        .with("manager", "good")
}

#[test]
fn a_process_that_hangs_is_replaced_when_its_policy_says_so() {
    let stack = Stack::new();
    let profile = misbehaving(
        "hang-execute",
        &[
            ("livenessTimeout", "1s"),
            ("onHang", "restart"),
            ("restartLimit", "1"),
        ],
    );
    let file = stack.write("misbehaving.xml", profile.xml());
    stack.rtsctl(&["apply", &file.to_string_lossy()]);
    // Replaced once, and then the limit holds it back.
    stack.until("components", "the limit holds it back", |components| {
        waits(components, "bad", "restartLimit") && is(components, "good", "Active")
    });
    let events = stack.expect(0, &["events"]).out;
    assert!(events.contains("livenessTimeout"), "{events}");
    assert_eq!(
        of(&stack.get("components"), "good")["status"]["restarts"],
        0
    );
    stack.leaves_nothing();
}

#[test]
fn a_stopped_process_is_replaced_when_its_policy_says_so() {
    let stack = Stack::new();
    let file = stack.write(
        "misbehaving.xml",
        misbehaving("none", &[("livenessTimeout", "1s"), ("onHang", "restart")]).xml(),
    );
    stack.expect(0, &["apply", &file.to_string_lossy()]);
    let before = stack.witness();
    signal(before.of("bad").pid, Signal::STOP);
    stack.until("components", "it runs in another process", |components| {
        is(components, "bad", "Active")
            && of(components, "bad")["status"]["pid"] != before.of("bad").pid
    });
    assert!(!rts_tests::alive(before.of("bad").pid));
    before.without(&["bad"]).goes_on_undisturbed(&stack);
    stack.leaves_nothing();
}

#[test]
fn a_stopped_process_is_told_and_goes_on_when_it_is_continued() {
    let stack = Stack::new();
    let file = stack.write("misbehaving.xml", misbehaving("none", &[]).xml());
    stack.expect(0, &["apply", &file.to_string_lossy()]);
    let before = stack.witness();
    signal(before.of("bad").pid, Signal::STOP);
    stack.until("components", "it is said", |components| {
        waits(components, "bad", "answer")
    });
    let events = stack.expect(0, &["events"]).out;
    assert!(events.contains("ManagerSilent"), "{events}");
    let described = stack.expect(0, &["describe", "component", "bad"]).out;
    assert!(described.contains("does not answer"), "{described}");
    signal(before.of("bad").pid, Signal::CONT);
    stack.until("components", "it runs as before", |components| {
        is(components, "bad", "Active")
    });
    before.goes_on_undisturbed(&stack);
    stack.leaves_nothing();
}

#[test]
fn on_failure_lets_an_orderly_end_be() {
    let stack = Stack::new();
    let file = stack.write(
        "misbehaving.xml",
        misbehaving("none", &[("restart", "on-failure")]).xml(),
    );
    stack.expect(0, &["apply", &file.to_string_lossy()]);
    let before = stack.witness();
    kill_9(before.of("bad").pid);
    stack.until("components", "a failure is healed", |components| {
        is(components, "bad", "Active")
            && of(components, "bad")["status"]["pid"] != before.of("bad").pid
    });
    // SIGTERM is an orderly end: exit status 0.
    signal(stack.witness().of("bad").pid, Signal::TERM);
    stack.until("components", "it stays away", |components| {
        waits(components, "bad", "on-failure")
    });
    before.without(&["bad"]).goes_on_undisturbed(&stack);
    stack.leaves_nothing();
}

#[test]
fn a_component_that_is_slow_to_activate_does_not_keep_another_from_healing() {
    let stack = Stack::new();
    let profile = Profile::new("slow")
        .component("source", "SineSource")
        .with("manager", "a")
        .component("sink", "Printer")
        .with("manager", "b")
        .connect("source.out", "sink.in")
        .component("slow", "Misbehaving")
        .with("manager", "c")
        .parameter("fault", "slow-activate")
        .parameter("seconds", "9");
    let file = stack.write("slow.xml", profile.xml());
    let mut command = stack.command(&["apply", &file.to_string_lossy()]);
    let mut apply = command.spawn().expect("rtsctl starts");
    let before = stack.until_seen("all but one run", |now| {
        now.without(&["slow"]).all_active(2) && now.names().len() == 3
    });
    // The apply still runs, and waits for the slow one.
    std::thread::sleep(std::time::Duration::from_millis(1500));
    kill_9(before.of("sink").pid);
    let after = stack.until_seen("the sink runs again", |now| {
        now.names().contains(&"sink") && now.of("sink").info.state == "Active"
    });
    assert_ne!(after.of("sink").pid, before.of("sink").pid);
    assert_eq!(
        after.of("slow").info.state,
        "Inactive",
        "it was not waited for"
    );
    after.without(&["slow"]).goes_on_undisturbed(&stack);
    assert_eq!(apply.wait().expect("it ends").code(), Some(0));
    stack.leaves_nothing();
}

#[test]
fn a_lost_peer_that_leaves_the_profile_is_waited_for_no_longer() {
    let stack = Stack::new();
    let file = stack.write("three.xml", three("deactivate").xml());
    stack.expect(0, &["apply", &file.to_string_lossy()]);
    kill_9(stack.witness().of("source").pid);
    stack.until("components", "the middle waits", |components| {
        is(components, "middle", "Inactive") && waits(components, "middle", "onDisconnect")
    });
    let without = Profile::new("three")
        .component("middle", "LowPassFilter")
        .with("manager", "b")
        .with("onDisconnect", "deactivate")
        .component("sink", "Printer")
        .with("manager", "c")
        .connect("middle.out", "sink.in");
    let file = stack.write("three.xml", without.xml());
    stack.expect(0, &["apply", &file.to_string_lossy()]);
    assert!(stack.witness().all_active(2));
    stack.leaves_nothing();
}

/// SCHED_FIFO where the machine permits it; where it does not, that is shown.
#[test]
fn what_an_execution_context_has_of_its_node_is_taken_changed_and_shown() {
    let stack = Stack::new();
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let mut lines = status.lines();
    let allowed = lines.find_map(|line| line.strip_prefix("Cpus_allowed_list:"));
    let allowed = allowed.unwrap().trim();
    let first = allowed.split(['-', ',']).next().unwrap();
    let profile = |more: &[(&str, &str)]| {
        let mut profile = Profile::new("real").component("source", "SineSource");
        for (key, value) in more {
            profile = profile.with(&format!("resources.{key}"), value);
        }
        let file = stack.write("real.xml", profile.xml());
        file.to_string_lossy().into_owned()
    };
    let realtime = || of(&stack.get("components"), "source")["status"]["realtime"].clone();

    stack.expect(0, &["apply", &profile(&[("cpus", first)])]);
    let found = realtime();
    assert_eq!(
        (&found["cpus"], &found["scheduler"]),
        (&first.into(), &"SCHED_OTHER".into())
    );
    let before = stack.witness();

    let fifo = profile(&[
        ("cpus", first),
        ("realtimePriority", "5"),
        ("required", "false"),
    ]);
    let plan = stack.expect(1, &["diff", &fifo]);
    assert!(
        plan.out
            .contains("the resources of its execution context changed"),
        "{}",
        plan.out
    );
    stack.expect(0, &["apply", &fifo]);
    let found = realtime();
    let shown = stack.expect(0, &["describe", "component", "source"]).out;
    match found["denied"].as_array() {
        None => {
            assert_eq!(found["scheduler"], "SCHED_FIFO");
            assert!(
                shown.contains(&format!(
                    "SCHED_FIFO 5, processors {first}, memory not locked"
                )),
                "{shown}"
            );
        }
        Some(_) => assert!(
            shown.contains("cannot have SCHED_FIFO priority 5"),
            "{shown}"
        ),
    }
    let (was, is) = (before.of("source"), stack.witness());
    assert_ne!(
        was.info.incarnation,
        is.of("source").info.incarnation,
        "it is made anew"
    );

    // Nothing is done about one that is as desired.
    stack.expect(0, &["diff", &fifo]);
    // No machine has so many: it is refused, and why.
    let refused = stack.expect(5, &["apply", &profile(&[("cpus", "1023")])]);
    assert!(
        refused.err.contains("cannot run on the processors 1023"),
        "{}",
        refused.err
    );
    stack.leaves_nothing();
}
