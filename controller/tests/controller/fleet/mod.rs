//! A fleet of agents in memory: each carries steps out on a little world of its own, and can be made to fail, to be
//! silent, to be slow.
#![allow(dead_code, reason = "each test program uses a part of it")]

mod agent;
mod by_hand;
mod carry_out;
pub mod served;
pub mod stores;
pub mod systems;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use futures_util::FutureExt;
use jiff::Timestamp;
use rts_agent_api::ClientError;
use rts_agent_api::session::{Heartbeat, SessionGreeting};
use rts_controller::clock::{Chance, Clock};
use rts_controller::fleet::{Agent, Fleet};
use rts_controller::simulator::{NoSimulator, Simulator};
use rts_controller::store::MemoryStore;
use rts_controller::{Core, Inputs, Reconciler};
use rts_controller_api::objects::{Component, Event, Phase, System};
use rts_controller_api::requests::{ApplyRequest, ApplyResult};
use rts_schemas::system::SystemSpec;

pub use agent::FakeAgent;

/// A clock that follows tokio's, which tests pause.
pub struct TestClock(pub tokio::time::Instant);

impl Clock for TestClock {
    fn now(&self) -> Timestamp {
        let passed = i64::try_from(self.0.elapsed().as_millis()).unwrap();
        Timestamp::from_millisecond(1_800_000_000_000 + passed).unwrap()
    }
}

/// Chance without surprises.
#[derive(Default)]
pub struct TestChance(AtomicU64);

impl Chance for TestChance {
    fn unit(&self) -> f64 {
        0.5
    }

    fn uuid(&self) -> String {
        format!("id-{}", self.0.fetch_add(1, Ordering::Relaxed))
    }
}

/// Agents by endpoint.
#[derive(Clone, Default)]
pub struct FakeFleet(Arc<Mutex<BTreeMap<String, Arc<FakeAgent>>>>);

impl FakeFleet {
    pub fn add(&self, node: &str, types: &[&str]) -> Arc<FakeAgent> {
        let agent = Arc::new(FakeAgent::new(node, types));
        self.0
            .lock()
            .unwrap()
            .insert(node.to_owned(), Arc::clone(&agent));
        agent
    }
}

impl Fleet for FakeFleet {
    fn agent(&self, node: &str, endpoint: &str) -> Result<Arc<dyn Agent>, ClientError> {
        let agents = self.0.lock().unwrap();
        let agent = agents
            .get(endpoint)
            .ok_or_else(|| ClientError::Unreachable {
                socket: endpoint.into(),
                reason: format!("there is no agent of node {node}"),
            })?;
        Ok(Arc::new(agent::Handle(Arc::clone(agent))))
    }
}

impl FakeFleet {
    /// An agent that is reached at an endpoint of another name.
    pub fn also_at(&self, node: &str, endpoint: &str) -> Arc<FakeAgent> {
        let agent = self.agent(node);
        let at = endpoint.to_owned();
        self.0.lock().unwrap().insert(at, Arc::clone(&agent));
        agent
    }

    pub fn agent(&self, node: &str) -> Arc<FakeAgent> {
        Arc::clone(&self.0.lock().unwrap()[node])
    }
}

/// A controller in this process, with its loop and its watch over heartbeats.
pub struct Cluster {
    pub core: Arc<Core>,
    pub fleet: FakeFleet,
    pub store: MemoryStore,
    tasks: tokio::task::JoinSet<()>,
}

impl Cluster {
    pub fn start(fleet: FakeFleet, store: MemoryStore) -> Self {
        Self::simulated_by(fleet, store, Arc::new(NoSimulator))
    }

    /// With a simulator.
    pub fn simulated_by(
        fleet: FakeFleet,
        store: MemoryStore,
        simulator: Arc<dyn Simulator>,
    ) -> Self {
        let core = core_with(&fleet, &store, simulator);
        let mut tasks = tokio::task::JoinSet::new();
        tasks.spawn(Reconciler::new(Arc::clone(&core)).run());
        tasks.spawn(rts_controller::expire_sessions(Arc::clone(&core)));
        Self {
            core,
            fleet,
            store,
            tasks,
        }
    }

    /// One node named local with the hello types, greeted and with heartbeats.
    pub fn hello() -> (Self, Arc<FakeAgent>) {
        let fleet = FakeFleet::default();
        let agent = fleet.add("local", &["SineSource", "LowPassFilter", "Printer"]);
        let mut cluster = Self::start(fleet, MemoryStore::new("cluster"));
        cluster.join("local", "s1");
        (cluster, agent)
    }

