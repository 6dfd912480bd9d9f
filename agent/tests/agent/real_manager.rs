//! The agent with the real manager program, when it was built.

use std::path::PathBuf;

use rts_agent::Config;

use rts_agent_api::AgentApi;
use rts_agent_api::messages::{Batch, ModuleRequest};
use rts_plan::observed::{Activity, Inventory, ManagerObserved};
use rts_plan::plan::{StepId, Work};

use crate::setup::{Node, batch, component, hello_batch, lives, manager, step};

/// `rts-manager` beside the test programs' folder.
fn program() -> Option<PathBuf> {
    let test = std::env::current_exe().ok()?;
    let program = test.parent()?.parent()?.join("rts-manager");
    program.exists().then_some(program)
}

/// Settings of a node with the real manager and modules, when they were built; the home is still to be set.
pub fn config() -> Option<Config> {
    let program = program()?;
    let modules = program.parent()?.to_owned();
    let names = [
        "libsine_source.so",
        "liblow_pass_filter.so",
        "libprinter.so",
    ];
    let built = names.iter().all(|name| modules.join(name).exists());
    built.then(|| Config {
        home: PathBuf::new(),
        node: "local".to_owned(),
        aliases: Vec::new(),
        module_path: vec![modules],
        manager_program: program,
        controller_socket: None,
        heal_after: None,
        idle_managers: None,
    })
}

/// The real type for a type of the fake hello system.
pub fn real_type(fake: &str) -> String {
    match fake {
        "Sine" => "SineSource".to_owned(),
        "Filter" => "LowPassFilter".to_owned(),
        other => other.to_owned(),
    }
}

#[tokio::test]
async fn the_real_manager_starts_outlives_the_agent_and_is_adopted() {
    let program = program().expect("build rts-manager first (cargo build -p rtsctl)");
    let home = tempfile::Builder::new()
        .prefix("rts")
        .tempdir_in("/tmp")
        .unwrap();
    let config = Config {
        home: home.path().to_owned(),
        node: "local".to_owned(),
        aliases: Vec::new(),
        module_path: vec![home.path().to_owned()],
        manager_program: program,
        controller_socket: None,
        heal_after: None,
        idle_managers: None,
    };
    std::fs::write(home.path().join("libnothing.so"), "no library").unwrap();
    let mut node = Node::of(home, config).await;
    let request = ModuleRequest {
        type_name: "Nothing".to_owned(),
    };
    let refused = crate::setup::problem(node.agent.load_module("bench", &request).await);
    assert_eq!(refused.code, "load-failed", "{}", refused.detail);
    let before = node.until(|i| i.managers.len() == 1).await;
    assert!(before.managers[0].responsive);
    node.stop().await;
    node.start_again().await;
    let after = node.agent.inventory().await.unwrap();
    // What it uses of the machine changes all the time.
    let lasting = |inventory: &Inventory| {
        let mut managers = inventory.managers.clone();
        managers
            .iter_mut()
            .for_each(|m| m.activity = Activity::default());
        managers
    };
    assert_eq!(lasting(&after), lasting(&before));
    assert!(lives(after.managers[0].pid));
}

/// A node that runs the real hello system, and what brought it up.
pub async fn hello() -> (Node, Batch) {
    let mut config =
        config().expect("build everything first (cargo build --workspace --all-targets)");
    let home = tempfile::Builder::new()
        .prefix("rts")
        .tempdir_in("/tmp")
        .unwrap();
    config.home = home.path().to_owned();
    let node = Node::of(home, config).await;
    node.accept(1).await;
    let mut batch = hello_batch("up", 1);
    for step in &mut batch.steps {
        if let Work::LoadModule { type_name, .. } | Work::Create { type_name, .. } = &mut step.work
        {
            *type_name = real_type(type_name);
        }
    }
    let outcomes = node.outcomes(&batch).await;
    assert!(outcomes.iter().all(|(_, o)| o == "ok"), "{outcomes:?}");
    (node, batch)
}

