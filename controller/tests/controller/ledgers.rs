//! Whose set a node runs: ledgers of other stores, of restored and of rolled back ones, on a fleet in memory.

use std::sync::Arc;
use std::time::Duration;

use crate::fleet::stores::{meets, restored, until};
use crate::fleet::{Cluster, FakeAgent, systems};
use rts_controller::store::{MemoryStore, State, SystemRecord};
use rts_controller_api::objects::{Node, Phase, System};
use rts_controller_api::requests::{ApplyRequest, TakeOver};
use rts_schemas::system::SystemSpec;

/// A second system beside hello.
fn second() -> SystemSpec {
    let mut spec = systems::hello();
    spec.name = "second".into();
    spec.full_id = "RTSystem:rtsctl:second:1.0".into();
    spec.components = vec![systems::component("Other0", "Printer")];
    spec.connectors.clear();
    spec.orders.activation.clear();
    spec
}

fn node(cluster: &Cluster) -> Node {
    cluster.core.view.get::<Node>("local").unwrap()
}

async fn converged() -> (Cluster, Arc<FakeAgent>) {
    let (cluster, agent) = Cluster::hello();
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    agent.take_done();
    (cluster, agent)
}

#[tokio::test(start_paused = true)]
async fn nothing_is_sent_to_a_node_of_another_store() {
    let (cluster, agent) = converged().await;
    let (before, ledger) = (agent.incarnations(), agent.ledger());
    let cluster = meets(cluster, MemoryStore::new("stranger"));
    tokio::time::sleep(Duration::from_secs(60)).await;
    assert_eq!((agent.incarnations(), agent.ledger()), (before, ledger));
    assert!(agent.take_done().is_empty());
    let status = node(&cluster).status;
    assert_eq!(status.state, "NotReady");
    assert_eq!(status.reason.as_deref(), Some("ForeignLedger"));
    insta::assert_snapshot!(status.message.unwrap(), @"node local belongs to another controller (cluster cluster, epoch 1, generation 1), and this one (stranger) changes nothing there; `rtsctl controller adopt local` makes what runs there this controller's, without a restart; `rtsctl controller take-over local` puts this controller's set in its place");
    let request = ApplyRequest::of(second());
    let refused = rts_controller::apply(&cluster.core, "second", request, None).await;
    let refused = refused.unwrap_err();
    assert_eq!(
        (refused.status, refused.code.as_str()),
        (503, "node-not-ready")
    );
    assert!(refused.detail.contains("controller adopt local") && !refused.retryable);
}

#[tokio::test(start_paused = true)]
async fn an_adopted_node_goes_on_without_a_restart_and_obeys_from_then_on() {
    let (cluster, agent) = converged().await;
    let before = agent.incarnations();
    let uid = cluster.system("hello").unwrap().metadata.uid;
    let cluster = meets(cluster, MemoryStore::new("stranger"));
    let claimed = rts_controller::adopt(&cluster.core, "local").await.unwrap();
    assert!(claimed.changed);
    assert_eq!(claimed.systems, ["hello"]);
    let system = cluster.until_phase("hello", Phase::Converged).await;
    assert_eq!(system.metadata.uid, uid);
    assert_eq!(agent.incarnations(), before, "nothing restarts");
    assert!(agent.take_done().is_empty());
    assert_eq!(agent.ledger().unwrap().cluster_uid, "stranger");
    assert_eq!(node(&cluster).status.state, "Ready");
    let state = cluster.stored();
    let (index, indexes) = (state.systems["hello"].index, state.indexes);
    assert_eq!((index, indexes), (1, 1), "an adoption is a change");
    let again = rts_controller::adopt(&cluster.core, "local").await.unwrap();
    assert!(!again.changed);
    // The same profile once more changes a name that the ledger does not hold, and nothing that runs.
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    assert_eq!(agent.incarnations(), before);
    rts_controller::delete(&cluster.core, "hello", None)
        .await
        .unwrap();
    cluster.until("hello", |s| s.is_none()).await;
    assert!(agent.inventory_now().managers.is_empty());
}

