//! Orders that reach from one node to another, and starts that take long, on a fleet in memory.

use std::time::Duration;

use crate::fleet::{Cluster, FakeFleet, systems};
use rts_controller::store::MemoryStore;
use rts_controller_api::objects::Phase;
use rts_schemas::system::SystemSpec;

const TYPES: [&str; 3] = ["SineSource", "LowPassFilter", "Printer"];

/// Filter0 on local goes after Printer0, which is on the robot and optional.
fn optional_first() -> SystemSpec {
    let mut spec = systems::hello();
    spec.components[2].placement.node = Some("robot".into());
    spec.components[2].required = false;
    spec.connectors.clear();
    spec.orders.activation = vec![systems::after("Filter0", "Printer0")];
    spec
}

#[tokio::test(start_paused = true)]
async fn an_optional_component_of_another_node_holds_nobody_up_for_longer_than_its_try() {
    let fleet = FakeFleet::default();
    let local = fleet.add("local", &TYPES);
    let robot = fleet.add("robot", &TYPES);
    robot.slow_step("Activate component/Printer0", Duration::from_secs(3));
    robot.fail("Activate component/Printer0", 1_000);
    let mut cluster = Cluster::start(fleet, MemoryStore::new("cluster"));
    cluster.join("local", "s1");
    cluster.join("robot", "s1");
    let began = tokio::time::Instant::now();
    cluster.apply(optional_first()).await;
    let activated = || {
        let state = local.state.lock().unwrap();
        state
            .done
            .contains(&"Activate component/Filter0".to_owned())
    };
    crate::fleet::stores::until(activated).await;
    let waited = began.elapsed();
    let try_ends = Duration::from_secs(3)..Duration::from_secs(5);
    assert!(try_ends.contains(&waited), "{waited:?}");
    let healthy = |s: Option<&rts_controller_api::objects::System>| s.unwrap().status.healthy;
    cluster.until("hello", healthy).await;
}

#[tokio::test(start_paused = true)]
async fn a_start_may_take_as_long_as_its_time_out_says() {
    let (cluster, agent) = Cluster::hello();
    let step = "Activate component/Filter0";
    agent.slow_step(step, Duration::from_secs(240));
    let mut spec = systems::hello();
    spec.components[1].policy.start_timeout_ms = Some(300_000);
    cluster.apply(spec).await;
    tokio::time::sleep(Duration::from_secs(260)).await;
    cluster.until_phase("hello", Phase::Converged).await;
    assert!(cluster.told("ActivateFailed").is_empty());
    let done = agent.take_done();
    assert_eq!(done.iter().filter(|done| *done == step).count(), 1);
}
