//! Failure policies: what is held after a death, and what is replaced when it hangs.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use rts_agent_api::AgentApi;
use rts_agent_api::messages::NodeSpecEnvelope;
use rts_plan::observed::{Inventory, ManagerObserved};
use rts_plan::place::digest;
use rts_plan::plan::Work;
use rts_schemas::system::{Configuration, OnHang, Policy, RestartPolicy};
use rustix::process::Signal;

use crate::agent_process::{AgentProcess, serving};
use crate::fake_controller::FakeController;
use crate::setup::{
    Node, batch, component, create, hello_batch, hello_spec, kill, lives, load, manager,
    start_manager, step, system,
};

/// The hello system, one of whose components has a policy.
fn spec_with(generation: u64, instance: &str, policy: Policy) -> NodeSpecEnvelope {
    let mut envelope = hello_spec(generation);
    let placed = envelope.spec.systems[0].components.iter_mut();
    for placed in placed.filter(|c| c.spec.instance == instance) {
        placed.spec.policy = policy.clone();
    }
    envelope.digest = digest(&envelope.spec);
    envelope
}

fn never() -> Policy {
    Policy {
        restart: RestartPolicy::Never,
        ..Policy::default()
    }
}

fn replaced(liveness_timeout_ms: u64) -> Policy {
    Policy {
        on_hang: OnHang::Restart,
        liveness_timeout_ms: Some(liveness_timeout_ms),
        ..Policy::default()
    }
}

/// A node with the hello system, and a controller that listens.
async fn hello(spec: NodeSpecEnvelope) -> (FakeController, Node, Inventory) {
    let controller = FakeController::start().await;
    let node = Node::with("", Some(controller.socket())).await;
    node.agent.put_node_spec(&spec).await.unwrap();
    let up = all_up(&node, "up").await;
    (controller, node, up)
}

fn process<'a>(inventory: &'a Inventory, name: &str) -> &'a ManagerObserved {
    let mut all = inventory.managers.iter();
    all.find(|m| m.key.name == name).unwrap()
}

fn held(inventory: &Inventory) -> Vec<&str> {
    inventory.held.iter().map(|h| h.instance.as_str()).collect()
}

fn file(node: &Node) -> PathBuf {
    node.home.path().join("state/local/restarts.json")
}

#[tokio::test]
async fn what_is_never_restarted_is_held_across_agents_until_its_system_changes() {
    let (controller, mut node, up) = hello(spec_with(1, "Printer0", never())).await;
    kill(process(&up, "Printer0").pid, Signal::KILL);
    let event = controller.event("NotRestarted").await;
    assert_eq!(
        (event.object.as_str(), event.system.as_deref()),
        ("component/Printer0", Some("hello"))
    );
    assert!(
        event.message.contains("rtsctl.restart is never"),
        "{}",
        event.message
    );
    let dead = node.until(|i| i.managers.len() == 1).await;
    assert_eq!(held(&dead), ["Printer0"]);
    assert_eq!(dead.held[0].system, system());
    assert!(dead.revision > up.revision);

    node.stop().await;
    drop(controller);
    node.start_again().await;
    let again = node.agent.inventory().await.unwrap();
    assert_eq!(again.held, dead.held);
    // The same spec changes nothing, another one does.
    let same = spec_with(2, "Printer0", never());
    node.agent.put_node_spec(&same).await.unwrap();
    assert_eq!(held(&node.agent.inventory().await.unwrap()), ["Printer0"]);
    node.accept(3).await;
    assert_eq!(node.agent.inventory().await.unwrap().held, []);
}

