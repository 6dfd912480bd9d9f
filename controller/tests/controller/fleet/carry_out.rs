//! Carries steps out on the little world.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use futures_util::stream;
use rts_agent_api::BatchEvents;
use rts_agent_api::messages::{Batch, BatchEvent, StepOutcome};
use rts_plan::desired::ManagerKey;
use rts_plan::mark::Mark;
use rts_plan::observed::{
    ComponentObserved, ConnectorObserved, ConnectorState, LifeCycleState, ManagerObserved,
    RealtimeObserved,
};
use rts_plan::plan::{Step, Work};
use tokio::sync::watch;

use super::agent::{FakeAgent, News, State};

/// What a batch has told so far.
pub type Told = watch::Sender<Vec<BatchEvent>>;

/// Runs a batch, or tells again what the very same one has told; the stream may be dropped without ending it.
pub fn batch(agent: Arc<FakeAgent>, batch: Batch) -> BatchEvents {
    let mut state = agent.state.lock().unwrap();
    let told = state
        .batches
        .entry(batch.plan_id.clone())
        .or_insert_with(|| {
            let told = Arc::new(Told::default());
            tokio::spawn(run(Arc::clone(&agent), batch, Arc::clone(&told)));
            told
        });
    let events = (told.subscribe(), 0);
    if state.lost_results > 0 {
        state.lost_results -= 1;
        return Box::pin(stream::pending());
    }
    Box::pin(stream::unfold(events, |(mut told, next)| async move {
        let seen = told.wait_for(|told| told.len() > next).await.ok()?;
        let event = seen[next].clone();
        drop(seen);
        Some((Ok(event), (told, next + 1)))
    }))
}

async fn run(agent: Arc<FakeAgent>, batch: Batch, told: Arc<Told>) {
    let tell = |event| told.send_modify(|told| told.push(event));
    tell(BatchEvent::Accepted {
        api_version: "rtsctl.dev/v1".into(),
        plan_id: batch.plan_id.clone(),
    });
    let mut outcomes: BTreeMap<u32, bool> = BTreeMap::new();
    let own: BTreeSet<u32> = batch.steps.iter().map(|s| s.id).collect();
    for step in &batch.steps {
        let outcome = match ready(&agent, &batch, step, &own, &outcomes).await {
            Ok(()) => {
                tell(BatchEvent::Started { step: step.id });
                let time = time_of(&agent, step);
                tokio::time::sleep(time).await;
                perform(&agent, step)
            }
            Err(outcome) => outcome,
        };
        outcomes.insert(step.id, outcome == StepOutcome::Succeeded);
        tell(BatchEvent::Finished {
            step: step.id,
            outcome,
            micros: 1,
        });
    }
    tell(BatchEvent::End);
}

fn time_of(agent: &FakeAgent, step: &Step) -> std::time::Duration {
    let state = agent.state.lock().unwrap();
    let name = format!("{} {}", step.work.kind(), step.target);
    state.slow_steps.get(&name).map_or(state.step_time, |t| *t)
}

async fn ready(
    agent: &FakeAgent,
    batch: &Batch,
    step: &Step,
    own: &BTreeSet<u32>,
    outcomes: &BTreeMap<u32, bool>,
) -> Result<(), StepOutcome> {
    let skipped = |because_of, reason: &str| StepOutcome::Skipped {
        because_of,
        reason: reason.into(),
    };
    let mut news = agent.news.subscribe();
    for need in &step.needs {
        if own.contains(need) {
            if !outcomes.get(need).copied().unwrap_or(false) {
                return Err(skipped(Some(*need), "a need failed"));
            }
            continue;
        }
        let need_of_plan = (batch.plan_id.clone(), *need);
        let over = |news: &News| {
            news.succeeded.contains(&need_of_plan) || news.failed.contains(&need_of_plan)
        };
        let gate = news.wait_for(over);
        let failed = gate.await.unwrap().failed.contains(&need_of_plan);
        if failed {
            return Err(skipped(Some(*need), "a gate failed"));
        }
    }
    for before in step.after_end_of.iter().filter(|id| !own.contains(id)) {
        let of_plan = (batch.plan_id.clone(), *before);
        let over =
            |news: &News| news.succeeded.contains(&of_plan) || news.failed.contains(&of_plan);
        let _ = news.wait_for(over).await.unwrap();
    }
    let newer = |news: &News| news.generation > batch.generation;
    let wait = std::time::Duration::from_millis(step.wait_ms.into());
    let cancelled = tokio::time::timeout(wait, news.wait_for(newer))
        .await
        .is_ok();
    if cancelled || newer(&agent.news.borrow()) {
        if agent.state.lock().unwrap().hears_late {
            let reason = "the node spec was replaced meanwhile; the next plan is for the new one";
            return Err(skipped(None, reason));
        }
        return Err(skipped(None, "cancelled by a newer spec"));
    }
    Ok(())
}

fn perform(agent: &FakeAgent, step: &Step) -> StepOutcome {
    let mut state = agent.state.lock().unwrap();
    let name = format!("{} {}", step.work.kind(), step.target);
    if let Some(left) = state.failing.get_mut(&name).filter(|left| **left > 0) {
        *left -= 1;
        let reason = format!("{name} was told to fail");
        let instance = step.target.split_once('/').map_or("", |(_, name)| name);
        if state.in_error.contains(instance) {
            state.revision += 1;
            let components = state.managers.iter_mut().flat_map(|m| &mut m.components);
            for component in components.filter(|c| c.instance == instance) {
                component.state = LifeCycleState::Error;
            }
        }
        return StepOutcome::Failed { reason };
    }
    state.done.push(name);
    state.revision += 1;
    change(&mut state, step);
    StepOutcome::Succeeded
}

