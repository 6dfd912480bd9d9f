//! What happened since the apply, as it is told to the user.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rts_controller_api::objects::Event;
use rts_controller_api::simulate::SimulatedEvent;
use rts_plan::plan::{Plan, Step, StepId};
use rts_plan::target;
use tokio::sync::watch;

use crate::truth::{Cause, Happened, Subject, Witness};
use crate::words::CONTROLLER;

/// Most events that are kept.
const MOST: usize = 2000;

/// The record. Clones are the same.
#[derive(Clone)]
pub struct Record {
    inner: Arc<Mutex<Inner>>,
    /// Steps that have begun.
    steps: watch::Sender<u64>,
}

#[derive(Default)]
struct Inner {
    /// Time of the run at the apply; none before it.
    begin: Option<Duration>,
    events: Vec<SimulatedEvent>,
    omitted: u64,
    plan: Plan,
    planned: bool,
    /// Instances that lived at the apply and that the plan makes again.
    remade: BTreeSet<String>,
    /// Node, kind and target of steps that have begun.
    begun: BTreeSet<(String, String, String)>,
    /// Faults that have struck.
    came: BTreeSet<String>,
    alive: BTreeSet<String>,
    /// Times that an instance was created again since the apply.
    again: BTreeMap<String, u32>,
    /// Instances that lived at the apply.
    lived: BTreeSet<String>,
    /// The same, and those that were created since.
    known: BTreeSet<String>,
}

impl Record {
    /// Nothing yet.
    pub fn new() -> Self {
        Self {
            inner: Arc::default(),
            steps: watch::Sender::new(0),
        }
    }

    /// The apply comes now.
    pub fn begin(&self, now: Duration) {
        let inner = &mut *self.lock();
        inner.begin = Some(now);
        inner.known = inner.alive.clone();
        inner.lived = inner.alive.clone();
    }

    /// The plan that the apply has led to. Steps that began before it was known get their numbers.
    pub fn plan(&self, plan: Plan) {
        let inner = &mut *self.lock();
        let created = plan
            .steps
            .iter()
            .filter(|step| step.work.kind() == "Create");
        let created = created.filter_map(|step| step.target.strip_prefix("component/"));
        let lived = created.filter(|instance| inner.lived.contains(*instance));
        inner.remade = lived.map(str::to_owned).collect();
        inner.plan = plan;
        inner.planned = true;
        let mut events = std::mem::take(&mut inner.events);
        for event in &mut events {
            event.step = event
                .step
                .or_else(|| inner.step_of(&event.reason, &event.object));
        }
        inner.events = events;
        self.steps.send_modify(|n| *n += 1);
    }

    /// Waits until a step of the plan has begun; when there are none at all, until that is known.
    pub async fn step(&self, step: u32) {
        let mut steps = self.steps.subscribe();
        loop {
            let begun = {
                let inner = self.lock();
                let it = inner.plan.steps.iter().find(|s| s.id == step);
                let none = inner.planned && inner.plan.steps.is_empty();
                none || it.is_some_and(|s| inner.has_begun(s))
            };
            if begun || steps.changed().await.is_err() {
                return;
            }
        }
    }

    /// Something that the simulation itself does.
    pub fn tell(&self, now: Duration, object: &str, reason: &str, message: String) {
        self.lock().tell(now, object, reason, message);
    }

    /// A fault strikes.
    pub fn struck(&self, now: Duration, text: &str) {
        let inner = &mut *self.lock();
        inner.came.insert(text.to_owned());
        inner.tell(now, "fault", "Fault", text.to_owned());
    }

    /// Faults that have struck.
    pub fn came(&self) -> BTreeSet<String> {
        self.lock().came.clone()
    }

    /// What the controller says.
    pub fn event(&self, now: Duration, event: &Event) {
        let spec = &event.spec;
        self.lock()
            .tell(now, &spec.object, &spec.reason, spec.message.clone());
    }

    /// Events and the number of those that were left out.
    pub fn events(&self) -> (Vec<SimulatedEvent>, u64) {
        let inner = self.lock();
        (inner.events.clone(), inner.omitted)
    }

