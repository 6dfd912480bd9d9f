//! One agent.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rts_agent_api::messages::{
    Batch, GateReport, LedgerFence, ModuleDescription, ModuleFile, ModuleResolution,
    NodeSpecEnvelope, NodeSpecReceipt, ParameterLimits,
};
use rts_agent_api::{AgentApi, BatchEvents, ClientError};
use rts_http::problem::Problem;
use rts_plan::observed::{ComponentObserved, Held, Inventory, ManagerObserved, PortObserved};
use rts_schemas::system::{Direction, PortKind};
use tokio::sync::watch;

use super::carry_out::{self, Told};

/// An agent and its node.
pub struct FakeAgent {
    pub node: String,
    pub state: Mutex<State>,
    /// Gates and the newest generation, for batches that run.
    pub news: watch::Sender<News>,
}

#[derive(Default)]
pub struct State {
    pub revision: u64,
    pub managers: Vec<ManagerObserved>,
    pub held: Vec<Held>,
    pub spec: Option<NodeSpecEnvelope>,
    pub types: BTreeSet<String>,
    /// Type → what its module says of itself.
    pub described: BTreeMap<String, ModuleDescription>,
    /// Types whose module file is another by now.
    pub rebuilt: BTreeSet<String>,
    /// Times that modules were asked for.
    pub resolved: u32,
    /// `KIND target` → times it fails yet.
    pub failing: BTreeMap<String, u32>,
    /// Components that a step which is told to fail leaves in Error.
    pub in_error: BTreeSet<String>,
    pub silent: bool,
    /// Questions that it never answers, though its heartbeats come.
    pub deaf: BTreeSet<&'static str>,
    /// A new spec ends what is held.
    pub lets_go: bool,
    /// The word that a spec was replaced comes late: a step that starts finds it out.
    pub hears_late: bool,
    /// Time until a batch is looked at.
    pub accept_time: Duration,
    pub step_time: Duration,
    /// `KIND target` → how long that takes.
    pub slow_steps: BTreeMap<String, Duration>,
    /// Results of so many batches are lost on the way, without an end.
    pub lost_results: u32,
    /// Plan id → what its batch has told.
    pub batches: BTreeMap<String, Arc<Told>>,
    /// Steps that were carried out, as `KIND target`.
    pub done: Vec<String>,
    pub incarnations: u64,
    /// Times that all of the inventory was asked for.
    pub asked: u32,
}

#[derive(Default, Clone)]
pub struct News {
    pub generation: u64,
    /// Plan id and step.
    pub succeeded: BTreeSet<(String, u32)>,
    pub failed: BTreeSet<(String, u32)>,
}

pub struct Handle(pub Arc<FakeAgent>);

impl FakeAgent {
    pub fn new(node: &str, types: &[&str]) -> Self {
        let state = State {
            revision: 1,
            types: types.iter().map(|t| (*t).to_owned()).collect(),
            ..State::default()
        };
        Self {
            node: node.into(),
            state: Mutex::new(state),
            news: watch::Sender::default(),
        }
    }

    pub fn fail(&self, step: &str, times: u32) {
        self.state
            .lock()
            .unwrap()
            .failing
            .insert(step.into(), times);
    }

    /// Its module of this type says this of itself from now on; ports are `name:in|out:TYPE`, parameters `name` or
    /// `name:type:constraint`.
    pub fn describe(&self, type_name: &str, ports: &[&str], parameters: &[&str]) {
        let port = |text: &&str| {
            let (name, rest) = text.split_once(':').unwrap();
            let (direction, data_type) = rest.split_once(':').unwrap();
            PortObserved {
                name: name.into(),
                kind: PortKind::Data,
                direction: Some(if direction == "in" {
                    Direction::In
                } else {
                    Direction::Out
                }),
                data_type: format!("IDL:RTC/{data_type}:1.0"),
            }
        };
        let description = ModuleDescription {
            ports: ports.iter().map(port).collect(),
            parameters: parameters
                .iter()
                .map(|p| (p.split(':').next().unwrap().into(), "1".into()))
                .collect(),
            limits: parameters.iter().filter_map(|p| limits(p)).collect(),
        };
        let mut state = self.state.lock().unwrap();
        state.described.insert(type_name.into(), description);
    }

