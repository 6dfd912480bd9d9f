//! What is remembered of what a manager held, and the end of one.

use std::time::Duration;

use futures_util::future::BoxFuture;
use tokio::time::sleep_until;

use super::*;
use crate::fixtures::agent;
use crate::launch::Exit;
use crate::machine::Signal;
use serde_json::json;

fn holding(incarnations: &[&str]) -> ManagerInventory {
    let component = |incarnation: &&str| {
        json!({"instance": "A0", "typeName": "A", "system": null, "incarnation": incarnation, "recreateHash": "",
            "restarts": 0, "created": "", "state": "Active", "message": null, "sets": {}, "active": "default",
            "executionKind": "periodic", "rate": 1.0, "executions": 0, "ports": [], "connectors": [], "bindings": []})
    };
    let components: Vec<_> = incarnations.iter().map(component).collect();
    serde_json::from_value(json!({"modules": [], "components": components})).unwrap()
}

#[test]
fn a_deleted_component_comes_back_by_no_answer_from_before_but_its_successor_does() {
    let mut seen = Seen::new();
    seen.inventory = holding(&["one"]);
    seen.responsive = false;
    seen.forget("A0");
    assert!(seen.inventory.components.is_empty());
    seen.keep(holding(&["one"]), 0);
    assert!(seen.inventory.components.is_empty() && seen.responsive);
    seen.keep(holding(&["two"]), 0);
    assert_eq!(seen.inventory.components.len(), 1);
    assert!(seen.deleted.is_empty(), "nothing is kept for ever");
}

#[test]
fn what_was_to_be_made_since_it_was_asked_may_be_in_it() {
    let mut seen = Seen::new();
    assert!(seen.may_hold_more());
    seen.keep(holding(&[]), 0);
    assert!(!seen.may_hold_more());
    seen.made += 1;
    assert!(seen.may_hold_more());
    // It was asked before.
    seen.keep(holding(&[]), 0);
    assert!(seen.may_hold_more());
    seen.keep(holding(&["one"]), 1);
    assert!(!seen.may_hold_more());
}

#[test]
fn an_end_is_looked_for_where_it_was_asked_for_until_it_is_shown_and_where_it_is_shown() {
    let mut seen = Seen::new();
    assert!(seen.may_bind("c"), "nothing is known");
    seen.keep(holding(&["one"]), 0);
    assert!(!seen.may_bind("c"));
    seen.bound.insert("c".to_owned());
    seen.keep(holding(&["one"]), 0);
    assert!(seen.may_bind("c"), "it was asked before");
    let mut shown = holding(&["one"]);
    let end = json!({"connector": "c", "port": "in", "connected": false, "samplesReceived": 0, "drops": 0, "gaps": 0});
    shown.components[0].bindings = vec![serde_json::from_value(end).unwrap()];
    seen.keep(shown, 0);
    assert!(seen.bound.is_empty() && seen.may_bind("c"));
    seen.keep(holding(&["one"]), 0);
    assert!(!seen.may_bind("c"));
}

/// A family that dies when it may.
#[derive(Debug, Default)]
struct Stubborn {
    undying: Arc<AtomicBool>,
}

impl Family for Stubborn {
    fn pid(&self) -> u32 {
        4_000_000
    }

    fn has_ended(&self) -> bool {
        true
    }

    fn signal(&self, _: Signal) -> BoxFuture<'_, ()> {
        Box::pin(async {})
    }

    fn end(&self, _: Duration) -> BoxFuture<'_, bool> {
        Box::pin(async { !self.undying.load(Ordering::SeqCst) })
    }
}

#[tokio::test]
async fn while_what_a_manager_started_does_not_die_nothing_is_started_in_its_place() {
    let home = tempfile::tempdir_in("/tmp").unwrap();
    let agent = agent(home.path()).await;
    let key = ManagerKey {
        system: None,
        name: "main".to_owned(),
    };
    let folder = agent.folders.manager(&key);
    std::fs::create_dir(&folder).unwrap();
    let undying = Arc::new(AtomicBool::new(true));
    let family = Box::new(Stubborn {
        undying: undying.clone(),
    });
    let identity = Identity {
        key: key.clone(),
        incarnation: "one".to_owned(),
        family,
        folder: folder.clone(),
    };
    let manager = Manager::new(&agent, identity, None);
    agent.register(
        manager.clone(),
        Box::pin(std::future::ready(Exit::Signal(9))),
    );
    for _ in 0..2 {
        let refused = agent.ensure_manager(&key).await.unwrap_err();
        assert!(
            matches!(refused, StartManagerError::Ending { .. }),
            "{refused}"
        );
        assert!(folder.exists());
    }
    assert_eq!(agent.observe().await.managers, []);
    let reasons = |agent: &Agent| {
        let (_, events) = agent.events.waiting();
        events.into_iter().map(|e| e.reason).collect::<Vec<_>>()
    };
    assert_eq!(reasons(&agent), ["ManagerStuck"]);

    undying.store(false, Ordering::SeqCst);
    manager.ended().await;
    assert!(!folder.exists());
    assert_eq!(reasons(&agent), ["ManagerStuck", "ManagerDied"]);
    let refused = agent.ensure_manager(&key).await.unwrap_err();
    assert!(
        matches!(refused, StartManagerError::Launch(_)),
        "it is tried: {refused}"
    );
}

#[tokio::test]
async fn a_dead_managers_folder_that_cannot_be_removed_is_told_once_and_tried_again_at_a_pace() {
    let home = tempfile::tempdir_in("/tmp").unwrap();
    let agent = agent(home.path()).await;
    let key = ManagerKey {
        system: None,
        name: "main".to_owned(),
    };
    let folder = agent.folders.manager(&key);
    std::fs::create_dir(&folder).unwrap();
    let file = json!({"protocolVersion": 2, "system": null, "name": "main", "incarnation": "one", "pid": 4_000_000,
        "startTicks": 1, "bootId": rts_host::identity::boot_id(), "started": ""});
    std::fs::write(folder.join("manager.json"), file.to_string()).unwrap();
    let undying = Undying::after(None);
    lock(&agent.managers.undying).insert(folder.clone(), undying);
    let refused = agent.ensure_manager(&key).await.unwrap_err();
    assert!(
        matches!(refused, StartManagerError::Ending { .. }),
        "{refused}"
    );
    assert!(folder.exists(), "not before its time");
    sleep_until(undying.next).await;
    assert!(adopt_round(&agent).await);
    assert!(!folder.exists());
    assert!(lock(&agent.managers.undying).is_empty());
    let (_, events) = agent.events.waiting();
    assert!(events.is_empty(), "it was told before: {events:?}");
}