    /// Times that an instance was created again since the apply, beside what the plan itself does.
    pub fn restarts(&self, instance: &str) -> u32 {
        let inner = self.lock();
        let again = inner.again.get(instance).copied().unwrap_or(0);
        again.saturating_sub(u32::from(inner.remade.contains(instance)))
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Inner {
    fn tell(&mut self, now: Duration, object: &str, reason: &str, message: String) {
        let Some(begin) = self.begin else { return };
        // There are few faults, and nobody understands the rest without them.
        if self.events.len() >= MOST && object != "fault" {
            self.omitted += 1;
            return;
        }
        let at = now.saturating_sub(begin).as_millis();
        self.events.push(SimulatedEvent {
            at_ms: u64::try_from(at).unwrap_or(u64::MAX),
            object: object.to_owned(),
            reason: reason.to_owned(),
            message,
            step: self.step_of(reason, object),
        });
    }

    fn has_begun(&self, step: &Step) -> bool {
        let kind = step.work.kind().to_owned();
        self.begun
            .contains(&(step.node.clone(), kind, step.target.clone()))
    }

    /// A step of the plan begins on a node.
    fn begins(&mut self, at: Duration, node: &str, kind: &str, target: &str) {
        let key = (node.to_owned(), kind.to_owned(), target.to_owned());
        let again = self.begin.is_some() && !self.begun.insert(key);
        let again = if again { ", again" } else { "" };
        let told = self.events.len();
        self.tell(at, target, kind, format!("begins on node {node}{again}"));
        let mut steps = self.plan.steps.iter();
        let step = steps.find(|s| s.node == node && s.work.kind() == kind && s.target == target);
        if let (Some(step), Some(event)) = (step, self.events.get_mut(told)) {
            event.step = Some(step.id);
        }
    }

    /// The step of the plan whose begin or end an event tells of.
    fn step_of(&self, reason: &str, object: &str) -> Option<StepId> {
        let kind = kind_of(reason);
        let of = |kind: &str| {
            let mut steps = self.plan.steps.iter();
            let step = steps.find(|s| s.work.kind() == kind && s.target == object);
            step.map(|step| step.id)
        };
        of(kind)
    }

    fn created(&mut self, subject: &Subject) {
        self.alive.insert(subject.instance.clone());
        if self.begin.is_some() && !self.known.insert(subject.instance.clone()) {
            *self.again.entry(subject.instance.clone()).or_default() += 1;
        }
    }
}

/// Kind of the steps of which an event tells.
fn kind_of(reason: &str) -> &str {
    match reason {
        "ModuleLoaded" => "LoadModule",
        "Created" => "Create",
        "Configured" => "Configure",
        "Connected" => "Connect",
        "Activated" => "Activate",
        "Deactivated" => "Deactivate",
        "Disconnected" => "Disconnect",
        "Deleted" => "Delete",
        "ManagerStarted" => "StartManager",
        "ManagerStopped" => "StopManager",
        other => other.strip_suffix("Failed").unwrap_or(other),
    }
}

fn host(host: &str) -> String {
    match host {
        CONTROLLER => CONTROLLER.to_owned(),
        node => target::node(node),
    }
}

/// Why something happened that nobody asked for.
fn why(cause: Cause) -> &'static str {
    match cause {
        Cause::Asked => "as it was asked to",
        Cause::Fault => "by a fault",
        Cause::Died => "its process is gone",
    }
}

impl Witness for Record {
    fn see(&mut self, at: Duration, what: &Happened) {
        let inner = &mut *self.lock();
        match what {
            Happened::StepBegan { node, step, .. } => {
                let (kind, target) = step.split_once(' ').unwrap_or((step, ""));
                inner.begins(at, node, kind, target);
                self.steps.send_modify(|n| *n += 1);
            }
            Happened::ProcessStarted { node, manager, .. } => {
                let object = target::manager(manager);
                inner.tell(at, &object, "ProcessStarted", format!("on node {node}"));
            }
            Happened::ProcessEnded {
                node,
                manager,
                cause,
                ..
            } => {
                let object = target::manager(manager);
                let message = format!("on node {node}, {}", why(*cause));
                inner.tell(at, &object, "ProcessEnded", message);
            }
            Happened::Created(of) => inner.created(of),
            Happened::Deleted(of, cause) => {
                inner.alive.remove(&of.instance);
                if *cause != Cause::Asked {
                    let object = target::component(&of.instance);
                    inner.tell(at, &object, "Gone", why(*cause).to_owned());
                }
            }
            Happened::State {
                of,
                from,
                to,
                cause,
            } if *cause != Cause::Asked => {
                let message = format!("from {from} to {to}, {}", why(*cause));
                inner.tell(at, &target::component(&of.instance), to, message);
            }
            Happened::Blemished {
                instance: Some(instance),
                what,
                ..
            } => {
                inner.tell(at, &target::component(instance), "Fault", what.clone());
            }
            Happened::Disconnected {
                connector, cause, ..
            } if *cause != Cause::Asked => {
                let object = target::connector(connector);
                inner.tell(at, &object, "ConnectionLost", why(*cause).to_owned());
            }
            Happened::Started { host: name, life } if *life > 1 => {
                let message = "its program starts again".to_owned();
                inner.tell(at, &host(name), "ProgramStarted", message);
            }
            Happened::Crashed { host: name, .. } => {
                inner.tell(
                    at,
                    &host(name),
                    "ProgramCrashed",
                    "its program is gone".to_owned(),
                );
            }
            Happened::DidNotStart { host, why } => {
                let message = format!("{host} does not come up: {why}");
                inner.tell(at, "simulation", "Note", message);
            }
            Happened::Note(words) => inner.tell(at, "simulation", "Note", words.clone()),
            _ => {}
        }
    }
}