#[tokio::test]
async fn the_real_hello_system_flows_stops_and_leaves_nothing() {
    let (node, mut batch) = hello().await;
    let up = node
        .until(|i| {
            ["Sine0", "Filter0"].iter().all(|name| {
                let connector = &component(i, name).connectors[0];
                connector.samples_received >= 3
                    && connector.samples_received <= connector.samples_sent
            })
        })
        .await;
    batch.plan_id = "again".to_owned();
    let outcomes = node.outcomes(&batch).await;
    assert!(outcomes.iter().all(|(_, o)| o == "ok"), "{outcomes:?}");
    let again = node.agent.inventory().await.unwrap();
    assert_eq!(
        component(&again, "Printer0").incarnation,
        component(&up, "Printer0").incarnation
    );
    assert!(!node.agent.log("Printer0", 10).await.unwrap().is_empty());

    let stop = |(id, observed): (u32, &ManagerObserved)| {
        let work = Work::StopManager {
            manager: observed.key.clone(),
            incarnation: observed.incarnation.clone(),
        };
        step(id, &[], "manager", work)
    };
    let steps = (1..).zip(&up.managers).map(stop).collect();
    let outcomes = node.outcomes(&crate::setup::batch("down", 1, steps)).await;
    assert!(outcomes.iter().all(|(_, o)| o == "ok"), "{outcomes:?}");
    assert!(up.managers.iter().all(|m| !lives(m.pid)));
    assert_eq!(node.managers(), []);
}

#[tokio::test]
async fn an_in_port_end_is_unbound_only_when_nobody_is_connected_to_it() {
    const NAME: &str = "Filter0.out-Printer0.in";
    let (node, _) = hello().await;
    let ends = |inventory: &Inventory| {
        let mut ends = component(inventory, "Printer0").bindings.clone();
        ends.iter_mut().for_each(|end| end.samples_received = 0);
        ends
    };
    let unbind = |id, needs: &[StepId]| {
        let work = Work::Unbind {
            manager: manager("Printer0"),
            instance: "Printer0".to_owned(),
            connector: NAME.to_owned(),
        };
        step(id, needs, "connector", work)
    };
    let up = node
        .until(|i| ends(i).iter().any(|end| end.connected))
        .await;
    let source = ends(&up)[0].source.as_ref().map(ToString::to_string);
    assert_eq!(source.as_deref(), Some("Filter0.out"));
    let outcomes = node
        .outcomes(&batch("connected", 1, vec![unbind(1, &[])]))
        .await;
    assert_eq!(outcomes, [(1, "ok".to_owned())]);
    assert_eq!(ends(&node.agent.inventory().await.unwrap()), ends(&up));

    let deactivate = Work::Deactivate {
        manager: manager("main"),
        instance: "Filter0".to_owned(),
    };
    let delete = Work::Delete {
        manager: manager("main"),
        instance: "Filter0".to_owned(),
    };
    let steps = vec![
        step(1, &[], "component", deactivate),
        step(2, &[1], "component", delete),
    ];
    let outcomes = node.outcomes(&batch("gone", 1, steps)).await;
    assert!(outcomes.iter().all(|(_, o)| o == "ok"), "{outcomes:?}");
    let left = node
        .until(|i| ends(i).iter().all(|end| !end.connected))
        .await;
    assert_eq!(ends(&left).len(), 1, "it stays without a source");
    let outcomes = node.outcomes(&batch("left", 1, vec![unbind(1, &[])])).await;
    assert_eq!(outcomes, [(1, "ok".to_owned())]);
    assert_eq!(ends(&node.agent.inventory().await.unwrap()), []);
    // Once more: it is so already.
    let outcomes = node
        .outcomes(&batch("again", 1, vec![unbind(1, &[])]))
        .await;
    assert_eq!(outcomes, [(1, "ok".to_owned())]);
}
