//! What agents tell with their heartbeats is believed, and asked for where it does not fit.

use std::time::Duration;

use crate::fleet::{Cluster, FakeAgent, greeting, systems};
use rts_agent_api::session::Heartbeat;
use rts_controller_api::objects::Phase;
use rts_plan::observed::{Inventory, LifeCycleState};

/// One heartbeat with what changed since an earlier inventory.
fn tell(cluster: &Cluster, agent: &FakeAgent, since: &Inventory) {
    let now = agent.inventory_now();
    let beat = Heartbeat {
        inventory_revision: now.revision,
        delta: Some(now.since(since)),
        events: Vec::new(),
    };
    rts_controller::heartbeat(&cluster.core, "local", "told", beat).unwrap();
}

/// Lets the loop look, and gives the number of questions that it had.
async fn asked(agent: &FakeAgent) -> u32 {
    agent.state.lock().unwrap().asked = 0;
    tokio::time::sleep(Duration::from_millis(300)).await;
    agent.state.lock().unwrap().asked
}

#[tokio::test(start_paused = true)]
async fn the_loop_believes_deltas_and_asks_where_one_is_missing() {
    let (cluster, agent) = Cluster::hello();
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    // From here on this test is the agent's heart.
    rts_controller::greet(&cluster.core, "local", greeting(&agent, "told")).unwrap();
    asked(&agent).await;

    let before = agent.inventory_now();
    agent.change("Sine0", |c| c.restarts = 3);
    tell(&cluster, &agent, &before);
    assert_eq!(asked(&agent).await, 0, "it was told");
    assert_eq!(cluster.component("Sine0").status.restarts, 3);
    tell(&cluster, &agent, &before);
    assert_eq!(asked(&agent).await, 0, "and once more");

    agent.change("Sine0", |c| c.restarts = 4);
    let lost = agent.inventory_now();
    agent.change("Printer0", |c| c.restarts = 7);
    tell(&cluster, &agent, &lost);
    assert!(asked(&agent).await > 0, "a delta is missing");
    assert_eq!(cluster.component("Sine0").status.restarts, 4);
    assert_eq!(cluster.component("Printer0").status.restarts, 7);

    // What changes by itself is mended from what was told.
    let before = agent.inventory_now();
    agent.change("Sine0", |c| c.state = LifeCycleState::Inactive);
    tell(&cluster, &agent, &before);
    cluster
        .until("hello", |s| s.unwrap().status.phase != Phase::Converged)
        .await;
    cluster.until_phase("hello", Phase::Converged).await;
    assert_eq!(cluster.component("Sine0").status.state, "Active");
}

#[tokio::test(start_paused = true)]
async fn all_is_asked_for_on_the_slow_tick() {
    let (cluster, agent) = Cluster::hello();
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    // A counter raises no revision, and no heartbeat tells of it.
    tokio::time::sleep(Duration::from_secs(1)).await;
    agent.count();
    agent.state.lock().unwrap().asked = 0;
    tokio::time::sleep(Duration::from_secs(12)).await;
    let asked = agent.state.lock().unwrap().asked;
    assert!((2..=4).contains(&asked), "{asked} times");
    assert_eq!(cluster.component("Sine0").status.executions, 1);
}
