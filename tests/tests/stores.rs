//! Controllers whose store is lost, older, restored or another: nothing that runs is ever harmed by them.

use std::path::PathBuf;

use rts_tests::{Profile, Stack, processes_of};

const HELLO: &str = "manifests/hello/system.xml";
const CHANGED: &str = "manifests/hello/changed.xml";

fn store(stack: &Stack) -> PathBuf {
    stack.home().join("state/controller.redb")
}

/// Runs `rtsctl up` and waits until the controller has heard of the node.
fn up(stack: &Stack, state: &str) {
    stack.expect(0, &["up"]);
    stack.until("nodes", state, |nodes| {
        nodes.iter().any(|n| n["status"]["state"] == state)
    });
}

fn until_healthy(stack: &Stack, system: &str) {
    stack.until("systems", "it is healthy", |systems| {
        let found = systems.iter().find(|s| s["metadata"]["name"] == system);
        found.is_some_and(|s| s["status"]["healthy"] == true && s["status"]["synced"] == true)
    });
}

fn back_up(stack: &Stack) -> (PathBuf, String) {
    let backup = stack.home().with_file_name("backup.json");
    let file = backup.to_string_lossy().into_owned();
    stack.expect(0, &["controller", "backup", &file]);
    (backup, file)
}

#[test]
fn a_fresh_controller_touches_nothing_until_it_is_told_to_adopt() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    let before = stack.witness();
    stack.kill_9("rts-controller");
    std::fs::remove_file(store(&stack)).expect("the store is lost");
    up(&stack, "NotReady");
    let node = stack.named("nodes", "local").to_string();
    assert!(
        node.contains("ForeignLedger") && node.contains("adopt"),
        "{node}"
    );
    assert!(stack.get("systems").is_empty());
    let said = stack.rtsctl(&["apply", HELLO, "--timeout", "5s"]);
    assert_ne!(said.code, 0, "{said:#?}");
    before.goes_on_undisturbed(&stack);

    stack.rtsctl(&["teardown", "hello", "--yes"]);
    before.goes_on_undisturbed(&stack);
    stack.leaves_nothing();
}

#[test]
fn a_fresh_controller_adopts_what_runs() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    let before = stack.witness();
    stack.kill_9("rts-controller");
    std::fs::remove_file(store(&stack)).expect("the store is lost");
    up(&stack, "NotReady");
    stack.expect(0, &["controller", "adopt", "local"]);
    until_healthy(&stack, "hello");
    before.goes_on_undisturbed(&stack);
    stack.expect(0, &["diff", HELLO]);
    stack.expect(0, &["apply", HELLO]);
    before.goes_on_undisturbed(&stack);
    stack.expect(0, &["teardown", "hello", "--yes"]);
    stack.leaves_nothing();
}

#[test]
fn a_fresh_controller_takes_over_when_told_so() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    stack.kill_9("rts-controller");
    std::fs::remove_file(store(&stack)).expect("the store is lost");
    up(&stack, "NotReady");
    let said = stack.rtsctl(&["controller", "take-over", "local"]);
    assert_eq!(said.code, 2, "it asks for --yes: {said:#?}");
    stack.expect(0, &["controller", "take-over", "local", "--yes"]);
    stack.until("managers", "its empty set is obeyed", |managers| {
        managers.is_empty()
    });
    stack.expect(0, &["apply", HELLO]);
    stack.leaves_nothing();
}

#[test]
fn a_store_that_is_put_back_by_hand_harms_nothing() {
    let stack = Stack::new();
    stack.expect(0, &["up"]);
    stack.kill_9("rts-controller");
    let old = std::fs::read(store(&stack)).expect("the store");
    stack.expect(0, &["apply", HELLO]);
    let before = stack.witness();
    stack.kill_9("rts-controller");
    // It knows of no system, and numbers its node specs anew.
    std::fs::write(store(&stack), old).expect("the store is put back");
    up(&stack, "Ready");
    stack.until("systems", "what runs is known again", |systems| {
        systems
            .iter()
            .any(|s| s["metadata"]["name"] == "hello" && s["status"]["synced"] == true)
    });
    before.goes_on_undisturbed(&stack);
    stack.expect(0, &["diff", HELLO]);
    stack.leaves_nothing();
}

