//! `kill -9` of the daemons, idle and at work: what runs goes on, and what was begun comes to its end.

use std::process::{Child, Stdio};
use std::time::Duration;

use rts_tests::{Profile, Stack, kill_9};
use serde_json::Value;

const HELLO: &str = "manifests/hello/system.xml";
const DAEMONS: [&[&str]; 3] = [
    &["rts-controller"],
    &["rts-agent"],
    &["rts-controller", "rts-agent"],
];

fn all_are(components: &[Value], prefix: &str, state: &str) -> bool {
    let named = |c: &&Value| {
        c["metadata"]["name"]
            .as_str()
            .is_some_and(|n| n.starts_with(prefix))
    };
    let mut own = components.iter().filter(named).peekable();
    own.peek().is_some() && own.all(|c| c["status"]["state"] == state)
}

/// Runs `rtsctl` beside the test, whatever comes of it.
fn begin(stack: &Stack, arguments: &[&str]) -> Child {
    let mut command = stack.command(arguments);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().expect("rtsctl starts")
}

/// Waits until the five components of the slow system are partly Active, partly not or no longer there.
fn until_half(stack: &Stack) {
    for _ in 0..600 {
        let seen = stack.witness().only("slow");
        let states = seen
            .names()
            .into_iter()
            .map(|name| &seen.of(name).info.state);
        let active = states.filter(|state| *state == "Active").count();
        if (1..5).contains(&active) {
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("the slow system never got half-way");
}

#[test]
fn idle_daemons_may_die() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    for daemons in DAEMONS {
        let before = stack.witness();
        assert_eq!(before.names(), ["Filter0", "Printer0", "Sine0"]);
        for daemon in daemons {
            assert_eq!(stack.kill_9(daemon), 1);
        }
        before.goes_on_undisturbed(&stack);
        stack.expect(0, &["up"]);
        stack.until("components", "all are seen again", |components| {
            all_are(components, "", "Active")
        });
        let said = stack.expect(0, &["apply", HELLO]);
        assert!(
            said.err.contains("no changes") || said.out.contains("no changes"),
            "{said:#?}"
        );
        before.goes_on_undisturbed(&stack);
    }
    stack.leaves_nothing();
}

#[test]
fn daemons_may_die_in_the_middle_of_an_apply() {
    for daemons in DAEMONS {
        let stack = Stack::new();
        stack.expect(0, &["apply", HELLO]);
        let others = stack.witness();
        let file = stack.write("slow.xml", Profile::chain("slow", 300).xml());
        let file = file.to_string_lossy();
        let mut apply = begin(&stack, &["apply", &file]);
        until_half(&stack);
        let half = stack.witness().only("slow");
        for daemon in daemons {
            assert_eq!(stack.kill_9(daemon), 1);
        }
        others.goes_on_undisturbed(&stack);
        stack.expect(0, &["up"]);
        stack.expect(0, &["apply", &file]);
        let _ = apply.wait();
        let now = stack.witness();
        assert_eq!(now.names().len(), 8);
        for name in half.names() {
            let (before, after) = (half.of(name), now.of(name));
            assert_eq!(before.pid, after.pid, "{name} was started again");
            assert_eq!(before.info.incarnation, after.info.incarnation, "{name}");
        }
        now.goes_on_undisturbed(&stack);
        others.goes_on_undisturbed(&stack);
        stack.expect(0, &["diff", &file]);
        stack.leaves_nothing();
    }
}

#[test]
fn daemons_may_die_in_the_middle_of_a_teardown() {
    for daemons in DAEMONS {
        let stack = Stack::new();
        stack.expect(0, &["apply", HELLO]);
        let file = stack.write("slow.xml", Profile::chain("slow", 300).xml());
        stack.expect(0, &["apply", &file.to_string_lossy()]);
        let others = stack
            .witness()
            .without(&["slow0", "slow1", "slow2", "slow3", "slow4"]);
        let mut teardown = begin(&stack, &["teardown", "slow", "--yes"]);
        until_half(&stack);
        for daemon in daemons {
            assert_eq!(stack.kill_9(daemon), 1);
        }
        others.goes_on_undisturbed(&stack);
        stack.expect(0, &["up"]);
        stack.until("systems", "the slow system is gone", |systems| {
            systems.iter().all(|s| s["metadata"]["name"] != "slow")
        });
        let _ = teardown.wait();
        assert_eq!(stack.witness().names(), others.names());
        others.goes_on_undisturbed(&stack);
        stack.leaves_nothing();
    }
}

#[test]
fn rtsctl_may_die_in_the_middle() {
    let stack = Stack::new();
    let file = stack.write("slow.xml", Profile::chain("slow", 200).xml());
    let file = file.to_string_lossy();
    let mut apply = begin(&stack, &["apply", &file]);
    until_half(&stack);
    kill_9(apply.id());
    let _ = apply.wait();
    stack.expect(0, &["apply", &file]);
    stack.witness().goes_on_undisturbed(&stack);
    let mut teardown = begin(&stack, &["teardown", "slow", "--yes"]);
    until_half(&stack);
    kill_9(teardown.id());
    let _ = teardown.wait();
    stack.rtsctl(&["teardown", "slow", "--yes"]);
    assert!(stack.get("components").is_empty());
    stack.leaves_nothing();
}

#[test]
fn a_killed_manager_is_healed_and_nothing_else_is_touched() {
    let stack = Stack::new();
    let file = stack.write("chain.xml", Profile::chain("chain", 0).xml());
    stack.expect(0, &["apply", &file.to_string_lossy()]);
    let before = stack.witness();
    // In the middle of the chain: its connectors lead to two other processes.
    kill_9(before.of("chain2").pid);
    let components = stack.until("components", "all run again", |components| {
        all_are(components, "chain", "Active")
            && components.iter().any(|c| c["status"]["restarts"] == 1)
    });
    let count = |c: &Value| c["status"]["restarts"].as_u64();
    let restarts: Vec<Option<u64>> = components.iter().map(count).collect();
    assert_eq!(restarts, [0, 0, 1, 0, 0].map(Some));
    let after = stack.witness();
    for name in ["chain0", "chain1", "chain3", "chain4"] {
        assert_eq!(before.of(name).pid, after.of(name).pid);
        assert_eq!(
            before.of(name).info.incarnation,
            after.of(name).info.incarnation
        );
    }
    assert_ne!(before.of("chain2").pid, after.of("chain2").pid);
    // Both its connectors carry samples again, to the end of the chain.
    after.goes_on_undisturbed(&stack);
    stack.expect(0, &["diff", &file.to_string_lossy()]);
    stack.leaves_nothing();
}
