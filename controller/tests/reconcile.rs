//! The loop on a fleet in memory, in paused time.

mod fleet;

use std::time::Duration;

use fleet::{Cluster, systems};
use rts_controller_api::objects::{Connector, Node, Phase};

#[tokio::test(start_paused = true)]
async fn an_applied_system_converges_and_applying_it_again_changes_nothing() {
    let (cluster, agent) = Cluster::hello();
    let applied = cluster.apply(systems::hello()).await;
    assert!(applied.changed && !applied.plan.steps.is_empty());
    let system = cluster.until_phase("hello", Phase::Converged).await;
    assert!(system.status.synced && system.status.healthy);
    assert_eq!((system.status.active, system.status.components), (3, 3));
    assert_eq!(system.metadata.generation, 1);
    assert!(system.status.waiting_on.is_empty());
    assert_eq!(cluster.component("Sine0").status.state, "Active");
    assert_eq!(cluster.component("Printer0").status.manager, "Printer0");
    let connectors = cluster.core.view.list::<Connector>().items;
    assert!(connectors.iter().all(|c| c.status.state == "Connected") && connectors.len() == 2);

    agent.take_done();
    let again = cluster.apply(systems::hello()).await;
    assert!(!again.changed && again.plan.is_empty());
    tokio::time::sleep(Duration::from_secs(30)).await;
    assert_eq!(cluster.system("hello").unwrap().metadata.generation, 1);
    assert!(agent.take_done().is_empty(), "nothing restarts");
}
