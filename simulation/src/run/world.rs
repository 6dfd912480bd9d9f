//! Everything that there is in a run.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rts_agent_api::messages::LedgerFence;
use serde::Deserialize;
use tokio::sync::Notify;
use tokio::time::Instant;

use super::coverage::Coverage;
use super::ground::Ground;
use crate::check::{self, Desired, Verdicts};
use crate::clock::SimClock;
use crate::disk::SimDisk;
use crate::fleet::Hosts;
use crate::life::Life;
use crate::machine::SimMachine;
use crate::modules::SimModule;
use crate::net::Net;
use crate::seed::Seed;
use crate::store::SimStore;
use crate::trace::Trace;
use crate::truth::{Happened, Truth};
use crate::workload::{NODES, TYPES};

/// Time from the end of a program to its next start, where no fault says another.
const DOWN: Duration = Duration::from_secs(1);

/// What is shared by all parts of a run.
pub(super) struct World {
    pub seed: Seed,
    pub net: Net,
    pub hosts: Hosts,
    pub truth: Truth,
    pub trace: Trace,
    pub ground: Ground,
    pub coverage: Coverage,
    pub desired: Desired,
    pub verdicts: Verdicts,
    pub nodes: BTreeMap<String, Node>,
    pub clock: SimClock,
    store: Mutex<SimStore>,
    restores: AtomicU64,
    programs: Mutex<BTreeMap<String, Program>>,
    /// Told when a program may start earlier than it thought.
    hurry: Notify,
}

/// The machine of a node.
pub(super) struct Node {
    pub machine: SimMachine,
    pub disk: SimDisk,
    pub clock: SimClock,
}

/// The program of a host.
struct Program {
    lives: u32,
    life: Option<Life>,
    not_before: Instant,
    /// Of the next crash.
    down: Option<Duration>,
    /// Lives that are no longer the host's own.
    retired: Vec<u32>,
}

/// The head of a ledger's file.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Ledger {
    cluster_uid: String,
    epoch: u64,
    generation: u64,
    digest: String,
}

impl World {
    /// Machines on which nothing runs, and an empty store.
    pub fn new(seed: Seed, nodes: usize, trace: Trace) -> Arc<Self> {
        let truth = Truth::new();
        let (ground, coverage, desired) =
            (Ground::default(), Coverage::default(), Desired::default());
        truth.show(trace.clone());
        truth.show(ground.clone());
        truth.show(coverage.clone());
        let verdicts = check::watch(&truth, &desired);
        let net = Net::new(seed);
        let begin = Instant::now();
        let node = |name: &&str| {
            let clock = SimClock::new(begin);
            let machine = SimMachine::new(name, seed, clock.clone(), truth.clone());
            for type_name in TYPES {
                machine.install(module(type_name, 1));
            }
            let disk = SimDisk::new(name, seed);
            (
                (*name).to_owned(),
                Node {
                    machine,
                    disk,
                    clock,
                },
            )
        };
        let nodes: BTreeMap<String, Node> = NODES.iter().take(nodes).map(node).collect();
        let program = |host: String| {
            let program = Program {
                lives: 0,
                life: None,
                not_before: begin,
                down: None,
                retired: Vec::new(),
            };
            (host, program)
        };
        let mut programs: BTreeMap<_, _> = nodes.keys().cloned().map(program).collect();
        programs.extend([program("controller".to_owned())]);
        Arc::new(Self {
            hosts: Hosts::new(net.clone(), truth.clone()),
            store: Mutex::new(SimStore::new(seed, "simulated")),
            restores: AtomicU64::new(0),
            clock: SimClock::new(begin),
            programs: Mutex::new(programs),
            hurry: Notify::new(),
            seed,
            net,
            truth,
            trace,
            ground,
            coverage,
            desired,
            verdicts,
            nodes,
        })
    }

    /// Something that a schedule or a user does.
    pub fn note(&self, words: impl Into<String>) {
        self.truth.tell(&Happened::Note(words.into()));
    }

    /// The controller's store.
    pub fn store(&self) -> SimStore {
        lock(&self.store).clone()
    }

    /// Puts another store in its place. Whoever has the old one keeps it.
    pub fn put_store(&self, store: SimStore) {
        *lock(&self.store) = store;
        self.restores.fetch_add(1, Ordering::Relaxed);
    }

