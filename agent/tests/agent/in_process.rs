//! An agent within this process, of which nothing comes from outside: no socket, file, process, clock or chance.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use futures_util::StreamExt;
use jiff::Timestamp;
use rts_agent::launch::Exit;
use rts_agent::peers::HomePeers;
use rts_agent::{Config, Inputs, LocalAgent, Running, StartError};
use rts_agent_api::AgentApi;
use rts_agent_api::messages::{Batch, BatchEvent, StepOutcome};
use rts_host::clock::{Chance, Clock};
use rts_plan::observed::Inventory;
use tokio::time::{Instant, sleep};

use crate::fake_machine::FakeNode;
use crate::setup::{batch, hello_spec, problem, start_manager};

/// When all of it happens.
const NOW: &str = "2001-02-03T04:05:06Z";

struct At(Timestamp);

impl Clock for At {
    fn now(&self) -> Timestamp {
        self.0
    }
}

/// Counts.
#[derive(Default)]
struct Counts(AtomicU32);

impl Chance for Counts {
    fn unit(&self) -> f64 {
        0.5
    }

    fn uuid(&self) -> String {
        format!("id-{}", self.0.fetch_add(1, Ordering::SeqCst) + 1)
    }
}

async fn start(node: &FakeNode) -> Running {
    start_with(node, Some(Duration::from_secs(3))).await
}

/// One that heals by itself after a while, or never.
pub async fn start_with(node: &FakeNode, heal_after: Option<Duration>) -> Running {
    let config = Config {
        home: "/nowhere".into(),
        node: "local".to_owned(),
        aliases: Vec::new(),
        module_path: Vec::new(),
        manager_program: "/nowhere/rts-manager".into(),
        controller_socket: None,
        heal_after,
        idle_managers: None,
    };
    let inputs = Inputs {
        clock: Arc::new(At(NOW.parse().unwrap())),
        chance: Arc::new(Counts::default()),
        disk: node.disk.clone(),
        machine: node.machine.clone(),
        controller: None,
        peers: Arc::new(HomePeers::new(Path::new("/none"))),
    };
    rts_agent::start(config, inputs).await.unwrap()
}

pub async fn run(agent: &LocalAgent, batch: &Batch) -> Vec<BatchEvent> {
    let events = agent.run_batch(batch).await.unwrap();
    events.map(Result::unwrap).collect().await
}

fn only(inventory: &Inventory) -> (String, u32) {
    let [manager] = &inventory.managers[..] else {
        panic!("{inventory:#?}");
    };
    (manager.incarnation.clone(), manager.pid)
}

#[tokio::test(start_paused = true)]
async fn it_works_restarts_and_heals_with_nothing_from_outside() {
    let node = FakeNode::default();
    let running = start(&node).await;
    let agent = running.api();
    assert_eq!(problem(agent.node_spec().await).status, 404);
    let spec = hello_spec(1);
    assert!(agent.put_node_spec(&spec).await.unwrap().changed);
    assert!(!agent.put_node_spec(&spec).await.unwrap().changed);
    assert_eq!(agent.node_spec().await.unwrap(), spec);
    let events = run(&agent, &batch("up", 1, vec![start_manager(1, "main")])).await;
    assert_eq!(events.len(), 4, "{events:?}");
    assert_eq!(events.last(), Some(&BatchEvent::End));
    // The first id is the session's.
    let first = ("id-2".to_owned(), 1001);
    assert_eq!(only(&agent.inventory().await.unwrap()), first);
    let stale = batch("stale", 7, Vec::new());
    let refused = problem(agent.run_batch(&stale).await.map(drop));
    assert_eq!(refused.code, "stale-generation");
    let found = agent.resolve_modules(&["Sine".to_owned()]).await.unwrap();
    let description = found[0].module.as_ref().unwrap().description.as_ref();
    assert_eq!(description.unwrap().parameters["gain"], "1");
    running.stop().await;

    // The next agent finds the manager, and what the node was told.
    let running = start(&node).await;
    let agent = running.api();
    assert_eq!(only(&agent.inventory().await.unwrap()), first);
    assert_eq!(agent.node_spec().await.unwrap(), spec);
    let folders = node.machine.run_folders_now();
    let living = node.machine.living(&folders[0]).unwrap();

    // It dies, and is started again by the agent alone.
    let begin = Instant::now();
    living.end(Exit::Signal(9));
    let healed = loop {
        sleep(Duration::from_millis(100)).await;
        let inventory = agent.inventory().await.unwrap();
        if inventory.managers.len() == 2 {
            break inventory;
        }
        assert!(begin.elapsed() < Duration::from_secs(60), "{inventory:#?}");
    };
    assert!(healed.managers.iter().all(|m| m.incarnation != first.0));
    running.stop().await;
    let files = node.disk.0.lock().unwrap();
    let names: Vec<_> = files.keys().map(|path| path.as_path()).collect();
    let state = Path::new("/nowhere/state/local");
    let expected = ["node-spec.2.json", "node-spec.json", "restarts.json"];
    let expected = expected.map(|name| state.join(name));
    assert_eq!(names, expected);
}

#[tokio::test(start_paused = true)]
async fn what_does_not_die_and_who_takes_the_node_are_told() {
    let node = FakeNode::default();
    let mut running = start(&node).await;
    let agent = running.api();
    agent.put_node_spec(&hello_spec(1)).await.unwrap();
    node.machine.undying.store(true, Ordering::SeqCst);
    let events = run(&agent, &batch("up", 1, vec![start_manager(1, "main")])).await;
    let reason = events.iter().find_map(|event| match event {
        BatchEvent::Finished {
            outcome: StepOutcome::Failed { reason },
            ..
        } => Some(reason.clone()),
        _ => None,
    });
    insta::assert_snapshot!(reason.unwrap(), @"StartManager manager/hello.main: the manager hello.main that ran, or what it started, does not end, so no new one can start; look at its processes with `ps`");
    assert!(node.machine.run_folders_now().is_empty(), "none is left");
    node.machine.taken.store(true, Ordering::SeqCst);
    assert!(matches!(running.lost().await, StartError::Running { .. }));
}