    /// A node greets and goes on with heartbeats until it is silenced.
    pub fn join(&mut self, node: &str, session: &str) {
        let agent = Arc::clone(&self.fleet.0.lock().unwrap()[node]);
        let greeting = greeting(&agent, session);
        rts_controller::greet(&self.core, node, greeting).unwrap();
        self.beats(node, session);
    }

    /// A session's heartbeats, until its node is silenced.
    pub fn beats(&mut self, node: &str, session: &str) {
        let agent = self.fleet.agent(node);
        let (core, node, session) = (Arc::clone(&self.core), node.to_owned(), session.to_owned());
        self.tasks.spawn(async move {
            loop {
                tokio::time::sleep(Duration::from_secs(1)).await;
                if agent.is_silent() {
                    continue;
                }
                let beat = Heartbeat {
                    inventory_revision: agent.revision(),
                    delta: None,
                    events: Vec::new(),
                };
                if rts_controller::heartbeat(&core, &node, &session, beat).is_err() {
                    return;
                }
            }
        });
    }

    pub async fn apply(&self, spec: SystemSpec) -> ApplyResult {
        let name = spec.name.clone();
        let request = ApplyRequest::of(spec);
        rts_controller::apply(&self.core, &name, request, None)
            .await
            .unwrap()
    }

    pub fn system(&self, name: &str) -> Option<System> {
        let systems = self.core.view.list::<System>().items;
        systems.into_iter().find(|s| s.metadata.name == name)
    }

    pub fn component(&self, instance: &str) -> Component {
        let components = self.core.view.list::<Component>().items;
        components
            .into_iter()
            .find(|c| c.metadata.name == instance)
            .unwrap()
    }

    /// Objects of the events of one reason.
    pub fn told(&self, reason: &str) -> Vec<String> {
        let events = self.events().into_iter();
        let told = events.filter(|event| event.spec.reason == reason);
        told.map(|event| event.spec.object).collect()
    }

    pub fn events(&self) -> Vec<Event> {
        self.core.view.events().items
    }

    /// Waits, in the test's time, until a system looks like this.
    pub async fn until(
        &self,
        name: &str,
        what: impl Fn(Option<&System>) -> bool,
    ) -> Option<System> {
        let mut changes = self.core.view.subscribe();
        let wait = async {
            loop {
                let system = self.system(name);
                if what(system.as_ref()) {
                    return system;
                }
                changes.changed().await.unwrap();
            }
        };
        match tokio::time::timeout(Duration::from_secs(120), wait).await {
            Ok(system) => system,
            Err(_) => panic!(
                "it never came to that: {:#?}",
                self.system(name).map(|s| s.status)
            ),
        }
    }

    pub async fn until_phase(&self, name: &str, phase: Phase) -> System {
        let found = self
            .until(name, |s| {
                s.is_some_and(|s| {
                    s.status.phase == phase && s.status.observed_generation == s.metadata.generation
                })
            })
            .await;
        found.unwrap()
    }

    /// Ends the controller and starts another one from the same store.
    pub async fn restart(mut self) -> Self {
        self.tasks.shutdown().await;
        Self::start(self.fleet.clone(), self.store.clone())
    }

    pub fn stored(&self) -> rts_controller::store::State {
        self.store.held()
    }
}

/// A controller without its loop.
pub fn core(fleet: &FakeFleet, store: &MemoryStore) -> Arc<Core> {
    core_with(fleet, store, Arc::new(NoSimulator))
}

/// The same with a simulator.
pub fn core_with(
    fleet: &FakeFleet,
    store: &MemoryStore,
    simulator: Arc<dyn Simulator>,
) -> Arc<Core> {
    let loading = Core::load(Inputs {
        local_node: "local".into(),
        clock: Arc::new(TestClock(tokio::time::Instant::now())),
        rng: Arc::new(TestChance::default()),
        fleet: Arc::new(fleet.clone()),
        store: Arc::new(store.clone()),
        simulator,
    });
    let loaded = loading.now_or_never();
    loaded.expect("memory needs no waiting").unwrap()
}

pub fn greeting(agent: &FakeAgent, session: &str) -> SessionGreeting {
    SessionGreeting {
        protocol_version: rts_agent_api::PROTOCOL_VERSION,
        version: "0.1.0".into(),
        session: session.into(),
        endpoint: agent.node.clone(),
        aliases: vec![],
        ledger: agent.ledger(),
        inventory: agent.inventory_now(),
        transport: None,
    }
}