    /// How often that was done.
    pub fn restores(&self) -> u64 {
        self.restores.load(Ordering::Relaxed)
    }

    /// What the ledger on a node's disk says.
    pub fn ledger(&self, node: &str) -> Option<LedgerFence> {
        let text = self.ledger_text(node)?;
        let ledger: Ledger = serde_json::from_slice(&text).ok()?;
        Some(LedgerFence {
            cluster_uid: ledger.cluster_uid,
            epoch: ledger.epoch,
            generation: ledger.generation,
            digest: ledger.digest,
        })
    }

    /// The text of the ledger on a node's disk.
    pub fn ledger_text(&self, node: &str) -> Option<Vec<u8>> {
        let path = PathBuf::from(format!("/sim/state/{node}/node-spec.json"));
        self.nodes.get(node)?.disk.contents(&path)
    }

    /// Waits until the program of a host may start, and begins a life of it.
    pub async fn new_life(&self, host: &str) -> Life {
        loop {
            let hurry = self.hurry.notified();
            let until = self
                .program(host, |p| p.not_before)
                .unwrap_or_else(Instant::now);
            if until <= Instant::now() {
                break;
            }
            tokio::select! {
                biased;
                () = hurry => {}
                () = tokio::time::sleep_until(until) => {}
            }
        }
        let begun = self.program(host, |program| {
            program.lives += 1;
            let life = Life::new(host, program.lives);
            program.life = Some(life.clone());
            life
        });
        // There is a program of each host.
        begun.unwrap_or_else(|| Life::new(host, 0))
    }

    /// A program has crashed: when it may start again.
    pub fn crashed(&self, life: &Life) {
        self.program(life.host(), |program| {
            if program
                .life
                .as_ref()
                .is_none_or(|own| own.number() != life.number())
            {
                return;
            }
            let down = program.down.take().unwrap_or(DOWN);
            program.not_before = program.not_before.max(Instant::now() + down);
        });
        self.truth.tell(&Happened::Crashed {
            host: life.host().to_owned(),
            life: life.number(),
        });
    }

    /// Ends the life of a host's program, or sets its fuse. False when it does not live.
    pub fn end(&self, host: &str, calls: u64, down: Duration) -> bool {
        let life = self.program(host, |program| {
            let life = program.life.clone().filter(|life| !life.is_over())?;
            program.down = Some(down);
            Some(life)
        });
        let Some(life) = life.flatten() else {
            return false;
        };
        if calls == 0 {
            life.end();
        } else {
            life.burn(calls);
        }
        true
    }

    /// The life of a host's program is no longer the host's own: it goes on, and is not started again. None when it does
    /// not live.
    pub fn retire(&self, host: &str) -> Option<Life> {
        let life = self.program(host, |program| {
            let life = program.life.take_if(|life| !life.is_over());
            program.retired.extend(life.iter().map(Life::number));
            life
        });
        life.flatten()
    }

    /// True for a life that was retired.
    pub fn is_retired(&self, life: &Life) -> bool {
        let retired = self.program(life.host(), |p| p.retired.contains(&life.number()));
        retired.unwrap_or(false)
    }

    /// A program must not start for a while, even if it is down already.
    pub fn keep_down(&self, host: &str, down: Duration) {
        let until = Instant::now() + down;
        self.program(host, |p| p.not_before = p.not_before.max(until));
    }

    /// Nothing keeps a program from starting any more, and no crash is to come.
    pub fn let_start(&self, host: &str) {
        self.program(host, |program| {
            program.not_before = Instant::now();
            program.down = None;
            if let Some(life) = &program.life {
                life.burn(u64::MAX);
            }
        });
        self.hurry.notify_waiters();
    }

    fn program<T>(&self, host: &str, of: impl FnOnce(&mut Program) -> T) -> Option<T> {
        lock(&self.programs).get_mut(host).map(of)
    }
}

/// The `version`th module of a type of the workload.
pub(super) fn module(type_name: &str, version: u32) -> SimModule {
    let mut module = SimModule::new(type_name)
        .port("in", "in", "TimedDouble")
        .port("out", "out", "TimedDouble")
        .parameter("gain", "1")
        .parameter("offset", "0");
    module.digest = module.version(version);
    module
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
