//! A system on two nodes whose ledgers do not say the same, or whose agents do not say it at the same time.

use std::sync::Arc;
use std::time::Duration;

use crate::fleet::stores::{meets, restored, until};
use crate::fleet::{Cluster, FakeAgent, FakeFleet, systems};
use rts_controller::store::MemoryStore;
use rts_controller_api::objects::{Node, Phase};
use rts_schemas::system::SystemSpec;

/// hello with Printer0 on the robot and nothing between the nodes.
fn on_two_nodes() -> SystemSpec {
    let mut spec = systems::hello();
    spec.connectors.clear();
    spec.orders.activation.clear();
    spec.components[2].placement.node = Some("robot".into());
    spec
}

async fn two_nodes() -> (Cluster, Arc<FakeAgent>, Arc<FakeAgent>) {
    let fleet = FakeFleet::default();
    let types = ["SineSource", "LowPassFilter", "Printer"];
    let (local, robot) = (fleet.add("local", &types), fleet.add("robot", &types));
    let mut cluster = Cluster::start(fleet, MemoryStore::new("cluster"));
    cluster.join("local", "s1");
    cluster.join("robot", "s2");
    (cluster, local, robot)
}

#[tokio::test(start_paused = true)]
async fn a_part_that_is_taken_down_elsewhere_does_not_end_what_lives_here() {
    let (cluster, local, robot) = two_nodes().await;
    cluster.apply(on_two_nodes()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    let old = MemoryStore::holding(cluster.stored());
    let cluster = meets(cluster, MemoryStore::new("stranger"));
    rts_controller::adopt(&cluster.core, "local").await.unwrap();
    let stranger = MemoryStore::holding(cluster.stored());
    let fleet = cluster.fleet.clone();
    drop(cluster);
    // The old controller takes hello down on the robot, and does not come to an end.
    let mut cluster = Cluster::start(fleet.clone(), old);
    cluster.join("robot", "old");
    cluster.join("local", "old");
    robot.fail("StopManager manager/hello.Printer0", 99);
    rts_controller::delete(&cluster.core, "hello", None)
        .await
        .unwrap();
    tokio::time::sleep(Duration::from_secs(2)).await;
    drop(cluster);
    let mut cluster = Cluster::start(fleet, stranger);
    cluster.join("local", "new");
    cluster.join("robot", "new");
    tokio::time::sleep(Duration::from_secs(5)).await;
    let before = local.incarnations();
    assert!(before.contains_key("Sine0"));
    assert_eq!(robot.inventory_now().managers.len(), 1);
    let refused = rts_controller::adopt(&cluster.core, "robot").await;
    let refused = refused.unwrap_err();
    assert_eq!(
        (refused.status, refused.code.as_str()),
        (409, "terminating")
    );
    tokio::time::sleep(Duration::from_secs(10)).await;
    assert_eq!(local.incarnations(), before);
}

/// Printer0 was moved from the robot, which was away, to the local node. The store is restored from before all of it.
async fn the_newer_ledger_wins(first: &str, second: &str) {
    let (cluster, local, robot) = two_nodes().await;
    let backup = cluster.stored();
    cluster.apply(on_two_nodes()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    robot.silence(true);
    tokio::time::sleep(Duration::from_secs(5)).await;
    let mut newer = on_two_nodes();
    newer.components[2].placement.node = None;
    cluster.apply(newer).await;
    until(|| local.ledger().unwrap().generation == 2).await;
    robot.silence(false);
    robot.take_done();
    let fleet = cluster.fleet.clone();
    drop(cluster);
    let mut cluster = Cluster::start(fleet, restored(backup, 2, false));
    cluster.join(first, "next");
    tokio::time::sleep(Duration::from_secs(8)).await;
    cluster.join(second, "next");
    cluster.until_phase("hello", Phase::Converged).await;
    until(|| robot.incarnations().is_empty()).await;
    assert!(local.incarnations().contains_key("Printer0"));
    let stored = cluster.stored().systems["hello"].clone();
    assert_eq!(stored.generation, 2);
    assert_eq!(stored.spec.components[2].placement.node, None);
}

#[tokio::test(start_paused = true)]
async fn the_newer_of_two_ledgers_wins_when_it_is_taken_in_first() {
    the_newer_ledger_wins("local", "robot").await;
}

#[tokio::test(start_paused = true)]
async fn the_newer_of_two_ledgers_wins_when_it_is_taken_in_last() {
    the_newer_ledger_wins("robot", "local").await;
}

/// All of it is moved to the local node after a restore, by a user who does not wait for the robot.
async fn what_was_applied_since_holds(backed_up: bool) {
    let (cluster, local, robot) = two_nodes().await;
    let nothing = cluster.stored();
    let mut there = on_two_nodes();
    for component in &mut there.components {
        component.placement.node = Some("robot".into());
    }
    cluster.apply(there.clone()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    let backup = if backed_up { cluster.stored() } else { nothing };
    there.components[0].execution_context.rate = Some(25.0);
    cluster.apply(there).await;
    cluster.until_phase("hello", Phase::Converged).await;
    let fleet = cluster.fleet.clone();
    drop(cluster);
    let mut cluster = Cluster::start(fleet, restored(backup, 2, false));
    cluster.join("local", "next");
    tokio::time::sleep(Duration::from_secs(8)).await;
    let mut here = on_two_nodes();
    here.components[2].placement.node = None;
    cluster.apply(here.clone()).await;
    tokio::time::sleep(Duration::from_secs(8)).await;
    cluster.join("robot", "next");
    cluster.until_phase("hello", Phase::Converged).await;
    until(|| robot.incarnations().is_empty()).await;
    assert!(local.incarnations().contains_key("Printer0"));
    assert_eq!(*cluster.stored().systems["hello"].spec, here);
    assert!(cluster.stored().systems["hello"].generation > u64::from(backed_up));
}

#[tokio::test(start_paused = true)]
async fn what_was_applied_after_a_restore_holds_against_a_ledger_of_before() {
    what_was_applied_since_holds(true).await;
    what_was_applied_since_holds(false).await;
}

#[tokio::test(start_paused = true)]
async fn an_agent_that_does_not_tell_its_ledger_holds_up_only_its_node() {
    let (cluster, local, robot) = two_nodes().await;
    cluster.apply(on_two_nodes()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    let backup = cluster.stored();
    let mut changed = on_two_nodes();
    changed.components[2].execution_context.rate = Some(25.0);
    cluster.apply(changed).await;
    cluster.until_phase("hello", Phase::Converged).await;
    robot.deafen("ledger", true);
    let told = robot.ledger();
    let mut cluster = meets(cluster, restored(backup, 2, false));
    cluster.join("robot", "next");
    tokio::time::sleep(Duration::from_secs(7)).await;
    local.kill("hello.main");
    let began = tokio::time::Instant::now();
    until(|| local.incarnations().contains_key("Sine0")).await;
    assert!(
        began.elapsed() < Duration::from_secs(2),
        "{:?}",
        began.elapsed()
    );
    assert_eq!(robot.ledger(), told, "nothing is sent meanwhile");
    let status = cluster.core.view.get::<Node>("robot").unwrap().status;
    assert_eq!(status.state, "NotReady");
    robot.deafen("ledger", false);
    cluster.until_phase("hello", Phase::Converged).await;
    until(|| robot.ledger().unwrap().epoch == 2).await;
}
