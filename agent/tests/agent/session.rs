//! What heartbeats carry: the way from the inventory that the controller knows to the one of now.

use std::time::Duration;

use rts_agent_api::AgentApi;
use rts_plan::observed::Inventory;
use rustix::process::Signal;

use crate::fake_controller::FakeController;
use crate::setup::{Node, kill};

/// Without what changes all the time.
fn bare(mut inventory: Inventory) -> Inventory {
    for component in inventory
        .managers
        .iter_mut()
        .flat_map(|m| &mut m.components)
    {
        component.executions = 0;
    }
    inventory
}

#[tokio::test]
async fn deltas_lead_from_the_greeting_to_what_is_there_now() {
    let controller = FakeController::start().await;
    let node = Node::with("", Some(controller.socket())).await;
    let mut known = controller.greeting().await.inventory;
    node.hello().await;
    let up = node.agent.inventory().await.unwrap();
    controller
        .follow(&mut known, |i| i.revision == up.revision)
        .await;
    assert_eq!(bare(known.clone()), bare(up.clone()));

    // Counters alone are no change.
    tokio::time::sleep(Duration::from_millis(1500)).await;
    let same = node.agent.inventory().await.unwrap();
    assert_eq!(same.revision, up.revision);
    assert_ne!(same, up, "executions count");

    kill(up.managers[1].pid, Signal::KILL);
    let left = node.until(|i| i.managers.len() == 1).await;
    controller
        .follow(&mut known, |i| i.revision >= left.revision)
        .await;
    assert_eq!(known.managers.len(), 1);
}

#[tokio::test]
async fn after_a_heartbeat_that_was_not_accepted_all_is_told_again() {
    let controller = FakeController::start().await;
    let node = Node::with("", Some(controller.socket())).await;
    controller.greeting().await;
    node.accept(1).await;
    controller.forget();
    node.hello().await;
    let mut known = controller.greeting().await.inventory;
    let up = node.agent.inventory().await.unwrap();
    // Heartbeats from before the greeting are behind what it told.
    while known.revision < up.revision {
        if let Some(delta) = controller.heartbeat().await.delta
            && delta.from >= known.revision
        {
            assert!(known.advance(delta), "a delta from another revision");
        }
    }
    assert_eq!(bare(known), bare(up));
}
