//! What the orders of a profile ask for, straight from its conditions: whoever carries out a step is told what it broke.

use std::collections::BTreeSet;

use rts_plan::observed::LifeCycleState;
use rts_plan::plan::{OnTimeout, Step, StepId, Work};
use rts_schemas::system::{Condition, Orders, SendingTiming, SystemSpec, WaitFor};

use super::World;

/// What a component waits for.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Before {
    instance: String,
    timing: SendingTiming,
    /// Named by a `Preceding` with a time-out.
    limited: bool,
}

/// The plan that is being carried out.
#[derive(Debug, Clone, Default)]
pub struct Running {
    pub steps: Vec<Step>,
    /// Steps that have not ended, nor were given up.
    pub open: BTreeSet<StepId>,
    /// Steps that have been carried out.
    pub done: BTreeSet<StepId>,
    /// Steps that were waited for in vain: they are gone on without.
    pub forgotten: BTreeSet<(StepId, StepId)>,
}

impl Running {
    pub fn of(steps: &[Step]) -> Self {
        Self {
            steps: steps.to_vec(),
            open: steps.iter().map(|step| step.id).collect(),
            ..Self::default()
        }
    }

    /// True when a step must not wait for another any longer.
    pub fn forgets(&self, step: &Step, other: StepId) -> bool {
        self.forgotten.contains(&(step.id, other))
    }

    /// True when a limit lets a step go on without another.
    pub fn may_forget(step: &Step, other: StepId) -> bool {
        let mut limits = step.limits.iter();
        limits.any(|limit| limit.then == OnTimeout::GoOn && limit.steps.contains(&other))
    }

    /// Steps that still stand before a step.
    pub fn before(&self, step: &Step) -> BTreeSet<StepId> {
        let open = |id: &StepId| self.open.contains(id) && !self.forgets(step, *id);
        step.before().filter(open).collect()
    }

    /// The step's limits run: everything else is met.
    pub fn is_armed(&self, step: &Step) -> bool {
        let limited = |id: &StepId| step.limits.iter().any(|l| l.steps.contains(id));
        let before = self.before(step);
        !before.is_empty() && before.iter().all(limited)
    }
}

impl World {
    /// Instances that a step should have waited for, and has not.
    pub fn too_early(&self, step: &Step) -> Vec<String> {
        let Some((instance, _)) = ordered(&step.work) else {
            return Vec::new();
        };
        let stored = self
            .systems
            .iter()
            .find(|s| Some(&s.reference) == step.system.as_ref());
        let Some(spec) = stored.map(|stored| &stored.spec) else {
            return Vec::new();
        };
        let before = predecessors(&lists(&spec.orders, &step.work), instance);
        let early = before.into_iter().filter(|b| !self.is_met(step, spec, b));
        early.map(|before| before.instance).collect()
    }

    fn is_met(&self, step: &Step, spec: &SystemSpec, before: &Before) -> bool {
        let (_, kind) = ordered(&step.work).unwrap();
        let same = |other: &&Step| {
            let own = ordered(&other.work).is_some_and(|(i, k)| i == before.instance && k == kind);
            own && other.system == step.system
        };
        let is_open = |s: &&Step| self.running.open.contains(&s.id);
        let lost = |s: &&Step| !is_open(s) && !self.running.done.contains(&s.id);
        let given_up = |s: &&Step| {
            let lost = lost(s) && Running::may_forget(step, s.id);
            before.limited && (lost || self.running.forgets(step, s.id))
        };
        let all: Vec<&Step> = self.running.steps.iter().filter(same).collect();
        let steps: Vec<&Step> = all.iter().copied().filter(|s| !given_up(s)).collect();
        if steps.len() < all.len() && steps.is_empty() {
            return true;
        }
        let required = spec.components.iter().any(|c| {
            let late = c.instance == before.instance;
            late && c.required
        });
        if !required || before.timing == SendingTiming::Async {
            let waits = required && steps.is_empty() && !self.is_there(step, &before.instance);
            return !waits && !steps.iter().any(is_open);
        }
        if matches!(step.work, Work::Deactivate { .. } | Work::Delete { .. }) {
            // Nothing is kept alive by what fails.
            return !steps.iter().any(is_open);
        }
        if steps.is_empty() {
            return self.is_there(step, &before.instance);
        }
        steps.iter().all(|s| self.running.done.contains(&s.id))
    }

