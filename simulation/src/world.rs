//! Everything that there is in a run: hosts with their machines, disks and clocks, the store, the network between them.

pub mod lives;
pub mod programs;
pub mod setup;
pub mod trouble;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rts_agent_api::messages::LedgerFence;
use serde::Deserialize;
use tokio::time::Instant;

use self::lives::Lives;
use self::setup::{NodeSetup, Setup};
use crate::clock::SimClock;
use crate::disk::SimDisk;
use crate::faults::Fault;
use crate::fleet::Hosts;
use crate::life::Life;
use crate::machine::SimMachine;
use crate::net::Net;
use crate::seed::Seed;
use crate::store::SimStore;
use crate::truth::{Happened, Truth};
use crate::words::CONTROLLER;

/// What is shared by all parts of a run.
pub struct World {
    /// All chance comes from it.
    pub seed: Seed,
    /// Network.
    pub net: Net,
    /// Programs that serve.
    pub hosts: Hosts,
    /// Is told everything that really happens.
    pub truth: Truth,
    /// Nodes by name.
    pub nodes: BTreeMap<String, Node>,
    /// The controller's wall clock.
    pub clock: SimClock,
    /// The controller's own node.
    pub local_node: String,
    lives: Lives,
    store: Mutex<SimStore>,
    restores: AtomicU64,
    /// How many of these stores a controller has come up with.
    served: AtomicU64,
    /// Faults that last and are not over, by number.
    going_on: Mutex<BTreeMap<u64, Fault>>,
}

/// A node.
pub struct Node {
    /// Its machine.
    pub machine: SimMachine,
    /// Its disk.
    pub disk: SimDisk,
    /// Its wall clock.
    pub clock: SimClock,
    /// Other names of it.
    pub aliases: Vec<String>,
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
    /// Machines on which nothing runs yet.
    pub fn new(seed: Seed, setup: Setup) -> Arc<Self> {
        let (truth, net, begin) = (Truth::new(), Net::new(seed), Instant::now());
        let node = |node: NodeSetup| {
            let clock = SimClock::new(begin);
            let machine = SimMachine::new(&node.name, seed, clock.clone(), truth.clone());
            if let Some(probability) = node.grandchildren {
                machine.grandchildren(probability);
            }
            for module in node.modules {
                machine.install(module);
            }
            let disk = SimDisk::new(&node.name, seed);
            let aliases = node.aliases;
            let own = Node {
                machine,
                disk,
                clock,
                aliases,
            };
            (node.name, own)
        };
        let nodes: BTreeMap<String, Node> = setup.nodes.into_iter().map(node).collect();
        SimMachine::connect(nodes.values().map(|node| &node.machine));
        let hosts = nodes.keys().map(String::as_str).chain([CONTROLLER]);
        Arc::new(Self {
            hosts: Hosts::new(net.clone(), truth.clone()),
            lives: Lives::new(hosts, setup.tries_again),
            clock: SimClock::new(begin),
            local_node: setup.local_node,
            store: Mutex::new(setup.store),
            restores: AtomicU64::new(0),
            served: AtomicU64::new(0),
            going_on: Mutex::default(),
            seed,
            net,
            truth,
            nodes,
        })
    }

    /// Something that a schedule or a user does.
    pub fn note(&self, words: impl Into<String>) {
        self.truth.tell(&Happened::Note(words.into()));
    }

    /// The programs of the hosts.
    pub fn lives(&self) -> &Lives {
        &self.lives
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

    /// A controller has come up with the store that this many restores led to.
    pub fn serves(&self, restores: u64) {
        self.served.fetch_max(restores, Ordering::Relaxed);
    }

    /// False after a restore until a controller has come up with that store: who answers till then is the one of before.
    pub fn is_served(&self) -> bool {
        self.served.load(Ordering::Relaxed) == self.restores()
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

    /// The text of the ledger on a node's disk: that of its two files which counts.
    pub fn ledger_text(&self, node: &str) -> Option<Vec<u8>> {
        let disk = &self.nodes.get(node)?.disk;
        let path = |name| PathBuf::from(format!("/sim/state/{node}/{name}"));
        let names = ["node-spec.json", "node-spec.2.json"].into_iter();
        let texts: Vec<_> = names
            .filter_map(|name| disk.contents(&path(name)))
            .collect();
        let texts: Vec<&[u8]> = texts.iter().map(Vec::as_slice).collect();
        rts_agent::newest_ledger(&texts).map(<[u8]>::to_vec)
    }

    /// A life has ended.
    fn crashed(&self, life: &Life) {
        self.lives.crashed(life);
        self.truth.tell(&Happened::Crashed {
            host: life.host().to_owned(),
            life: life.number(),
        });
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
