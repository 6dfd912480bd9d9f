//! Components whose node is away: nothing is started a second time.

use std::sync::Arc;
use std::time::Duration;

use crate::fleet::stores::{meets, restored};
use crate::fleet::{Cluster, FakeAgent, FakeFleet, greeting, systems};
use rts_controller::store::MemoryStore;
use rts_controller_api::objects::Phase;
use rts_schemas::system::SystemSpec;

/// hello with Printer0 elsewhere.
fn spec(node: Option<&str>, host: Option<&str>) -> SystemSpec {
    let mut spec = systems::hello();
    spec.connectors.clear();
    spec.orders.activation.clear();
    spec.components[2].placement.node = node.map(str::to_owned);
    spec.components[2].placement.host = host.map(str::to_owned);
    spec
}

async fn two_nodes(spec: SystemSpec) -> (Cluster, Arc<FakeAgent>, Arc<FakeAgent>) {
    let fleet = FakeFleet::default();
    let types = ["SineSource", "LowPassFilter", "Printer"];
    let (local, robot) = (fleet.add("local", &types), fleet.add("robot", &types));
    let mut cluster = Cluster::start(fleet, MemoryStore::new("cluster"));
    cluster.join("local", "s1");
    named(&mut cluster, &robot, "s2");
    cluster.apply(spec).await;
    cluster.until_phase("hello", Phase::Converged).await;
    assert!(robot.incarnations().contains_key("Printer0"));
    (cluster, local, robot)
}

/// The robot greets and says its host's name.
fn named(cluster: &mut Cluster, robot: &FakeAgent, session: &str) {
    let mut greeting = greeting(robot, session);
    greeting.aliases = vec!["robot-host".into()];
    rts_controller::greet(&cluster.core, "robot", greeting).unwrap();
    cluster.beats("robot", session);
}

async fn silent(agent: &FakeAgent) {
    agent.silence(true);
    tokio::time::sleep(Duration::from_secs(5)).await;
}

#[tokio::test(start_paused = true)]
async fn a_host_that_is_not_known_yet_after_a_restart_is_not_replaced_by_the_local_node() {
    let (cluster, local, robot) = two_nodes(spec(None, Some("robot-host"))).await;
    let before = (local.incarnations(), robot.incarnations());
    let mut cluster = cluster.restart().await;
    cluster.join("local", "n1");
    tokio::time::sleep(Duration::from_secs(10)).await;
    assert_eq!((local.incarnations(), robot.incarnations()), before);
    // Nor by an apply of the same file: the node is needed.
    let request = rts_controller_api::requests::ApplyRequest::of(spec(None, Some("robot-host")));
    let refused = rts_controller::apply(&cluster.core, "hello", request, None).await;
    assert_eq!(refused.unwrap_err().code, "node-not-ready");
    named(&mut cluster, &robot, "n2");
    cluster.until_phase("hello", Phase::Converged).await;
    assert_eq!((local.incarnations(), robot.incarnations()), before);
}

#[tokio::test(start_paused = true)]
async fn a_store_of_an_older_program_learns_where_its_components_are() {
    let (cluster, local, robot) = two_nodes(spec(None, Some("robot-host"))).await;
    let mut state = cluster.stored();
    let record = state.systems.get_mut("hello").unwrap();
    Arc::make_mut(record).places.clear();
    let before = (local.incarnations(), robot.incarnations());
    let fleet = cluster.fleet.clone();
    drop(cluster);
    let mut cluster = Cluster::start(fleet, MemoryStore::holding(state));
    named(&mut cluster, &robot, "n1");
    cluster.join("local", "n1");
    cluster.until_phase("hello", Phase::Converged).await;
    assert_eq!(
        cluster.stored().systems["hello"].places["Printer0"],
        "robot"
    );
    let mut cluster = cluster.restart().await;
    cluster.join("local", "n2");
    tokio::time::sleep(Duration::from_secs(10)).await;
    assert_eq!((local.incarnations(), robot.incarnations()), before);
}

#[tokio::test(start_paused = true)]
async fn what_may_still_run_on_an_unknown_node_is_not_started_elsewhere() {
    let (cluster, local, robot) = two_nodes(spec(Some("robot"), None)).await;
    silent(&robot).await;
    cluster.apply(spec(None, None)).await;
    let system = cluster.until_phase("hello", Phase::Degraded).await;
    tokio::time::sleep(Duration::from_secs(30)).await;
    assert!(!local.incarnations().contains_key("Printer0"));
    let mut waiting = system.status.waiting_on.iter();
    let waiting = waiting.find(|w| w.target == "component/Printer0").unwrap();
    insta::assert_snapshot!(waiting.reason, @"node robot is unknown and may still run it: it is created on node local once node robot has said that it is gone there; if that node does not come back, `rtsctl teardown hello --forget-node robot`, then apply again");
    // A restart of the controller changes nothing.
    let mut cluster = cluster.restart().await;
    cluster.join("local", "n1");
    tokio::time::sleep(Duration::from_secs(10)).await;
    assert!(!local.incarnations().contains_key("Printer0"));
    robot.silence(false);
    cluster.join("robot", "n2");
    cluster.until_phase("hello", Phase::Converged).await;
    assert!(local.incarnations().contains_key("Printer0"));
    assert!(robot.incarnations().is_empty());
    tokio::time::sleep(Duration::from_secs(10)).await;
    assert!(cluster.stored().systems["hello"].left.is_empty());
    // From then on the robot may be away.
    silent(&robot).await;
    local.kill("hello.Printer0");
    tokio::time::sleep(Duration::from_secs(10)).await;
    assert!(local.incarnations().contains_key("Printer0"));
}