#[tokio::test(start_paused = true)]
async fn a_node_is_not_adopted_when_a_name_is_taken() {
    let (cluster, _agent) = converged().await;
    let mut record = SystemRecord::clone(&cluster.stored().systems["hello"]);
    record.uid = "another".into();
    record.nodes.clear();
    let state = State {
        cluster_uid: "stranger".into(),
        epoch: 1,
        systems: [("hello".to_owned(), record.into())].into(),
        ..State::default()
    };
    let cluster = meets(cluster, MemoryStore::holding(state));
    let refused = rts_controller::adopt(&cluster.core, "local").await;
    let refused = refused.unwrap_err();
    assert_eq!((refused.status, refused.code.as_str()), (409, "name-taken"));
    assert_eq!(cluster.stored().systems["hello"].uid, "another");
}

#[tokio::test(start_paused = true)]
async fn a_take_over_replaces_only_what_was_shown() {
    let (cluster, agent) = converged().await;
    let cluster = meets(cluster, MemoryStore::new("stranger"));
    let shown = node(&cluster).status.ledger.unwrap();
    let mut other = shown.clone();
    other.generation += 1;
    let request = |confirm| TakeOver { confirm };
    let refused = rts_controller::take_over(&cluster.core, "local", request(other)).await;
    assert_eq!(refused.unwrap_err().code, "ledger-changed");
    assert!(!agent.incarnations().is_empty());
    let claimed = rts_controller::take_over(&cluster.core, "local", request(shown)).await;
    assert!(claimed.unwrap().changed);
    until(|| agent.incarnations().is_empty()).await;
    cluster.apply(second()).await;
    cluster.until_phase("second", Phase::Converged).await;
}