    /// The module file of a type is replaced by another.
    pub fn rebuild(&self, type_name: &str) {
        let mut state = self.state.lock().unwrap();
        state.rebuilt.insert(type_name.into());
    }

    pub fn ends_in_error(&self, instance: &str) {
        self.state.lock().unwrap().in_error.insert(instance.into());
    }

    pub fn silence(&self, silent: bool) {
        self.state.lock().unwrap().silent = silent;
    }

    /// It does not answer this question any more, or does again.
    pub fn deafen(&self, question: &'static str, deaf: bool) {
        let all = &mut self.state.lock().unwrap().deaf;
        match deaf {
            true => all.insert(question),
            false => all.remove(question),
        };
    }

    pub fn is_silent(&self) -> bool {
        self.state.lock().unwrap().silent
    }

    pub fn revision(&self) -> u64 {
        self.state.lock().unwrap().revision
    }

    pub fn slow(&self, time: Duration) {
        self.state.lock().unwrap().step_time = time;
    }

    pub fn slow_step(&self, step: &str, time: Duration) {
        let mut state = self.state.lock().unwrap();
        state.slow_steps.insert(step.into(), time);
    }

    pub fn take_done(&self) -> Vec<String> {
        std::mem::take(&mut self.state.lock().unwrap().done)
    }

    /// A process dies.
    pub fn kill(&self, manager: &str) {
        let mut state = self.state.lock().unwrap();
        state.revision += 1;
        state.managers.retain(|m| m.key.display_name() != manager);
    }

    /// A process is stopped: it lives and does not answer.
    pub fn hang(&self, manager: &str) {
        let mut state = self.state.lock().unwrap();
        state.revision += 1;
        let mut managers = state.managers.iter_mut();
        let found = managers.find(|m| m.key.display_name() == manager);
        found.unwrap().responsive = false;
    }

    /// Something in a process hangs for too long, as its agent judges.
    pub fn expire(&self, manager: &str, why: &str) {
        let mut state = self.state.lock().unwrap();
        state.revision += 1;
        let mut managers = state.managers.iter_mut();
        let found = managers.find(|m| m.key.display_name() == manager);
        found.unwrap().expired = Some(why.into());
    }

    /// Something of a component changes by itself.
    pub fn change(&self, instance: &str, what: impl FnOnce(&mut ComponentObserved)) {
        let mut state = self.state.lock().unwrap();
        state.revision += 1;
        let mut all = state.managers.iter_mut().flat_map(|m| &mut m.components);
        what(all.find(|c| c.instance == instance).unwrap());
    }

    /// A counter goes up, and nothing else.
    pub fn count(&self) {
        let mut state = self.state.lock().unwrap();
        for manager in &mut state.managers {
            for component in &mut manager.components {
                component.executions += 1;
            }
        }
    }

    /// The component's process ended and its policy is never.
    pub fn hold(&self, instance: &str, reason: &str) {
        let mut state = self.state.lock().unwrap();
        let all = state.managers.iter().flat_map(|m| &m.components);
        let component = all.into_iter().find(|c| c.instance == instance).unwrap();
        let held = Held {
            part: None,
            system: component.system.clone().unwrap(),
            instance: instance.into(),
            reason: reason.into(),
        };
        state.held.push(held);
        state.revision += 1;
    }

    /// What its ledger holds.
    pub fn ledger(&self) -> Option<LedgerFence> {
        let state = self.state.lock().unwrap();
        state.spec.as_ref().and_then(|spec| self.ledger_of(spec))
    }

    fn ledger_of(&self, spec: &NodeSpecEnvelope) -> Option<LedgerFence> {
        Some(LedgerFence {
            cluster_uid: spec.cluster_uid.clone(),
            epoch: spec.epoch,
            generation: spec.generation,
            digest: spec.digest.clone(),
        })
    }

    /// Incarnation of each component.
    pub fn incarnations(&self) -> BTreeMap<String, String> {
        let state = self.state.lock().unwrap();
        let all = state.managers.iter().flat_map(|m| &m.components);
        all.map(|c| (c.instance.clone(), c.incarnation.clone()))
            .collect()
    }

    pub fn inventory_now(&self) -> Inventory {
        let state = self.state.lock().unwrap();
        Inventory {
            node: self.node.clone(),
            revision: state.revision,
            managers: state.managers.clone(),
            held: state.held.clone(),
        }
    }

