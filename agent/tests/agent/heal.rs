//! Healing without a controller.

use std::collections::BTreeMap;
use std::time::Duration;

use rts_agent_api::AgentApi;
use rts_agent_api::messages::{NodeSpecEnvelope, Seen};
use rts_plan::desired::PlacedComponent;
use rts_plan::observed::{ConnectorState, Inventory, LifeCycleState, ManagerObserved};
use rts_plan::place::digest;
use rts_schemas::system::{Condition, OnHang, RestartPolicy};
use rustix::process::Signal;

use crate::agent_process::{AgentProcess, serving};
use crate::fake_controller::FakeController;
use crate::real_manager;
use crate::setup::{Node, component, hello_batch, hello_spec, kill, lives, problem};

/// True when the hello system is there as its spec says.
fn is_up(inventory: &Inventory) -> bool {
    let components: Vec<_> = inventory
        .managers
        .iter()
        .flat_map(|m| &m.components)
        .collect();
    let connected = components
        .iter()
        .flat_map(|c| &c.connectors)
        .filter(|c| c.state == ConnectorState::Connected);
    components.len() == 3
        && components.iter().all(|c| c.state == LifeCycleState::Active)
        && connected.count() == 2
}

#[tokio::test]
async fn what_was_planned_before_the_agent_acted_alone_is_refused() {
    let mut node = Node::start().await;
    node.stop().await;
    node.config.heal_after = Some(Duration::from_millis(100));
    node.start_again().await;
    node.agent.put_node_spec(&hello_spec(1)).await.unwrap();
    let up = node.until(is_up).await;
    let session = node.agent.node().await.unwrap().session;
    let seen = |session: &str, revision| Seen {
        session: session.to_owned(),
        revision,
    };
    let offered = |plan_id: &str, seen| {
        let mut batch = hello_batch(plan_id, 1);
        batch.seen = Some(seen);
        batch
    };
    // It came up after the inventory with revision 1 was told.
    for (plan_id, seen) in [
        ("late", seen(&session, 1)),
        ("other", seen("earlier", up.revision)),
    ] {
        let refused = node.agent.run_batch(&offered(plan_id, seen)).await;
        let refused = problem(refused.map(|_| ()));
        assert_eq!(
            (refused.status, refused.code.as_str()),
            (409, "stale-inventory")
        );
    }
    let now = offered("now", seen(&session, up.revision));
    let outcomes = node.outcomes(&now).await;
    assert!(outcomes.iter().all(|(_, o)| o == "ok"), "{outcomes:?}");
}

