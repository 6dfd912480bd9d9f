//! Everything that goes wrong at once, and the same again.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use rts_agent::Running;
use rts_agent_api::AgentApi;
use rts_schemas::system::{OnDisconnect, OnHang, Policy};
use rts_simulation::faults::Misbehaviour;
use rts_simulation::truth::Witness;
use rts_simulation::{Happened, Life};
use tokio::time::{sleep, timeout};

use crate::setup::*;

/// All that happens in a run with a crash, a death and a hang, and when.
async fn story(seed: u64) -> Vec<String> {
    let node = Node::new(seed);
    let lines = Arc::<Mutex<Vec<String>>>::default();
    node.truth.show(Lines(lines.clone()));
    let life = Life::new("node1", 1);
    let agent = node.start(&life).await;
    life.burn(700);
    let first = async {
        bring_up(&agent).await;
        sleep(LONG).await;
    };
    let _ = timeout(Duration::from_secs(20), first).await;
    life.end();
    node.disk.slow(Some(Duration::from_millis(50)));
    let agent_2 = node.start(&Life::new("node1", 2)).await;
    until_up(&agent_2).await;
    node.machine.kill(None);
    node.machine
        .misbehave("Filter0", Some(Misbehaviour::SlowActivate));
    sleep(Duration::from_secs(10)).await;
    until_up(&agent_2).await;
    node.machine
        .misbehave("Filter0", Some(Misbehaviour::CrashLater));
    sleep(Duration::from_secs(30)).await;
    drop(agent);
    let mut lines = lines.lock().unwrap();
    std::mem::take(&mut *lines)
}

struct Lines(Arc<Mutex<Vec<String>>>);

impl Witness for Lines {
    fn see(&mut self, at: Duration, what: &Happened) {
        self.0.lock().unwrap().push(format!("{at:?} {what:?}"));
    }
}

#[tokio::test(start_paused = true)]
async fn a_seed_replays_exactly() {
    for seed in 0..2 {
        let first = story(seed).await;
        let second = story(seed).await;
        assert!(first.len() > 30, "{first:#?}");
        let differs = first.iter().zip(&second).find(|(a, b)| a != b);
        assert_eq!(differs, None);
        assert_eq!(first.len(), second.len());
        assert_ne!(first, story(seed + 100).await);
    }
}

/// All ways to misbehave.
const HOWS: [Misbehaviour; 13] = [
    Misbehaviour::CrashAtOnce,
    Misbehaviour::CrashLater,
    Misbehaviour::HangInitialize,
    Misbehaviour::HangActivate,
    Misbehaviour::HangExecute,
    Misbehaviour::HangDeactivate,
    Misbehaviour::HangFinalize,
    Misbehaviour::ErrorInitialize,
    Misbehaviour::ErrorActivate,
    Misbehaviour::ErrorExecute,
    Misbehaviour::Panic,
    Misbehaviour::IgnoreDeactivate,
    Misbehaviour::SlowActivate,
];

/// One agent after the other, while everything goes wrong for a while.
async fn turmoil(seed: u64) {
    let node = Node::new(seed);
    let chance = node.seed.stream("turmoil");
    let mut number = 1;
    let mut life = Life::new("node1", number);
    let mut agent = Some(node.start(&life).await);
    let first = agent.as_ref().map(Running::api).unwrap();
    let policy = Policy {
        on_hang: OnHang::Restart,
        liveness_timeout_ms: Some(3_000),
        start_timeout_ms: Some(3_000),
        reset_on_error: true,
        on_disconnect: match seed % 3 {
            0 => OnDisconnect::Keep,
            1 => OnDisconnect::Deactivate,
            _ => OnDisconnect::Stop,
        },
        ..Policy::default()
    };
    let spec = node_spec_with(&policy);
    first.put_node_spec(&spec).await.unwrap();
    for _ in 0..12 {
        let instance = COMPONENTS[chance.between(0, 2) as usize].0;
        match chance.between(0, 8) {
            0 | 1 => drop(node.machine.kill(None)),
            2 => node
                .machine
                .misbehave(instance, chance.pick(&HOWS).copied()),
            7 => drop(node.machine.hang(None)),
            3 => node.machine.fail_to_start(chance.chance(0.5)),
            4 => node.disk.fail_writes(chance.chance(0.5)),
            5 => {
                life.end();
                if chance.chance(0.5) {
                    node.machine.reboot();
                    node.disk.lose_power();
                }
            }
            6 => life.burn(chance.between(1, 200)),
            _ => node.disk.slow(Some(Duration::from_millis(300))),
        }
        sleep(Duration::from_millis(chance.between(0, 6_000))).await;
        if life.is_over() {
            number += 1;
            life = Life::new("node1", number);
            agent = timeout(LONG, node.start(&life)).await.ok();
        }
    }
    node.machine.fail_to_start(false);
    node.disk.fail_writes(false);
    node.disk.slow(None);
    for (instance, ..) in COMPONENTS {
        node.machine.misbehave(instance, None);
    }
    life.end();
    let last = node.start(&Life::new("node1", number + 1)).await;
    let up = until_up(&last).await;
    sleep(Duration::from_secs(40)).await;
    assert_eq!(until_up(&last).await, up, "{seed}");
    let left = node.machine.left_over();
    assert_eq!(left.processes.len(), 2, "{seed}: {left:?}");
    assert_eq!(left.folders.len(), 2, "{seed}: {left:?}");
    assert_eq!(left.components.len(), 3, "{seed}: {left:?}");
    assert_eq!(left.connectors.len(), 4, "{seed}: {left:?}");
    drop(agent);
}

#[tokio::test(start_paused = true)]
async fn after_any_turmoil_the_node_runs_what_it_was_told() {
    for seed in 0..9 {
        turmoil(seed).await;
    }
}
