//! Systems that are changed at the same time do not disturb each other.

use std::time::Duration;

use crate::fleet::systems::{component, connector, hello};
use crate::fleet::{Cluster, FakeAgent};
use rts_controller_api::objects::Phase;
use rts_schemas::system::SystemSpec;
use tokio::time::Instant;

/// Names of the two.
const BOTH: [&str; 2] = ["hello", "other"];

fn other() -> SystemSpec {
    SystemSpec {
        composites: Vec::new(),
        name: "other".into(),
        full_id: "RTSystem:rtsctl:other:1.0".into(),
        components: vec![
            component("Sine1", "SineSource"),
            component("Filter1", "LowPassFilter"),
        ],
        connectors: vec![connector("Sine1.out", "Filter1.in")],
        orders: Default::default(),
    }
}

/// Applies the second so long after the first: both go on to their end, and nothing of either counts as failed.
async fn apply_both(offset: Duration, how: impl FnOnce(&FakeAgent)) {
    let (cluster, agent) = Cluster::hello();
    agent.slow(Duration::from_millis(20));
    how(&agent);
    cluster.apply(hello()).await;
    tokio::time::sleep(offset).await;
    cluster.apply(other()).await;
    let began = Instant::now();
    let mut changes = cluster.core.view.subscribe();
    loop {
        let systems = BOTH.map(|name| cluster.system(name).unwrap());
        for system in &systems {
            let status = &system.status;
            let waiting = status.waiting_on.iter();
            let tried = waiting.filter(|w| w.tries > 0 || !w.transient).count();
            let well = status.phase != Phase::Degraded && tried == 0;
            assert!(well, "after {offset:?}: {status:#?}");
        }
        if systems.iter().all(|s| s.status.phase == Phase::Converged) {
            break;
        }
        let change = tokio::time::timeout(Duration::from_secs(30), changes.changed());
        change.await.unwrap().unwrap();
    }
    let took = began.elapsed();
    assert!(
        took < Duration::from_secs(2),
        "after {offset:?} it took {took:?}"
    );
    assert_eq!(cluster.core.backoff().failing().count(), 0);
    let events = cluster.events();
    let mut failed = events.iter().filter(|e| e.spec.reason.ends_with("Failed"));
    assert!(failed.next().is_none(), "after {offset:?}");
}

fn offsets() -> impl Iterator<Item = Duration> {
    (0..40).map(|n| Duration::from_millis(7 * n))
}

#[tokio::test(start_paused = true)]
async fn a_step_that_finds_the_node_spec_replaced_has_not_failed() {
    for offset in offsets() {
        apply_both(offset, |agent| {
            agent.state.lock().unwrap().hears_late = true;
        })
        .await;
    }
}

#[tokio::test(start_paused = true)]
async fn steps_that_are_skipped_for_a_newer_node_spec_are_planned_again_at_once() {
    for offset in offsets() {
        apply_both(offset, |_| {}).await;
    }
}

#[tokio::test(start_paused = true)]
async fn a_batch_that_is_refused_for_a_newer_node_spec_is_no_fault_of_its_node() {
    for offset in offsets() {
        apply_both(offset, |agent| {
            agent.state.lock().unwrap().accept_time = Duration::from_millis(30);
        })
        .await;
    }
}

#[tokio::test(start_paused = true)]
async fn a_step_that_fails_beside_a_newer_node_spec_is_counted_when_it_fails_again() {
    let (cluster, agent) = Cluster::hello();
    agent.slow(Duration::from_millis(20));
    agent.fail("Create component/Filter0", 3);
    cluster.apply(hello()).await;
    tokio::time::sleep(Duration::from_millis(70)).await;
    cluster.apply(other()).await;
    let system = cluster.until_phase("hello", Phase::Degraded).await;
    let mut waiting = system.status.waiting_on.iter();
    assert!(waiting.any(|w| w.target == "component/Filter0" && w.tries == 1));
    cluster.until_phase("hello", Phase::Converged).await;
    cluster.until_phase("other", Phase::Converged).await;
}

#[tokio::test(start_paused = true)]
async fn a_component_that_stays_in_error_is_not_said_to_be_tried_again() {
    let (cluster, agent) = Cluster::hello();
    agent.fail("Activate component/Printer0", 1);
    agent.ends_in_error("Printer0");
    cluster.apply(hello()).await;
    let system = cluster.until_phase("hello", Phase::Degraded).await;
    let mut waiting = system.status.waiting_on.iter();
    let printer = waiting.find(|w| w.target == "component/Printer0").unwrap();
    assert_eq!(
        printer.reason,
        "in Error: no reason was given (rtsctl.resetOnError is off)"
    );
    assert_eq!((printer.tries, printer.next_try), (1, None));
}
