//! Death, hanging and adoption of managers; the session with a controller.

use std::time::Duration;

use rts_agent_api::AgentApi;
use rts_plan::observed::LifeCycleState;
use rts_plan::plan::Work;
use rustix::process::Signal;

use crate::fake_controller::FakeController;
use crate::setup::{
    Node, batch, component, create, hello_batch, kill, lives, load, manager, start_manager, step,
};

#[tokio::test]
async fn the_death_of_a_manager_is_told_and_its_components_count_a_restart() {
    let controller = FakeController::start().await;
    let node = Node::with("grandchild", Some(controller.socket())).await;
    let greeting = controller.greeting().await;
    assert_eq!(greeting.aliases, ["robot"]);
    assert_eq!(greeting.ledger, None);
    assert_eq!(greeting.inventory.revision, 1);
    node.hello().await;
    let up = node.agent.inventory().await.unwrap();
    let main = &up.managers[1];
    kill(main.pid, Signal::KILL);
    let event = controller.event("ManagerDied").await;
    assert_eq!(
        (event.kind.as_str(), event.object.as_str()),
        ("Warning", "manager/hello.main")
    );
    assert_eq!(event.system.as_deref(), Some("hello"));
    assert!(event.message.contains("signal 9"), "{}", event.message);
    assert!(
        event.message.contains("Filter0, Sine0"),
        "{}",
        event.message
    );
    controller.revision_above(up.revision).await;
    let left = node.until(|i| i.managers.len() == 1).await;
    assert!(left.revision > up.revision);
    assert_eq!(
        component(&left, "Printer0").incarnation,
        component(&up, "Printer0").incarnation
    );
    assert_eq!(node.managers().len(), 1, "its run folder is removed");

    let outcomes = node.outcomes(&hello_batch("again", 1)).await;
    assert!(outcomes.iter().all(|(_, o)| o == "ok"), "{outcomes:?}");
    let again = node.agent.inventory().await.unwrap();
    assert_eq!(component(&again, "Sine0").restarts, 1);
    assert_eq!(component(&again, "Printer0").restarts, 0);
}

#[tokio::test]
async fn a_component_that_kills_its_process_while_it_is_made_fails_its_step_and_is_counted() {
    let node = Node::start().await;
    node.accept(1).await;
    let crash = |plan: &str, type_name: &str| {
        batch(
            plan,
            1,
            vec![
                start_manager(1, "main"),
                load(2, &[1], "main", type_name),
                create(3, &[2], "main", "Sine0", type_name),
            ],
        )
    };
    let outcomes = node.outcomes(&crash("bad", "Crash")).await;
    assert!(
        outcomes[2].1.contains("was lost before it answered"),
        "{outcomes:?}"
    );
    node.until(|i| i.managers.is_empty()).await;
    let outcomes = node.outcomes(&crash("good", "Sine")).await;
    assert!(outcomes.iter().all(|(_, o)| o == "ok"), "{outcomes:?}");
    let up = node.agent.inventory().await.unwrap();
    assert_eq!(component(&up, "Sine0").restarts, 1);
}

#[tokio::test]
async fn managers_outlive_their_agent_and_are_adopted() {
    let controller = FakeController::start().await;
    let mut node = Node::with("", Some(controller.socket())).await;
    node.hello().await;
    let before = node.agent.inventory().await.unwrap();
    node.stop().await;
    assert!(before.managers.iter().all(|m| lives(m.pid)));
    // One dies while nobody watches.
    kill(before.managers[0].pid, Signal::KILL);
    let dead = before.managers[0].pid;
    wait_until(|| !lives(dead)).await;

    node.start_again().await;
    let after = node.agent.inventory().await.unwrap();
    assert_eq!(after.managers.len(), 1);
    assert_eq!(
        after.managers[0].incarnation,
        before.managers[1].incarnation
    );
    assert_eq!(after.managers[0].started, before.managers[1].started);
    assert!(after.managers[0].responsive);
    assert_eq!(component(&after, "Sine0").state, LifeCycleState::Active);
    assert_eq!(node.managers().len(), 1, "the dead one's folder is removed");
    controller.event("ManagerAdopted").await;

    kill(after.managers[0].pid, Signal::KILL);
    let event = controller.event("ManagerDied").await;
    assert!(
        event.message.contains("exit status unknown"),
        "{}",
        event.message
    );
    node.until(|i| i.managers.is_empty()).await;
    assert_eq!(node.managers(), []);
}