#[test]
fn a_backup_is_restored_while_everything_runs() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    let before = stack.witness();
    let (_, file) = back_up(&stack);
    assert_eq!(
        stack.rtsctl(&["controller", "restore", &file]).code,
        2,
        "it needs --yes"
    );
    // With a live controller, with a dead one, and without a store; twice each from the same backup.
    for lost in [false, true, true] {
        if lost {
            stack.kill_9("rts-controller");
            std::fs::remove_file(store(&stack)).expect("the store is lost");
        }
        stack.expect(0, &["controller", "restore", &file, "--yes"]);
        up(&stack, "Ready");
        until_healthy(&stack, "hello");
        before.goes_on_undisturbed(&stack);
        stack.expect(0, &["diff", HELLO]);
    }
    // The restored controller is obeyed.
    stack.expect(0, &["apply", CHANGED]);
    stack.expect(0, &["teardown", "hello", "--yes"]);
    stack.leaves_nothing();
}

#[test]
fn what_happened_since_the_backup_is_not_undone() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    let (_, file) = back_up(&stack);
    stack.expect(0, &["teardown", "hello", "--yes"]);
    let chain = stack.write("chain.xml", Profile::chain("chain", 0).xml());
    stack.expect(0, &["apply", &chain.to_string_lossy()]);
    let before = stack.witness();
    stack.expect(0, &["controller", "restore", &file, "--yes"]);
    up(&stack, "Ready");
    until_healthy(&stack, "chain");
    before.goes_on_undisturbed(&stack);
    assert_eq!(stack.witness().names(), before.names(), "hello stays down");
    assert_eq!(stack.get("systems").len(), 1);
    let events = stack.expect(0, &["events"]).out;
    assert!(events.contains("TornDownSinceBackup"), "{events}");
    stack.expect(0, &["diff", &chain.to_string_lossy()]);
    stack.leaves_nothing();
}

#[test]
fn a_damaged_backup_is_refused_before_anything_is_touched() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    let before = stack.witness();
    let (backup, file) = back_up(&stack);
    let good = std::fs::read_to_string(&backup).expect("the backup");
    for bad in [
        good.replacen("Sine0", "Sine1", 1),
        good[..good.len() / 2].to_owned(),
        "{}".to_owned(),
    ] {
        std::fs::write(&backup, bad).expect("written");
        let said = stack.expect(3, &["controller", "restore", &file, "--yes"]);
        assert!(said.err.contains("backup"), "{said:#?}");
        assert_eq!(
            stack.daemons("rts-controller").len(),
            1,
            "it was not even stopped"
        );
    }
    before.goes_on_undisturbed(&stack);
    stack.leaves_nothing();
}

#[test]
fn a_teardown_without_the_agent_leaves_a_tombstone() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    stack.kill_9("rts-agent");
    stack.until("nodes", "the node is unknown", |nodes| {
        nodes.iter().all(|n| n["status"]["state"] == "Unknown")
    });
    let said = stack.expect(5, &["teardown", "hello", "--yes"]);
    assert!(said.err.contains("--forget-node"), "{said:#?}");
    assert_eq!(
        stack.named("systems", "hello")["status"]["phase"],
        "Terminating"
    );

    // The node comes back and what it runs is torn down after all.
    stack.expect(0, &["up"]);
    stack.until("systems", "the system is gone", |systems| {
        systems.is_empty()
    });
    assert!(stack.witness().names().is_empty());

    // Forgotten instead: it is gone at once, and ends on the node as soon as it is back.
    stack.expect(0, &["apply", HELLO]);
    stack.kill_9("rts-agent");
    stack.until("nodes", "the node is unknown", |nodes| {
        nodes.iter().all(|n| n["status"]["state"] == "Unknown")
    });
    stack.expect(0, &["teardown", "hello", "--yes", "--forget-node", "local"]);
    assert!(stack.get("systems").is_empty());
    assert_eq!(
        processes_of(&stack.home()).len(),
        3,
        "a controller and two managers"
    );
    stack.expect(0, &["up"]);
    stack.until("managers", "they are ended", |managers| managers.is_empty());
    stack.until("nodes", "the node is ready", |nodes| {
        nodes.iter().all(|n| n["status"]["state"] == "Ready")
    });
    assert!(stack.witness().names().is_empty());
    stack.leaves_nothing();
}