#[tokio::test]
async fn what_died_while_no_agent_watched_counts_and_what_was_stopped_does_not() {
    let mut agent = AgentProcess::start("off", &serving("")).await;
    for module in ["sine", "filter", "printer"] {
        let module = agent.node.home.path().join(format!("lib{module}.so"));
        std::fs::write(module, "").unwrap();
    }
    let spec = spec_with(1, "Printer0", never());
    agent.node.agent.put_node_spec(&spec).await.unwrap();
    let up = all_up(&agent.node, "up").await;
    // What lives where is written a moment later.
    tokio::time::sleep(Duration::from_secs(1)).await;
    agent.kill();
    for observed in &up.managers {
        kill(observed.pid, Signal::KILL);
        while lives(observed.pid) {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    }
    agent.start_again().await;
    let dead = agent.node.agent.inventory().await.unwrap();
    assert!(dead.managers.is_empty());
    assert_eq!(held(&dead), ["Printer0"]);
    let reason = &dead.held[0].reason;
    assert!(reason.contains("unknown reason"), "{reason}");
    // A plan from before it died is refused, a change brings it back.
    let late = agent.node.outcomes(&hello_batch("late", 1)).await;
    assert!(
        late.iter()
            .any(|(_, o)| o.contains("rtsctl.restart is never")),
        "{late:?}"
    );
    let changed = spec_with(2, "Printer0", Policy::default());
    agent.node.agent.put_node_spec(&changed).await.unwrap();
    let back = all_up_for(&agent.node, "again", 2).await;
    assert_eq!(held(&back), [""; 0]);
    let restarts = |i: &Inventory| ["Sine0", "Printer0"].map(|name| component(i, name).restarts);
    assert_eq!(restarts(&back), [1, 1]);

    for (plan, observed) in ["one", "two"].iter().zip(&back.managers) {
        assert_eq!(agent.stop_manager(plan, observed).await, "ok");
    }
    agent.kill();
    agent.start_again().await;
    let stopped = all_up_for(&agent.node, "third", 2).await;
    assert_eq!(restarts(&stopped), [1, 1]);
}

#[tokio::test]
async fn what_is_never_restarted_is_held_when_it_came_too_late_or_could_not_be_deleted() {
    for parameter in ["late", "stays"] {
        let node = Node::start().await;
        let spec = spec_with(1, "Printer0", never());
        node.agent.put_node_spec(&spec).await.unwrap();
        let mut make = create(3, &[2], "Printer0", "Printer0", "Printer");
        if let Work::Create { configuration, .. } = &mut make.work {
            let set = BTreeMap::from([(parameter.to_owned(), String::new())]);
            configuration.sets = BTreeMap::from([("default".to_owned(), set)]);
        }
        let delete = Work::Delete {
            manager: manager("Printer0"),
            instance: "Printer0".to_owned(),
        };
        let steps = vec![
            start_manager(1, "Printer0"),
            load(2, &[1], "Printer0", "Printer"),
            make,
            step(4, &[3], "component/Printer0", delete),
        ];
        let outcomes = node.outcomes(&batch("up", 1, steps)).await;
        assert!(
            outcomes.iter().any(|(_, o)| o.contains("still runs")),
            "{outcomes:?}"
        );
        let up = node.agent.inventory().await.unwrap();
        assert_eq!(component(&up, "Printer0").restarts, 0);
        kill(process(&up, "Printer0").pid, Signal::KILL);
        let dead = node.until(|i| i.managers.is_empty()).await;
        assert_eq!(held(&dead), ["Printer0"], "{parameter}");
    }
}

/// Makes all of the hello system.
async fn all_up(node: &Node, plan: &str) -> Inventory {
    all_up_for(node, plan, 1).await
}

async fn all_up_for(node: &Node, plan: &str, generation: u64) -> Inventory {
    let outcomes = node.outcomes(&hello_batch(plan, generation)).await;
    assert!(outcomes.iter().all(|(_, o)| o == "ok"), "{outcomes:?}");
    node.agent.inventory().await.unwrap()
}

#[tokio::test]
async fn after_a_reboot_nothing_is_held_and_a_damaged_file_hinders_nobody() {
    let (_controller, mut node, up) = hello(spec_with(1, "Printer0", never())).await;
    kill(process(&up, "Printer0").pid, Signal::KILL);
    node.until(|i| !i.held.is_empty()).await;
    node.stop().await;
    let text = std::fs::read_to_string(file(&node)).unwrap();
    let boot = rts_host::identity::boot_id().unwrap();
    assert!(text.contains(&boot));
    std::fs::write(file(&node), text.replace(&boot, "the boot before")).unwrap();
    node.start_again().await;
    assert_eq!(node.agent.inventory().await.unwrap().held, []);

    node.stop().await;
    std::fs::write(file(&node), "{").unwrap();
    node.start_again().await;
    assert_eq!(node.agent.inventory().await.unwrap().held, []);
    assert!(file(&node).with_file_name("restarts.json.damaged").exists());
}

/// Makes a component pretend that it is in a callback.
async fn pretend(node: &Node, plan: &str, busy: &str) {
    let set = BTreeMap::from([("busy".to_owned(), busy.to_owned())]);
    let work = Work::Configure {
        manager: manager("main"),
        instance: "Sine0".to_owned(),
        configuration: Configuration {
            active: None,
            sets: BTreeMap::from([("default".to_owned(), set)]),
        },
        rate: None,
        on_disconnect: None,
        order: None,
    };
    let outcomes = node
        .outcomes(&batch(plan, 1, vec![step(1, &[], "component/Sine0", work)]))
        .await;
    assert_eq!(outcomes, [(1, "ok".to_owned())]);
}

#[tokio::test]
async fn what_hangs_is_told_when_it_begins_and_when_it_is_over() {
    let (controller, node, _) = hello(spec_with(1, "Sine0", replaced(60_000))).await;
    pretend(&node, "slow", "on_execute 59000").await;
    let slow = node.agent.inventory().await.unwrap();
    assert_eq!(component(&slow, "Sine0").hangs, None);
    pretend(&node, "hangs", "on_execute 61000").await;
    let begun = controller.event("Hangs").await;
    assert_eq!(
        (begun.kind.as_str(), begun.object.as_str()),
        ("Warning", "component/Sine0")
    );
    let hanging = node.until(|i| process(i, "main").expired.is_some()).await;
    assert_eq!(
        process(&hanging, "main").expired.as_deref(),
        Some("Sine0 has been in on_execute for longer than 60 s (rtsctl.livenessTimeout)")
    );
    pretend(&node, "goes on", "on_execute 71000").await;
    let later = node.agent.inventory().await.unwrap();
    assert_eq!(later.revision, hanging.revision + 1, "for its parameter");
    tokio::time::sleep(Duration::from_millis(1500)).await;
    let still = node.agent.inventory().await.unwrap();
    assert_eq!(still.revision, later.revision);
    pretend(&node, "over", "").await;
    let over = controller.event("Hangs").await;
    assert_eq!(over.kind, "Normal");
    let well = node.agent.inventory().await.unwrap();
    assert_eq!(process(&well, "main").expired, None);
}

#[tokio::test]
async fn the_replacement_of_what_hangs_counts_as_a_death() {
    let policy = Policy {
        restart_limit: Some(0),
        ..replaced(2_000)
    };
    let (controller, node, up) = hello(spec_with(1, "Sine0", policy)).await;
    pretend(&node, "hangs", "on_execute 2000").await;
    node.until(|i| process(i, "main").expired.is_some()).await;
    let main = process(&up, "main");
    let work = Work::StopManager {
        manager: main.key.clone(),
        incarnation: main.incarnation.clone(),
    };
    let stop = batch("stop", 1, vec![step(1, &[], "manager/hello.main", work)]);
    assert_eq!(node.outcomes(&stop).await, [(1, "ok".to_owned())]);
    let event = controller.event("NotRestarted").await;
    assert!(
        event.message.contains("restartLimit 0"),
        "{}",
        event.message
    );
    let gone = node.agent.inventory().await.unwrap();
    assert_eq!(held(&gone), ["Sine0"]);
}

#[tokio::test]
async fn a_silent_process_is_told_soon_and_expires_after_its_time() {
    let (controller, node, up) = hello(spec_with(1, "Sine0", replaced(1_500))).await;
    let main = process(&up, "main").pid;
    let stopped = tokio::time::Instant::now();
    kill(main, Signal::STOP);
    controller.event("ManagerSilent").await;
    // About 3 s, and room for a machine that is busy.
    assert!(stopped.elapsed() < Duration::from_secs(6));
    let expired = node.until(|i| process(i, "main").expired.is_some()).await;
    assert_eq!(
        process(&expired, "main").expired.as_deref(),
        Some(
            "its process has not answered for longer than 1500 ms (rtsctl.livenessTimeout of Sine0)"
        )
    );
    kill(main, Signal::CONT);
    controller.event("ManagerAnswers").await;
    node.until(|i| process(i, "main").expired.is_none()).await;
}
