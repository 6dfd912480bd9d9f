//! A change is carried out while it is being made durable: nobody is told of it before, and it is taken back when it
//! cannot be stored.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use futures_util::FutureExt;
use futures_util::future::BoxFuture;
use rts_controller::simulator::NoSimulator;
use rts_controller::store::{MemoryStore, State, Store, StoreError, Write};
use rts_controller::{Core, Inputs, Reconciler};
use rts_controller_api::Problem;
use rts_controller_api::objects::{Component, Phase, System};
use rts_controller_api::requests::{ApplyRequest, ApplyResult};
use rts_schemas::system::SystemSpec;
use tokio::sync::{Mutex, mpsc};
use tokio::task::JoinHandle;

use crate::fleet::stores::until;
use crate::fleet::{FakeAgent, FakeFleet, TestChance, TestClock, greeting, systems};

/// A store whose changes of systems wait for a word: whether they are stored.
#[derive(Clone)]
struct Gate {
    inner: MemoryStore,
    words: Arc<Mutex<mpsc::UnboundedReceiver<bool>>>,
    /// Nothing at all can be stored.
    full: Arc<AtomicBool>,
}

impl Store for Gate {
    fn load(&self) -> BoxFuture<'_, Result<State, StoreError>> {
        self.inner.load()
    }

    fn write(&self, writes: Vec<Write>) -> BoxFuture<'_, Result<(), StoreError>> {
        Box::pin(async move {
            let system = writes.iter().any(|w| matches!(w, Write::PutSystem(_)));
            let stored = !system || self.words.lock().await.recv().await.unwrap();
            if !stored || self.full.load(Ordering::Relaxed) {
                let path = "controller.redb".into();
                return Err(StoreError::Full { path });
            }
            self.inner.write(writes).await
        })
    }
}

/// A controller that runs hello on one node.
struct Stage {
    core: Arc<Core>,
    agent: Arc<FakeAgent>,
    gate: Gate,
    word: mpsc::UnboundedSender<bool>,
}

impl Stage {
    /// A node that was told nothing yet.
    async fn empty() -> Self {
        let fleet = FakeFleet::default();
        let agent = fleet.add("local", &["SineSource", "LowPassFilter", "Printer"]);
        let (word, words) = mpsc::unbounded_channel();
        let gate = Gate {
            inner: MemoryStore::new("cluster"),
            words: Arc::new(Mutex::new(words)),
            full: Arc::default(),
        };
        let inputs = Inputs {
            local_node: "local".into(),
            clock: Arc::new(TestClock(tokio::time::Instant::now())),
            rng: Arc::new(TestChance::default()),
            fleet: Arc::new(fleet),
            store: Arc::new(gate.clone()),
            simulator: Arc::new(NoSimulator),
        };
        let core = Core::load(inputs).await.unwrap();
        tokio::spawn(Reconciler::new(Arc::clone(&core)).run());
        rts_controller::greet(&core, "local", greeting(&agent, "s1")).unwrap();
        Self {
            core,
            agent,
            gate,
            word,
        }
    }

    async fn set() -> Self {
        let stage = Self::empty().await;
        stage.word.send(true).unwrap();
        stage.apply(systems::hello()).await.unwrap().unwrap();
        until(|| stage.phase("hello") == Some(Phase::Converged)).await;
        stage
    }

    fn apply(&self, spec: SystemSpec) -> JoinHandle<Result<ApplyResult, Problem>> {
        let (core, name) = (Arc::clone(&self.core), spec.name.clone());
        let request = ApplyRequest::of(spec);
        tokio::spawn(async move { rts_controller::apply(&core, &name, request, None).await })
    }

    fn phase(&self, name: &str) -> Option<Phase> {
        let system = self.core.view.get::<System>(name)?;
        let status = system.status;
        (status.observed_generation == system.metadata.generation).then_some(status.phase)
    }

    fn did(&self, step: &str) -> bool {
        let state = self.agent.state.lock().unwrap();
        state.done.iter().any(|done| done == step)
    }

    fn runs(&self, instance: &str) -> bool {
        let state = self.agent.state.lock().unwrap();
        let mut components = state.managers.iter().flat_map(|m| &m.components);
        components.any(|component| component.instance == instance)
    }

    fn told(&self, reason: &str, object: &str) -> bool {
        let events = self.core.view.events().items;
        let told = |e: &rts_controller_api::objects::Event| {
            e.spec.reason == reason && e.spec.object == object
        };
        events.iter().any(told)
    }
}

fn more() -> SystemSpec {
    SystemSpec {
        connectors: Vec::new(),
        orders: Default::default(),
        name: "more".into(),
        full_id: "RTSystem:rtsctl:more:1.0".into(),
        components: vec![systems::component("Sine1", "SineSource")],
        ..systems::hello()
    }
}