    async fn hears(&self, question: &str) {
        let deaf = self.state.lock().unwrap().deaf.contains(question);
        if deaf {
            std::future::pending::<()>().await;
        }
    }

    async fn answer(&self) {
        if self.is_silent() {
            std::future::pending::<()>().await;
        }
        tokio::task::yield_now().await;
    }
}

impl AgentApi for Handle {
    async fn inventory(&self) -> Result<Inventory, ClientError> {
        self.0.answer().await;
        self.0.state.lock().unwrap().asked += 1;
        Ok(self.0.inventory_now())
    }

    async fn node_spec(&self) -> Result<NodeSpecEnvelope, ClientError> {
        self.0.answer().await;
        self.0.hears("ledger").await;
        let spec = self.0.state.lock().unwrap().spec.clone();
        spec.ok_or_else(|| Problem::not_found("it was told nothing yet").into())
    }

    async fn put_node_spec(&self, spec: &NodeSpecEnvelope) -> Result<NodeSpecReceipt, ClientError> {
        self.0.answer().await;
        let mut state = self.0.state.lock().unwrap();
        assert_eq!(spec.digest, rts_plan::digest(&spec.spec));
        if let Some(old) = &state.spec {
            let (told, told_now) = ((old.epoch, old.generation), (spec.epoch, spec.generation));
            let same = told == told_now && old.digest != spec.digest;
            let foreign = old.cluster_uid != spec.cluster_uid;
            let allowed = spec.take_over == self.0.ledger_of(old);
            if (foreign && !allowed) || (!foreign && (told > told_now || same)) {
                return Err(Problem::conflict("stale", "the ledger knows a newer spec").into());
            }
        }
        let changed = state.spec.as_ref() != Some(spec);
        if changed && state.lets_go {
            state.held.clear();
            state.revision += 1;
        }
        state.spec = Some(spec.clone());
        self.0
            .news
            .send_modify(|news| news.generation = spec.generation);
        Ok(NodeSpecReceipt {
            generation: spec.generation,
            changed,
        })
    }

    async fn run_batch(&self, batch: &Batch) -> Result<BatchEvents, ClientError> {
        self.0.answer().await;
        let accept_time = self.0.state.lock().unwrap().accept_time;
        if !accept_time.is_zero() {
            tokio::time::sleep(accept_time).await;
        }
        let held = self
            .0
            .state
            .lock()
            .unwrap()
            .spec
            .as_ref()
            .map(|s| s.generation);
        if held != Some(batch.generation) {
            return Err(Problem::conflict("stale", "the batch is of another generation").into());
        }
        Ok(carry_out::batch(Arc::clone(&self.0), batch.clone()))
    }

    async fn release(&self, plan: &str, gates: &GateReport) -> Result<(), ClientError> {
        self.0.answer().await;
        self.0.news.send_modify(|news| {
            let of_plan = |id: &u32| (plan.to_owned(), *id);
            news.succeeded.extend(gates.succeeded.iter().map(of_plan));
            news.failed.extend(gates.failed.iter().map(of_plan));
        });
        Ok(())
    }

    async fn resolve_modules(
        &self,
        types: &[String],
    ) -> Result<Vec<ModuleResolution>, ClientError> {
        self.0.answer().await;
        self.0.hears("modules").await;
        let mut state = self.0.state.lock().unwrap();
        state.resolved += 1;
        let digest = |name: &String| match state.rebuilt.contains(name) {
            true => format!("new-digest-of-{name}"),
            false => format!("digest-of-{name}"),
        };
        let resolve = |name: &String| ModuleResolution {
            type_name: name.clone(),
            module: state.types.contains(name).then(|| ModuleFile {
                path: format!("/modules/{name}.so"),
                digest: digest(name),
                description: state.described.get(name).cloned(),
            }),
            searched: vec![
                format!("/modules/lib{name}.so"),
                format!("/modules/{name}.so"),
            ],
        };
        Ok(types.iter().map(resolve).collect())
    }
}

/// Reads `name:type:constraint`.
fn limits(parameter: &str) -> Option<(String, ParameterLimits)> {
    let (name, rest) = parameter.split_once(':')?;
    let (value_type, constraint) = rest.split_once(':')?;
    let limits = ParameterLimits {
        value_type: value_type.into(),
        constraint: constraint.into(),
    };
    Some((name.into(), limits))
}
