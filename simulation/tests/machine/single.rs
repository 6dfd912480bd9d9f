//! One thing that goes wrong at a time.

use std::time::Duration;

use futures_util::StreamExt;
use rts_agent_api::AgentApi;
use rts_plan::observed::LifeCycleState;
use rts_simulation::Life;
use rts_simulation::faults::Misbehaviour;
use tokio::time::{sleep, timeout};

use crate::setup::*;

#[tokio::test(start_paused = true)]
async fn an_agent_brings_a_system_up_and_the_next_one_adopts_it() {
    let node = Node::new(1);
    let life = Life::new("node1", 1);
    let agent = node.start(&life).await;
    bring_up(&agent).await;
    let before = until_up(&agent).await;
    assert_eq!(before.len(), 3);
    sleep(Duration::from_secs(5)).await;
    let inventory = agent.api().inventory().await.unwrap();
    let components = inventory.managers.iter().flat_map(|m| &m.components);
    let connectors: Vec<_> = components.flat_map(|c| &c.connectors).collect();
    assert_eq!(connectors.len(), 2);
    assert!(
        connectors.iter().all(|c| c.samples_sent > 100),
        "{connectors:?}"
    );

    // It crashes: nothing of what runs is disturbed, and the next one finds it.
    life.end();
    sleep(Duration::from_secs(1)).await;
    let next = Life::new("node1", 2);
    let agent_2 = node.start(&next).await;
    assert_eq!(until_up(&agent_2).await, before);
    assert_eq!(agent_2.api().node_spec().await.unwrap(), node_spec());
    sleep(Duration::from_secs(30)).await;
    assert_eq!(until_up(&agent_2).await, before, "it had nothing to do");
    drop(agent);
}

#[tokio::test(start_paused = true)]
async fn an_agent_heals_what_breaks_on_its_node() {
    let node = Node::new(2);
    let agent = node.start(&Life::new("node1", 1)).await;
    bring_up(&agent).await;
    let before = until_up(&agent).await;
    let broken = node.machine.kill(Some("hello.print")).unwrap();
    assert_eq!(broken, "hello.print");
    sleep(Duration::from_secs(1)).await;
    let after = until_up(&agent).await;
    assert_eq!(after[..2], before[..2], "the others are not disturbed");
    assert_ne!(after[2], before[2]);
    // A component in Error stays there: nobody asked for more.
    node.machine.misbehave("Sine0", Some(Misbehaviour::Panic));
    sleep(Duration::from_secs(5)).await;
    let inventory = agent.api().inventory().await.unwrap();
    let components = inventory.managers.iter().flat_map(|m| &m.components);
    let errors = components.filter(|c| c.state == LifeCycleState::Error);
    let errors: Vec<_> = errors.map(|c| c.instance.as_str()).collect();
    assert_eq!(errors, ["Sine0"]);
}

#[tokio::test(start_paused = true)]
async fn a_node_that_reboots_starts_what_it_was_told_last() {
    let node = Node::new(3);
    let life = Life::new("node1", 1);
    let agent = node.start(&life).await;
    bring_up(&agent).await;
    let before = until_up(&agent).await;
    life.end();
    node.machine.reboot();
    node.disk.lose_power();
    assert!(node.machine.left_over().processes.is_empty());
    let agent_2 = node.start(&Life::new("node1", 2)).await;
    let after = until_up(&agent_2).await;
    assert_eq!(after.len(), before.len());
    assert!(after.iter().all(|line| !before.contains(line)));
    drop(agent);
}

#[tokio::test(start_paused = true)]
async fn a_crash_anywhere_while_it_comes_up_is_mended_by_the_next_agent() {
    for calls in (1..400).step_by(11) {
        let node = Node::new(calls);
        let life = Life::new("node1", 1);
        let agent = node.start(&life).await;
        agent.api().put_node_spec(&node_spec()).await.unwrap();
        life.burn(calls);
        let first = async {
            let api = agent.api();
            let events = api.run_batch(&up()).await.unwrap();
            events.for_each(async |_| ()).await;
        };
        let _ = timeout(LONG, first).await;
        life.end();
        let agent_2 = node.start(&Life::new("node1", 2)).await;
        let up = until_up(&agent_2).await;
        assert_eq!(up.len(), 3, "{calls}");
        let left = node.machine.left_over();
        assert_eq!(left.processes.len(), 2, "{calls}: {left:?}");
        assert_eq!(left.components.len(), 3, "{calls}: {left:?}");
        drop(agent);
    }
}