#[tokio::test(start_paused = true)]
async fn nobody_is_told_of_a_change_before_it_is_durable_though_it_is_carried_out() {
    let stage = Stage::set().await;
    let mut apply = stage.apply(more());
    until(|| stage.did("Activate component/Sine1")).await;
    // The loop has seen it, and everything has been published since.
    for _ in 0..3 {
        stage.core.observe().await;
        tokio::time::sleep(Duration::from_secs(6)).await;
    }
    assert!((&mut apply).now_or_never().is_none(), "it is not durable");
    assert!(!stage.gate.inner.held().systems.contains_key("more"));
    assert!(stage.core.view.get::<System>("more").is_none());
    let shown = stage.core.view.list::<Component>().items;
    assert!(shown.iter().all(|c| c.metadata.name != "Sine1"));
    assert!(!stage.told("Applied", "system/more"));
    // What has nothing to do with it is shown as ever.
    assert_eq!(stage.phase("hello"), Some(Phase::Converged));

    stage.word.send(true).unwrap();
    let applied = apply.await.unwrap().unwrap();
    assert_eq!(applied.system.metadata.generation, 1);
    let held = stage.gate.inner.held();
    let given = stage.core.registry().nodes["local"].clone();
    assert_eq!(
        held.nodes["local"], given,
        "stored with the system, at once"
    );
    until(|| stage.phase("more") == Some(Phase::Converged)).await;
    assert!(stage.told("Applied", "system/more"));
}

#[tokio::test(start_paused = true)]
async fn a_change_that_cannot_be_stored_is_taken_back_though_nothing_can_be_stored() {
    let stage = Stage::set().await;
    let apply = stage.apply(more());
    until(|| stage.did("Activate component/Sine1")).await;
    stage.gate.full.store(true, Ordering::Relaxed);
    stage.word.send(false).unwrap();
    let refused = apply.await.unwrap().unwrap_err();
    assert_eq!((refused.status, refused.code.as_str()), (507, "store-full"));
    until(|| !stage.runs("Sine1")).await;
    assert!(stage.told("TakenBack", "system/more"));
    assert!(stage.core.view.get::<System>("more").is_none());
    let touched = |step: &String| step.starts_with("Delete") && !step.ends_with("/Sine1");
    assert!(!stage.agent.state.lock().unwrap().done.iter().any(touched));

    // As long as the last change could not be stored, the next one is begun only once it is.
    let apply = stage.apply(more());
    tokio::time::sleep(Duration::from_secs(6)).await;
    assert!(!stage.runs("Sine1"));
    stage.gate.full.store(false, Ordering::Relaxed);
    stage.word.send(true).unwrap();
    apply.await.unwrap().unwrap();
    until(|| stage.phase("more") == Some(Phase::Converged)).await;
    assert_eq!(stage.phase("hello"), Some(Phase::Converged));
}

#[tokio::test(start_paused = true)]
async fn a_deletion_that_cannot_be_stored_is_taken_back() {
    let stage = Stage::set().await;
    let core = Arc::clone(&stage.core);
    let delete = tokio::spawn(async move { rts_controller::delete(&core, "hello", None).await });
    until(|| !stage.runs("Sine0")).await;
    // Nothing is left of it, and it is not forgotten before its end is durable.
    tokio::time::sleep(Duration::from_secs(6)).await;
    assert!(stage.core.registry().systems.contains_key("hello"));
    let shown = stage.core.view.get::<System>("hello").unwrap();
    assert_eq!(shown.metadata.deletion_timestamp, None);
    stage.word.send(false).unwrap();
    assert_eq!(delete.await.unwrap().unwrap_err().status, 507);
    until(|| stage.runs("Sine0")).await;
    until(|| stage.phase("hello") == Some(Phase::Converged)).await;
    assert!(stage.told("TakenBack", "system/hello"));
}

#[tokio::test(start_paused = true)]
async fn what_a_node_is_told_first_is_carried_out_at_once_when_it_is_durable_however_often_the_loop_looked_before()
 {
    let stage = Stage::empty().await;
    let applying = stage.apply(systems::hello());
    for _ in 0..10 {
        tokio::time::sleep(Duration::from_millis(1)).await;
        stage.core.wake.notify_one();
    }
    assert!(!applying.is_finished());
    let begin = tokio::time::Instant::now();
    stage.word.send(true).unwrap();
    applying.await.unwrap().unwrap();
    until(|| stage.phase("hello") == Some(Phase::Converged)).await;
    let took = begin.elapsed();
    assert!(took < Duration::from_secs(1), "{took:?}");
}