#[tokio::test(start_paused = true)]
async fn a_node_that_is_forgotten_does_not_hold_up_what_is_applied_after() {
    let (cluster, local, robot) = two_nodes(spec(Some("robot"), None)).await;
    silent(&robot).await;
    cluster.apply(spec(None, None)).await;
    cluster.until_phase("hello", Phase::Degraded).await;
    rts_controller::delete_but(&cluster.core, "hello", None, vec!["robot".into()])
        .await
        .unwrap();
    cluster.until("hello", |s| s.is_none()).await;
    cluster.apply(spec(None, None)).await;
    cluster.until_phase("hello", Phase::Converged).await;
    assert!(local.incarnations().contains_key("Printer0"));
}

#[tokio::test(start_paused = true)]
async fn an_apply_that_waits_for_a_slow_agent_holds_up_no_other() {
    let (cluster, _local, robot) = two_nodes(spec(Some("robot"), None)).await;
    robot.deafen("modules", true);
    let mut slow = spec(Some("robot"), None);
    slow.components[2].execution_context.rate = Some(5.0);
    let request = rts_controller_api::requests::ApplyRequest::of(slow);
    let core = Arc::clone(&cluster.core);
    let slow =
        tokio::spawn(async move { rts_controller::apply(&core, "hello", request, None).await });
    tokio::time::sleep(Duration::from_millis(100)).await;
    let began = tokio::time::Instant::now();
    let mut second = spec(None, None);
    second.name = "second".into();
    second.components = vec![systems::component("Other0", "Printer")];
    cluster.apply(second).await;
    assert!(
        began.elapsed() < Duration::from_secs(1),
        "{:?}",
        began.elapsed()
    );
    let failed = slow.await.unwrap().unwrap_err();
    assert_eq!(failed.code, "node-not-ready");
}

/// What the agent's ledger says of where Printer0 may still run.
fn told(agent: &FakeAgent) -> Option<String> {
    let state = agent.state.lock().unwrap();
    let spec = &state.spec.as_ref()?.spec;
    let mut parts = spec.systems.iter();
    let there = parts.find_map(|part| part.elsewhere.get("Printer0"))?;
    Some(there.node.clone())
}

/// The robot is back: what it has ends there before it is made here, and nobody remembers it any more.
async fn back(mut cluster: Cluster, local: &FakeAgent, robot: &FakeAgent) {
    robot.silence(false);
    cluster.join("robot", "back");
    cluster.until_phase("hello", Phase::Converged).await;
    assert!(local.incarnations().contains_key("Printer0"));
    assert!(robot.incarnations().is_empty());
    tokio::time::sleep(Duration::from_secs(10)).await;
    assert!(cluster.stored().systems["hello"].left.is_empty());
    assert_eq!(told(local), None);
}

#[tokio::test(start_paused = true)]
async fn the_new_node_is_told_where_a_component_may_still_run_and_so_is_a_restored_store() {
    let (cluster, local, robot) = two_nodes(spec(Some("robot"), None)).await;
    let mut backup = cluster.stored();
    silent(&robot).await;
    cluster.apply(spec(None, None)).await;
    cluster.until_phase("hello", Phase::Degraded).await;
    assert_eq!(told(&local).as_deref(), Some("robot"));
    // It is of before hello was applied, and knows nobody.
    backup.systems.clear();
    backup.nodes.clear();
    let cluster = meets(cluster, restored(backup, 2, false));
    tokio::time::sleep(Duration::from_secs(10)).await;
    assert!(!local.incarnations().contains_key("Printer0"));
    assert_eq!(told(&local).as_deref(), Some("robot"));
    back(cluster, &local, &robot).await;
}

#[tokio::test(start_paused = true)]
async fn a_restored_store_makes_nothing_that_may_run_on_a_node_that_has_not_told_since() {
    let (cluster, local, robot) = two_nodes(spec(Some("robot"), None)).await;
    cluster.apply(spec(None, None)).await;
    cluster.until_phase("hello", Phase::Converged).await;
    let backup = cluster.stored();
    cluster.apply(spec(Some("robot"), None)).await;
    cluster.until_phase("hello", Phase::Converged).await;
    silent(&robot).await;
    let sine = local.incarnations()["Sine0"].clone();
    let cluster = meets(cluster, restored(backup, 2, true));
    let system = cluster.until_phase("hello", Phase::Degraded).await;
    tokio::time::sleep(Duration::from_secs(10)).await;
    assert!(!local.incarnations().contains_key("Printer0"));
    assert_eq!(local.incarnations()["Sine0"], sine);
    let mut waiting = system.status.waiting_on.iter();
    let waiting = waiting.find(|w| w.target == "component/Printer0").unwrap();
    assert!(
        waiting.reason.contains("--forget-node robot"),
        "{waiting:?}"
    );
    // What is seen where it belongs is nowhere else.
    let left = cluster.stored().systems["hello"].left.clone();
    assert_eq!(left.keys().collect::<Vec<_>>(), ["Printer0"]);
    back(cluster, &local, &robot).await;
}

#[tokio::test(start_paused = true)]
async fn what_a_ledger_has_as_the_restored_store_would_write_it_needs_nobodys_word() {
    let (cluster, local, robot) = two_nodes(spec(Some("robot"), None)).await;
    let backup = cluster.stored();
    silent(&robot).await;
    local.kill("hello.main");
    let cluster = meets(cluster, restored(backup, 2, false));
    tokio::time::sleep(Duration::from_secs(10)).await;
    assert!(local.incarnations().contains_key("Sine0"));
    assert!(cluster.stored().systems["hello"].left.is_empty());
}