    /// The state that a step's order waits for. There may be a second instance for a while, after a silent node has come
    /// back.
    fn is_there(&self, step: &Step, instance: &str) -> bool {
        let mut own = self
            .components()
            .filter(|(_, _, c)| c.instance == instance && c.system == step.system);
        match &step.work {
            Work::Create { .. } => own.next().is_some(),
            Work::Activate { .. } => own.any(|(_, _, c)| c.state == LifeCycleState::Active),
            // What is to be made again is not reset.
            Work::Reset { .. } => {
                let again =
                    |s: &Step| matches!(&s.work, Work::Create { instance: i, .. } if i == instance);
                self.running.steps.iter().any(again)
                    || own.all(|(_, _, c)| c.state != LifeCycleState::Error)
            }
            _ => true,
        }
    }
}

/// The component and the kind of a step that orders speak of.
fn ordered(work: &Work) -> Option<(&str, &'static str)> {
    match work {
        Work::Create { instance, .. }
        | Work::Reset { instance, .. }
        | Work::Activate { instance, .. }
        | Work::Deactivate { instance, .. }
        | Work::Delete { instance, .. } => Some((instance, work.kind())),
        _ => None,
    }
}

fn lists<'a>(orders: &'a Orders, work: &Work) -> Vec<&'a [Condition]> {
    match work {
        Work::Create { .. } => vec![&orders.start_up, &orders.initializing],
        Work::Reset { .. } => vec![&orders.resetting],
        Work::Activate { .. } => vec![&orders.activation],
        Work::Deactivate { .. } => vec![&orders.deactivation],
        Work::Delete { .. } => vec![&orders.shut_down, &orders.finalizing],
        _ => Vec::new(),
    }
}

/// True when a component waits, by `Preceding`, for one whose number in the list is higher than its own: nobody waits
/// for its number then.
fn outweighed(list: &[Condition], instance: &str, number: u32) -> bool {
    let mut seen = BTreeSet::new();
    let mut open = vec![instance];
    while let Some(one) = open.pop() {
        for condition in list.iter().filter(|c| c.target == one) {
            if one != instance && condition.sequence > number {
                return true;
            }
            if let Some(WaitFor::Preceding { components, .. }) = &condition.wait {
                let new = components.iter().map(String::as_str);
                open.extend(new.filter(|name| seen.insert(*name)));
            }
        }
    }
    false
}

/// Everyone that a component must wait for: each list has its own sequence. A `Preceding` outweighs the sequence.
fn predecessors(lists: &[&[Condition]], instance: &str) -> Vec<Before> {
    let mut all = Vec::new();
    for list in lists {
        let level = |name: &str| {
            let own = list.iter().filter(|c| c.target == name);
            own.map(|c| c.sequence).max()
        };
        let Some(own) = level(instance) else { continue };
        let named = |name: &str, limited: bool| {
            let mut own = list.iter().filter(|c| c.target == instance);
            own.any(|condition| match &condition.wait {
                Some(WaitFor::Preceding {
                    components,
                    timeout_ms,
                    ..
                }) => components.iter().any(|c| c == name) && (*timeout_ms > 0) == limited,
                _ => false,
            })
        };
        for condition in *list {
            let target = &condition.target;
            let lower = level(target).filter(|other| *other < own);
            if lower.is_some_and(|lower| !outweighed(list, target, lower)) {
                all.push(Before {
                    instance: target.clone(),
                    timing: SendingTiming::Sync,
                    limited: named(target, true) && !named(target, false),
                });
            }
            let Some(WaitFor::Preceding {
                timing,
                timeout_ms,
                components,
            }) = &condition.wait
            else {
                continue;
            };
            if *target == instance {
                all.extend(components.iter().map(|c| Before {
                    instance: c.clone(),
                    timing: *timing,
                    limited: *timeout_ms > 0,
                }));
            }
        }
    }
    all
}