#[tokio::test]
async fn a_manager_that_hangs_is_shown_with_what_it_last_held_and_can_be_stopped() {
    let controller = FakeController::start().await;
    let node = Node::with("", Some(controller.socket())).await;
    node.hello().await;
    let up = node.agent.inventory().await.unwrap();
    let main = up.managers[1].clone();
    kill(main.pid, Signal::STOP);
    controller.event("ManagerSilent").await;
    let hanging = node.agent.inventory().await.unwrap();
    assert!(!hanging.managers[1].responsive && hanging.managers[0].responsive);
    assert_eq!(hanging.managers[1].components.len(), 2);
    kill(main.pid, Signal::CONT);
    controller.event("ManagerAnswers").await;

    kill(main.pid, Signal::STOP);
    node.until(|i| !i.managers[1].responsive).await;
    let work = Work::StopManager {
        manager: manager("main"),
        incarnation: main.incarnation.clone(),
    };
    let outcomes = node
        .outcomes(&batch(
            "stop",
            1,
            vec![step(1, &[], "manager/hello.main", work)],
        ))
        .await;
    assert_eq!(outcomes, [(1, "ok".to_owned())]);
    assert!(!lives(main.pid));
    assert_eq!(node.agent.inventory().await.unwrap().managers.len(), 1);
}

#[tokio::test]
async fn of_a_process_that_dies_while_it_is_asked_only_the_death_is_told() {
    let controller = FakeController::start().await;
    let node = Node::with("", Some(controller.socket())).await;
    node.hello().await;
    let up = node.agent.inventory().await.unwrap();
    // It is asked, and has no time to answer before it dies.
    kill(up.managers[1].pid, Signal::STOP);
    let asked = node.agent.inventory();
    let dies = async {
        tokio::time::sleep(Duration::from_millis(300)).await;
        kill(up.managers[1].pid, Signal::KILL);
    };
    let (asked, ()) = tokio::join!(asked, dies);
    asked.unwrap();
    let mut told = Vec::new();
    let end = tokio::time::Instant::now() + Duration::from_millis(2500);
    while tokio::time::Instant::now() < end {
        let events = controller.heartbeat().await.events.into_iter();
        told.extend(
            events
                .map(|e| e.reason)
                .filter(|r| r.starts_with("Manager")),
        );
    }
    told.retain(|reason| reason != "ManagerStarted");
    assert_eq!(told, ["ManagerDied"]);
}

#[tokio::test]
async fn a_controller_that_forgot_the_session_is_greeted_again_and_a_newer_session_ends_it() {
    let controller = FakeController::start().await;
    let node = Node::with("", Some(controller.socket())).await;
    let first = controller.greeting().await;
    controller.forget();
    let second = controller.greeting().await;
    assert_eq!(first.session, second.session);
    controller.supersede();
    controller.quiet().await;
    // It goes on serving.
    assert_eq!(node.agent.node().await.unwrap().session, first.session);
}

#[tokio::test]
async fn an_agent_works_without_its_controller_and_greets_it_when_it_comes() {
    let folder = tempfile::tempdir().unwrap();
    let socket = folder.path().join("controller.sock");
    let node = Node::with("", Some(socket.clone())).await;
    node.hello().await;
    let controller = FakeController::at(folder, socket).await;
    let greeting = controller.greeting().await;
    assert_eq!(greeting.ledger.map(|ledger| ledger.generation), Some(1));
    assert_eq!(greeting.inventory.managers.len(), 2);
    controller.event("ManagerStarted").await;
}

async fn wait_until(done: impl Fn() -> bool) {
    let end = tokio::time::Instant::now() + crate::setup::PATIENCE;
    while !done() {
        assert!(tokio::time::Instant::now() < end);
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
}