#[tokio::test(start_paused = true)]
async fn a_restored_store_takes_in_what_was_applied_since() {
    let (cluster, agent) = converged().await;
    let backup = cluster.stored();
    cluster.apply(second()).await;
    cluster.until_phase("second", Phase::Converged).await;
    let mut changed = systems::hello();
    changed.components[0].execution_context.rate = Some(25.0);
    cluster.apply(changed.clone()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    agent.take_done();
    let (before, told) = (agent.incarnations(), agent.ledger().unwrap());
    let cluster = meets(cluster, restored(backup, 2, false));
    cluster.until_phase("second", Phase::Converged).await;
    let hello = cluster.until_phase("hello", Phase::Converged).await;
    assert_eq!(hello.spec.components, changed.components);
    until(|| agent.ledger().unwrap().epoch == 2).await;
    assert!(agent.ledger().unwrap().generation > told.generation);
    assert_eq!(agent.incarnations(), before, "nothing restarts");
    assert!(agent.take_done().is_empty());
    let settled = cluster.stored().restored.unwrap().settled;
    assert!(settled.contains("local"));
}

#[tokio::test(start_paused = true)]
async fn a_restored_store_drops_what_was_torn_down_since() {
    let (cluster, agent) = converged().await;
    cluster.apply(second()).await;
    cluster.until_phase("second", Phase::Converged).await;
    let backup = cluster.stored();
    rts_controller::delete(&cluster.core, "second", None)
        .await
        .unwrap();
    cluster.until("second", |s| s.is_none()).await;
    let before = agent.incarnations();
    agent.take_done();
    let cluster = meets(cluster, restored(backup, 2, false));
    cluster.until("second", |s| s.is_none()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    let events = cluster.events();
    assert!(
        events
            .iter()
            .any(|e| e.spec.reason == "TornDownSinceBackup")
    );
    assert_eq!(agent.incarnations(), before);
    assert!(agent.take_done().is_empty());
}

#[tokio::test(start_paused = true)]
async fn a_restored_store_takes_down_what_it_was_told_to_before_it_took_it_in() {
    let (cluster, agent) = converged().await;
    let backup = cluster.stored();
    let mut changed = systems::hello();
    changed.components[0].execution_context.rate = Some(25.0);
    cluster.apply(changed).await;
    cluster.until_phase("hello", Phase::Converged).await;
    agent.deafen("ledger", true);
    let cluster = meets(cluster, restored(backup, 2, false));
    rts_controller::delete(&cluster.core, "hello", None)
        .await
        .unwrap();
    agent.deafen("ledger", false);
    cluster.until("hello", |s| s.is_none()).await;
    assert!(agent.inventory_now().managers.is_empty());
}

#[tokio::test(start_paused = true)]
async fn a_restored_store_wins_when_it_was_told_to() {
    let (cluster, agent) = converged().await;
    let backup = cluster.stored();
    cluster.apply(second()).await;
    cluster.until_phase("second", Phase::Converged).await;
    let hello = agent.incarnations()["Sine0"].clone();
    let cluster = meets(cluster, restored(backup, 2, true));
    until(|| !agent.incarnations().contains_key("Other0")).await;
    cluster.until_phase("hello", Phase::Converged).await;
    assert_eq!(agent.incarnations()["Sine0"], hello);
    assert!(cluster.core.view.get::<System>("second").is_none());
}

#[tokio::test(start_paused = true)]
async fn a_store_that_is_restored_twice_from_one_backup_goes_above_the_first() {
    let (cluster, agent) = converged().await;
    let backup = cluster.stored();
    let cluster = meets(cluster, restored(backup.clone(), 5, false));
    until(|| agent.ledger().unwrap().epoch == 5).await;
    cluster.apply(second()).await;
    cluster.until_phase("second", Phase::Converged).await;
    let before = agent.incarnations();
    // The store of the first restore is lost, and with it the knowledge of its epoch.
    let cluster = meets(cluster, restored(backup, 2, false));
    cluster.until_phase("second", Phase::Converged).await;
    until(|| agent.ledger().unwrap().epoch == 6).await;
    assert_eq!(cluster.core.epoch(), 6);
    assert_eq!(cluster.stored().epoch, 6);
    assert_eq!(agent.incarnations(), before);
    assert_eq!(node(&cluster).status.state, "Ready");
}

#[tokio::test(start_paused = true)]
async fn a_stale_controller_does_nothing_and_says_so() {
    let (cluster, agent) = converged().await;
    let stale = cluster.stored();
    let cluster = meets(cluster, restored(stale.clone(), 5, false));
    until(|| agent.ledger().unwrap().epoch == 5).await;
    let (before, ledger) = (agent.incarnations(), agent.ledger());
    agent.take_done();
    let cluster = meets(cluster, MemoryStore::holding(stale));
    tokio::time::sleep(Duration::from_secs(30)).await;
    let status = node(&cluster).status;
    assert_eq!(status.state, "NotReady");
    assert_eq!(status.reason.as_deref(), Some("StaleController"));
    insta::assert_snapshot!(status.message.unwrap(), @"a newer controller has taken over node local (cluster cluster, epoch 5, generation 6), and this one has epoch 1; end this one with `rtsctl down`, or make it the newest with `rtsctl controller restore` from a backup");
    assert_eq!((agent.incarnations(), agent.ledger()), (before, ledger));
    assert!(agent.take_done().is_empty());
    let refused = rts_controller::adopt(&cluster.core, "local").await;
    assert_eq!(refused.unwrap_err().code, "stale-controller");
}

#[tokio::test(start_paused = true)]
async fn a_store_that_was_put_back_without_a_restore_takes_in_what_is_newer() {
    let (cluster, agent) = converged().await;
    let old = cluster.stored();
    cluster.apply(second()).await;
    cluster.until_phase("second", Phase::Converged).await;
    let (before, told) = (agent.incarnations(), agent.ledger().unwrap());
    agent.take_done();
    let cluster = meets(cluster, MemoryStore::holding(old));
    cluster.until_phase("second", Phase::Converged).await;
    cluster.until_phase("hello", Phase::Converged).await;
    assert_eq!(agent.incarnations(), before);
    assert!(agent.take_done().is_empty());
    let stored = cluster.stored().nodes["local"].generation;
    assert!(stored >= told.generation);
}

#[tokio::test(start_paused = true)]
async fn a_take_over_that_failed_is_not_done_later() {
    let (cluster, agent) = converged().await;
    let cluster = meets(cluster, MemoryStore::new("stranger"));
    let confirm = node(&cluster).status.ledger.unwrap();
    agent.silence(true);
    let failed = rts_controller::take_over(&cluster.core, "local", TakeOver { confirm }).await;
    assert_eq!(failed.unwrap_err().status, 503);
    let (before, ledger) = (agent.incarnations(), agent.ledger());
    agent.silence(false);
    tokio::time::sleep(Duration::from_secs(30)).await;
    assert_eq!((agent.incarnations(), agent.ledger()), (before, ledger));
    let status = node(&cluster).status;
    assert_eq!(status.reason.as_deref(), Some("ForeignLedger"));
}

#[tokio::test(start_paused = true)]
async fn a_teardown_of_a_system_that_is_not_known_goes_on_after_an_adoption() {
    let (cluster, agent) = converged().await;
    let mut spec = systems::hello();
    spec.orders.shut_down = vec![systems::after("Sine0", "Printer0")];
    cluster.apply(spec).await;
    cluster.until_phase("hello", Phase::Converged).await;
    for name in ["main", "Printer0"] {
        agent.fail(&format!("StopManager manager/hello.{name}"), 2);
    }
    rts_controller::delete(&cluster.core, "hello", None)
        .await
        .unwrap();
    until(|| agent.ledger().unwrap().generation == 3).await;
    let cluster = meets(cluster, MemoryStore::new("stranger"));
    assert_eq!(agent.inventory_now().managers.len(), 2);
    rts_controller::adopt(&cluster.core, "local").await.unwrap();
    let orders = cluster.stored().systems["hello"].spec.orders.clone();
    assert!(!orders.shut_down.is_empty(), "its orders are kept");
    cluster.until("hello", |s| s.is_none()).await;
    assert!(agent.inventory_now().managers.is_empty());
}

#[tokio::test(start_paused = true)]
async fn a_ledger_that_cannot_be_taken_in_without_a_restart_is_left_alone() {
    let (cluster, agent) = converged().await;
    let backup = cluster.stored();
    {
        // Something that this program would place otherwise.
        let mut state = agent.state.lock().unwrap();
        let told = state.spec.as_mut().unwrap();
        let parts = told.spec.systems.iter_mut();
        let component = parts.flat_map(|part| &mut part.components).next().unwrap();
        component.recreate_hash = "0123456789abcdef".into();
        told.digest = rts_plan::digest(&told.spec);
        told.generation += 1;
    }
    let (before, told) = (agent.incarnations(), agent.ledger());
    let cluster = meets(cluster, restored(backup, 2, false));
    tokio::time::sleep(Duration::from_secs(30)).await;
    assert_eq!((agent.incarnations(), agent.ledger()), (before, told));
    assert!(agent.take_done().is_empty());
    let system = cluster.system("hello").unwrap();
    let mut waiting = system.status.waiting_on.iter();
    let node = waiting.find(|w| w.target == "node/local").unwrap();
    assert!(
        node.reason.contains("would restart Sine0"),
        "{}",
        node.reason
    );
    // Whoever means it can have it.
    let mut state = cluster.stored();
    state.restored.as_mut().unwrap().take_over = true;
    let cluster = meets(cluster, MemoryStore::holding(state));
    cluster.until_phase("hello", Phase::Converged).await;
}