/// Stops the agent, lets everything else die as in a power cut, and starts the agent again.
async fn reboot(node: &mut Node) {
    let before: Vec<u32> = node.managers().iter().map(|m| m.pid).collect();
    node.stop().await;
    for pid in &before {
        kill(*pid, Signal::KILL);
    }
    while before.iter().any(|pid| lives(*pid)) {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    std::fs::remove_dir_all(node.run()).unwrap();
    node.start_again().await;
}

async fn breaks_and_heals(mut node: Node, spec: NodeSpecEnvelope) {
    node.agent.put_node_spec(&spec).await.unwrap();
    let up = node.until(is_up).await;
    let main = up.managers.iter().find(|m| m.key.name == "main").unwrap();
    kill(main.pid, Signal::KILL);
    let sine = component(&up, "Sine0").incarnation.clone();
    let again = node
        .until(|i| is_up(i) && component(i, "Sine0").incarnation != sine)
        .await;
    assert_eq!(component(&again, "Sine0").restarts, 1);
    assert_eq!(
        component(&again, "Printer0").incarnation,
        component(&up, "Printer0").incarnation,
        "what is well is not touched"
    );
    reboot(&mut node).await;
    let anew = node.until(is_up).await;
    assert_ne!(
        component(&anew, "Printer0").incarnation,
        component(&up, "Printer0").incarnation
    );
}

#[tokio::test]
async fn alone_the_agent_brings_back_what_dies_and_everything_after_a_power_cut() {
    let mut node = Node::start().await;
    node.stop().await;
    node.config.heal_after = Some(Duration::from_millis(100));
    node.start_again().await;
    breaks_and_heals(node, hello_spec(1)).await;
}

#[tokio::test]
async fn the_real_hello_system_comes_back_without_a_controller() {
    let mut config = real_manager::config()
        .expect("build everything first (cargo build --workspace --all-targets)");
    let home = tempfile::Builder::new()
        .prefix("rts")
        .tempdir_in("/tmp")
        .unwrap();
    config.home = home.path().to_owned();
    config.heal_after = Some(Duration::from_millis(100));
    let mut spec = hello_spec(1);
    for component in &mut spec.spec.systems[0].components {
        let type_name = &mut component.spec.type_name;
        *type_name = real_manager::real_type(type_name);
    }
    spec.digest = digest(&spec.spec);
    breaks_and_heals(Node::of(home, config).await, spec).await;
}

#[tokio::test]
async fn while_a_controller_is_heard_of_the_agent_leaves_healing_to_it() {
    let controller = FakeController::start().await;
    let mut node = Node::with("", Some(controller.socket())).await;
    node.stop().await;
    node.config.heal_after = Some(Duration::from_secs(2));
    node.start_again().await;
    node.hello().await;
    let up = node.agent.inventory().await.unwrap();
    kill(up.managers[1].pid, Signal::KILL);
    node.until(|i| i.managers.len() == 1).await;
    // Longer than the agent would wait.
    let end = tokio::time::Instant::now() + Duration::from_secs(3);
    while tokio::time::Instant::now() < end {
        assert_eq!(node.agent.inventory().await.unwrap().managers.len(), 1);
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    // Its socket goes with it.
    drop(controller);
    node.until(is_up).await;
}

#[tokio::test]
async fn what_is_never_to_be_started_again_stays_down() {
    let mut node = Node::start().await;
    node.stop().await;
    node.config.heal_after = Some(Duration::from_millis(100));
    node.start_again().await;
    let mut spec = hello_spec(1);
    for placed in spec.spec.systems.iter_mut().flat_map(|s| &mut s.components) {
        if placed.spec.instance == "Printer0" {
            placed.spec.policy.restart = RestartPolicy::Never;
        }
    }
    spec.digest = digest(&spec.spec);
    node.agent.put_node_spec(&spec).await.unwrap();
    let up = node.until(is_up).await;
    let process = |inventory: &Inventory, held: &str| {
        let holds = |m: &&ManagerObserved| m.components.iter().any(|c| c.instance == held);
        inventory.managers.iter().find(holds).map(|m| m.pid)
    };
    for held in ["Printer0", "Sine0"] {
        kill(process(&up, held).unwrap(), Signal::KILL);
    }
    // The other one comes back, so healing has had its turn.
    let sine = component(&up, "Sine0").incarnation.clone();
    let healed = node
        .until(|i| process(i, "Sine0").is_some() && component(i, "Sine0").incarnation != sine)
        .await;
    assert_eq!(process(&healed, "Printer0"), None);
    tokio::time::sleep(Duration::from_secs(1)).await;
    let later = node.agent.inventory().await.unwrap();
    assert_eq!(process(&later, "Printer0"), None, "{later:#?}");
}

/// Sine0, then Printer0, then Filter0: neither their data flow nor their names would say so.
fn ordered() -> NodeSpecEnvelope {
    let mut spec = hello_spec(1);
    let names = (1..).zip(["Sine0", "Printer0", "Filter0"]);
    spec.spec.systems[0].orders.activation = names
        .map(|(sequence, name)| Condition {
            target: name.to_owned(),
            sequence,
            wait: None,
        })
        .collect();
    spec.digest = digest(&spec.spec);
    spec
}

#[tokio::test]
async fn after_a_power_cut_everything_is_activated_in_its_order() {
    let mut node = Node::start().await;
    node.stop().await;
    node.config.heal_after = Some(Duration::from_millis(100));
    node.start_again().await;
    let activated = node.home.path().join("activated");
    node.agent.put_node_spec(&ordered()).await.unwrap();
    for _ in 0..2 {
        node.until(is_up).await;
        let order = std::fs::read_to_string(&activated).unwrap();
        assert_eq!(order, "Sine0\nPrinter0\nFilter0\n");
        std::fs::remove_file(&activated).unwrap();
        reboot(&mut node).await;
    }
}

#[tokio::test]
async fn an_agent_that_was_killed_heals_what_died_meanwhile_and_touches_nothing_else() {
    let mut agent = AgentProcess::start("off", &serving("")).await;
    let home = agent.node.home.path();
    for module in ["sine", "filter", "printer"] {
        std::fs::write(home.join(format!("lib{module}.so")), "").unwrap();
    }
    // Its agent heals from now on.
    std::fs::write(home.join("heals"), "").unwrap();
    agent.kill();
    agent.start_again().await;
    agent.node.agent.put_node_spec(&ordered()).await.unwrap();
    let up = agent.node.until(is_up).await;
    // What lives where is written a moment later.
    tokio::time::sleep(Duration::from_secs(1)).await;
    agent.kill();
    let main = up.managers.iter().find(|m| m.key.name == "main").unwrap();
    kill(main.pid, Signal::KILL);
    while lives(main.pid) {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    agent.start_again().await;
    let again = agent.node.until(is_up).await;
    let printer = |i: &Inventory| component(i, "Printer0").incarnation.clone();
    assert_eq!(printer(&again), printer(&up));
    assert_eq!(component(&again, "Sine0").restarts, 1);
    assert_eq!(component(&again, "Printer0").restarts, 0);
}

#[tokio::test]
async fn what_hangs_is_replaced_without_a_controller_and_not_for_ever() {
    let mut node = Node::start().await;
    node.stop().await;
    node.config.heal_after = Some(Duration::from_millis(100));
    node.start_again().await;
    let mut spec = hello_spec(1);
    for placed in spec.spec.systems.iter_mut().flat_map(|s| &mut s.components) {
        if placed.spec.instance == "Sine0" {
            placed.spec.policy.on_hang = OnHang::Restart;
            placed.spec.policy.liveness_timeout_ms = Some(1000);
            placed.spec.policy.restart_limit = Some(1);
        }
    }
    spec.digest = digest(&spec.spec);
    node.agent.put_node_spec(&spec).await.unwrap();
    let up = node.until(is_up).await;
    let process = |i: &Inventory| {
        i.managers
            .iter()
            .find(|m| m.key.name == "main")
            .map(|m| m.pid)
    };
    kill(process(&up).unwrap(), Signal::STOP);
    let again = node.until(|i| is_up(i) && process(i) != process(&up)).await;
    assert_eq!(component(&again, "Sine0").restarts, 1);
    kill(process(&again).unwrap(), Signal::STOP);
    let end = node
        .until(|i| i.held.iter().any(|h| h.instance == "Sine0"))
        .await;
    assert!(
        end.held[0].reason.contains("restartLimit 1"),
        "{:?}",
        end.held
    );
}

/// A node whose agent heals soon, with what `Sine0` is like.
async fn healing(change: impl Fn(&mut PlacedComponent)) -> Node {
    let mut node = Node::start().await;
    node.stop().await;
    node.config.heal_after = Some(Duration::from_millis(100));
    node.start_again().await;
    let mut spec = hello_spec(1);
    let systems = spec.spec.systems.iter_mut();
    let components = systems.flat_map(|s| &mut s.components);
    components
        .filter(|placed| placed.spec.instance == "Sine0")
        .for_each(change);
    spec.digest = digest(&spec.spec);
    node.agent.put_node_spec(&spec).await.unwrap();
    node
}

#[tokio::test]
async fn what_hangs_each_time_is_replaced_less_and_less_often() {
    let node = healing(|sine| {
        let busy = BTreeMap::from([("busy".to_owned(), "on_execute 99000".to_owned())]);
        sine.spec.configuration.sets = BTreeMap::from([("default".to_owned(), busy)]);
        sine.spec.policy.on_hang = OnHang::Restart;
    })
    .await;
    let restarts = |inventory: &Inventory| {
        let components = inventory.managers.iter().flat_map(|m| &m.components);
        let filter = components.filter(|c| c.instance == "Filter0");
        filter.map(|c| c.restarts).max().unwrap_or_default()
    };
    node.until(|i| restarts(i) >= 1).await;
    // Its neighbour dies with it: after 0.5, 1, 2 and 4 s, give or take a fifth.
    let end = tokio::time::Instant::now() + Duration::from_secs(6);
    let mut most = 0;
    while tokio::time::Instant::now() < end {
        most = most.max(restarts(&node.agent.inventory().await.unwrap()));
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    assert!((2..=4).contains(&most), "{most} times");
}

#[tokio::test]
async fn a_controller_that_accepts_nothing_gives_no_sign_of_life() {
    let controller = FakeController::start().await;
    let mut node = Node::with("", Some(controller.socket())).await;
    node.stop().await;
    node.config.heal_after = Some(Duration::from_secs(3));
    node.start_again().await;
    node.hello().await;
    controller.heartbeat().await;
    while controller.was_greeted() {}
    controller.refuse();
    let refused = tokio::time::Instant::now();
    let up = node.agent.inventory().await.unwrap();
    kill(up.managers[1].pid, Signal::KILL);
    node.until(|i| i.managers.len() == 1).await;
    node.until(is_up).await;
    // The last sign may have come a heartbeat before.
    assert!(refused.elapsed() > Duration::from_millis(1500));
    let beats = controller.beaten_in_vain();
    assert!(beats >= 2, "it goes on, {beats} times");
    controller.accept();
    controller.heartbeat().await;
    assert!(!controller.was_greeted(), "it was known all the time");
}
