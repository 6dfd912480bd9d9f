//! The end of a system with a node that cannot be asked.

use std::sync::Arc;
use std::time::Duration;

use crate::fleet::served::{problem, request, serve};
use crate::fleet::{Cluster, FakeAgent, FakeFleet, systems};
use rts_controller::store::MemoryStore;
use rts_controller_api::objects::Phase;

/// hello on two nodes: Printer0 on the robot.
async fn on_two_nodes() -> (Cluster, Arc<FakeAgent>, Arc<FakeAgent>) {
    let fleet = FakeFleet::default();
    let types = ["SineSource", "LowPassFilter", "Printer"];
    let (local, robot) = (fleet.add("local", &types), fleet.add("robot", &types));
    let mut cluster = Cluster::start(fleet, MemoryStore::new("cluster"));
    cluster.join("local", "s1");
    cluster.join("robot", "s2");
    let mut spec = systems::hello();
    spec.components[2].placement.node = Some("robot".into());
    spec.connectors.clear();
    cluster.apply(spec).await;
    cluster.until_phase("hello", Phase::Converged).await;
    (cluster, local, robot)
}

async fn silent(agent: &FakeAgent) {
    agent.silence(true);
    tokio::time::sleep(Duration::from_secs(5)).await;
}

#[tokio::test(start_paused = true)]
async fn the_other_nodes_are_cleaned_and_the_silent_one_is_named() {
    let (cluster, local, robot) = on_two_nodes().await;
    silent(&robot).await;
    rts_controller::delete(&cluster.core, "hello", None)
        .await
        .unwrap();
    let system = cluster
        .until("hello", |s| !s.unwrap().status.tombstones.is_empty())
        .await
        .unwrap();
    assert_eq!(system.status.tombstones, ["robot"]);
    assert_eq!(system.status.phase, Phase::Terminating);
    assert!(local.inventory_now().managers.is_empty());
    // It comes back before it was forgotten.
    robot.silence(false);
    cluster.until("hello", |s| s.is_none()).await;
    assert!(robot.inventory_now().managers.is_empty());
}

#[tokio::test]
async fn a_silent_node_is_forgotten_on_request_and_cleaned_when_it_comes_back() {
    tokio::time::pause();
    let (cluster, _local, robot) = on_two_nodes().await;
    tokio::time::resume();
    let served = serve(cluster).await;
    let robots = ["robot".to_owned()];
    let forget = || served.controller.delete_but("hello", &robots);
    let refused = problem(forget().await);
    assert_eq!(
        (refused.status, refused.code.as_str()),
        (409, "node-not-unknown")
    );
    let there = served.controller.system("hello").await.unwrap();
    assert!(
        there.metadata.deletion_timestamp.is_none(),
        "nothing was begun"
    );
    silent(&robot).await;
    served.controller.delete("hello").await.unwrap();
    served
        .cluster
        .until("hello", |s| !s.unwrap().status.tombstones.is_empty())
        .await;
    let again = served.controller.apply(&request(systems::hello())).await;
    let again = problem(again);
    assert_eq!((again.status, again.code.as_str()), (409, "terminating"));
    forget().await.unwrap();
    served.cluster.until("hello", |s| s.is_none()).await;
    assert!(!robot.inventory_now().managers.is_empty());
    robot.silence(false);
    let gone = async {
        while !robot.inventory_now().managers.is_empty() {
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(30), gone)
        .await
        .expect("what was forgotten is stopped");
}