fn change(state: &mut State, step: &Step) {
    state.incarnations += 1;
    let incarnation = format!("inc-{}", state.incarnations);
    match step.work.clone() {
        Work::Install { .. } => {}
        Work::StartManager { manager } => state.managers.push(ManagerObserved {
            key: manager,
            pid: 100 + u32::try_from(state.incarnations).unwrap(),
            incarnation,
            started: "2027-01-15T08:00:00Z".into(),
            responsive: true,
            unseen: false,
            expired: None,
            modules: BTreeSet::new(),
            opened: Default::default(),
            components: Vec::new(),
            activity: Default::default(),
        }),
        Work::LoadModule {
            manager, type_name, ..
        } => {
            at(state, &manager).modules.insert(type_name);
        }
        Work::UnloadModule { manager, type_name } => {
            at(state, &manager).modules.remove(&type_name);
        }
        Work::Create {
            manager,
            instance,
            type_name,
            recreate_hash,
            configuration,
            execution_kind,
            rate,
            execution_context,
            on_disconnect,
            stand_in,
            realtime,
        } => at(state, &manager).components.push(ComponentObserved {
            instance,
            type_name,
            system: step.system.clone(),
            incarnation,
            recreate_hash,
            stand_in: stand_in.is_some(),
            state: LifeCycleState::Inactive,
            message: None,
            restarts: 0,
            created: "2027-01-15T08:00:00Z".into(),
            configuration,
            defaults: Default::default(),
            hangs: None,
            on_disconnect,
            execution_kind,
            execution_context,
            runs_with: Vec::new(),
            rate: rate.unwrap_or(1000.0),
            executions: 0,
            timing: None,
            realtime: realtime.map(|asked| RealtimeObserved {
                asked,
                ..RealtimeObserved::default()
            }),
            ports: Vec::new(),
            connectors: Vec::new(),
            bindings: Vec::new(),
            by_hand: rts_plan::observed::ByHand::default(),
        }),
        Work::Configure {
            manager,
            instance,
            configuration,
            rate,
            on_disconnect,
            order,
        } => {
            let component = component(state, &manager, &instance);
            let mut mark = Mark::of(component);
            mark.set(&configuration);
            component.by_hand.configured = (!mark.is_empty()).then(|| mark.encode());
            if let Some(on_disconnect) = on_disconnect {
                component.on_disconnect = on_disconnect;
            }
            if let Some(rate) = rate {
                component.rate = rate;
            }
            if let (Some(order), Some(shared)) = (order, &mut component.execution_context) {
                shared.order = order;
            }
            if configuration.active.is_some() {
                component.configuration.active = configuration.active;
            }
            for (set, values) in configuration.sets {
                component
                    .configuration
                    .sets
                    .entry(set)
                    .or_default()
                    .extend(values);
            }
        }
        Work::Connect { connector } => {
            let target_incarnation = incarnation_of(state, &connector.spec.target.instance);
            let connection = ConnectorObserved {
                name: connector.spec.name.clone(),
                source: connector.spec.source.clone(),
                target: connector.spec.target.clone(),
                target_incarnation,
                properties: connector.spec.properties.clone(),
                by_hand: None,
                state: ConnectorState::Connected,
                transport: "direct".into(),
                samples_sent: 0,
                samples_received: 0,
                bytes: 0,
                drops: 0,
                gaps: 0,
                rate: 0,
                latency: None,
            };
            let source = &connector.spec.source.instance;
            let mut components = state.managers.iter_mut().flat_map(|m| &mut m.components);
            let owner = components.find(|c| c.instance == *source).unwrap();
            owner.connectors.retain(|c| c.name != connection.name);
            owner.by_hand.disconnected.remove(&connection.name);
            owner.connectors.push(connection);
        }
        Work::Activate { manager, instance } => {
            let component = component(state, &manager, &instance);
            component.state = LifeCycleState::Active;
            component.by_hand.deactivated = None;
        }
        Work::Deactivate { manager, instance } | Work::Reset { manager, instance } => {
            component(state, &manager, &instance).state = LifeCycleState::Inactive;
        }
        Work::Disconnect {
            manager,
            instance,
            connector,
        } => {
            let component = component(state, &manager, &instance);
            component.connectors.retain(|c| c.name != connector);
        }
        Work::Unbind {
            manager,
            instance,
            connector,
        } => {
            let component = component(state, &manager, &instance);
            component.bindings.retain(|b| b.connector != connector);
        }
        Work::Delete { manager, instance } => {
            at(state, &manager)
                .components
                .retain(|c| c.instance != instance);
        }
        Work::StopManager { manager, .. } => state.managers.retain(|m| m.key != manager),
    }
}

fn at<'a>(state: &'a mut State, key: &ManagerKey) -> &'a mut ManagerObserved {
    state.managers.iter_mut().find(|m| m.key == *key).unwrap()
}

fn component<'a>(
    state: &'a mut State,
    key: &ManagerKey,
    instance: &str,
) -> &'a mut ComponentObserved {
    let components = &mut at(state, key).components;
    components
        .iter_mut()
        .find(|c| c.instance == instance)
        .unwrap()
}

/// Of a component on this node; other nodes' have one that the planner takes for granted.
pub fn incarnation_of(state: &State, instance: &str) -> String {
    let mut components = state.managers.iter().flat_map(|m| &m.components);
    components
        .find(|c| c.instance == instance)
        .map_or_else(|| "inc-elsewhere".into(), |c| c.incarnation.clone())
}
