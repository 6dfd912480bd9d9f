//! Nothing comes up before what its profile puts before it.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use rts_plan::target;
use rts_schemas::system::{OnDisconnect, SystemSpec};

use super::hard_orders::{before_activation, before_creation};
use super::lives::{Alive, Lives};
use super::{Desired, Verdicts, Violation};
use crate::truth::{Cause, Happened, Subject, Witness};

const NAME: &str = "prerequisites";

/// How long ago something may have ceased without anybody's asking, for a step that was planned while it was there: an
/// agent tells of it within a second, a node is unknown after three, and a batch may wait for some steps that take as long
/// as they may.
pub const LATELY: Duration = Duration::from_secs(30);

/// Longest time from the begin of a step to what it does: the longest time that a start may take, and some.
const STEP: Duration = Duration::from_secs(20);

/// An agent that heals alone waits for components of other nodes too, as it cannot see them: nothing comes up there
/// without a controller. Where this is off, only components of its own node bind it.
const ALONE_TOO: bool = true;

/// A component is activated by somebody's asking only when all that its Activation order puts before it is Active, and
/// created only when all that StartUp and Initializing put before it is there, or was so lately and ceased by no asking.
///
/// Any version that may be in force may permit it. What a time-out of `Preceding` ends is never gone on without on the way
/// up, so that time-outs excuse nothing here.
pub struct Prerequisites {
    lives: Lives,
    /// Uid and instance → when and how it ceased to be Active.
    inactive: BTreeMap<(String, String), Ceased>,
    /// Uid and instance → when and how it ceased to be there.
    gone: BTreeMap<(String, String), Ceased>,
    /// Node and step of a controller's batch → when it began.
    began: BTreeMap<(String, String), Duration>,
    desired: Desired,
    verdicts: Verdicts,
}

#[derive(Clone, Copy)]
struct Ceased {
    at: Duration,
    /// Not by asking, or because of a fault.
    excused: bool,
}

/// What comes up.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Up {
    Created,
    Activated,
}

impl Prerequisites {
    /// Of a run that begins now.
    pub fn new(desired: Desired, verdicts: Verdicts) -> Self {
        Self {
            lives: Lives::default(),
            inactive: BTreeMap::new(),
            gone: BTreeMap::new(),
            began: BTreeMap::new(),
            desired,
            verdicts,
        }
    }

    fn judge(&self, at: Duration, subject: &Subject, up: Up) {
        let Some(system) = &subject.system else {
            return;
        };
        let instance = &subject.instance;
        if self.desired.is_by_hand(instance) {
            return;
        }
        let candidates = self.desired.candidates(&system.name);
        let in_force = candidates.specs.len();
        let alone = !ALONE_TOO && self.is_alone(at, subject, up);
        let binds = |other: &&str| {
            let alive = self.lives.find(&system.uid, other);
            let there = alive.map(|alive| alive.subject.node.as_str());
            let there = there.or_else(|| node_of(candidates.present(), other));
            !alone || there.is_none_or(|there| there == subject.node)
        };
        let has = |spec: &&SystemSpec| spec.components.iter().any(|c| c.instance == *instance);
        let specs = candidates.present().map(AsRef::as_ref).filter(has);
        let missing = specs.map(|spec| {
            let before = match up {
                Up::Created => before_creation(spec, instance),
                Up::Activated => before_activation(spec, instance),
            };
            let met = |other: &&str| self.is_met(at, (&system.uid, other), up, (spec, in_force));
            let before = before.into_iter().filter(binds);
            before.filter(|other| !met(other)).collect()
        });
        // The newest speaks for them all when none permits it.
        let missing: Vec<Vec<&str>> = missing.collect();
        if missing.iter().any(Vec::is_empty) {
            return;
        }
        let Some(missing) = missing.last() else {
            return;
        };
        let missing: Vec<String> = missing
            .iter()
            .map(|other| self.told(&system.uid, other))
            .collect();
        let (deed, order) = match up {
            Up::Created => ("was created", "StartUp and Initializing put"),
            Up::Activated => ("was activated", "Activation puts"),
        };
        self.verdicts.add(Violation {
            at,
            invariant: NAME,
            subject: subject.shown(),
            what: format!(
                "{deed} before what {order} before it: {}",
                missing.join(", ")
            ),
        });
    }

    /// True where no controller has asked for it.
    fn is_alone(&self, at: Duration, subject: &Subject, up: Up) -> bool {
        let kind = match up {
            Up::Created => "Create",
            Up::Activated => "Activate",
        };
        let step = format!("{kind} {}", target::component(&subject.instance));
        let began = self.began.get(&(subject.node.clone(), step));
        began.is_none_or(|began| at.saturating_sub(*began) > STEP)
    }

    fn is_met(
        &self,
        at: Duration,
        (uid, instance): (&str, &str),
        up: Up,
        (spec, in_force): (&SystemSpec, usize),
    ) -> bool {
        let alive = self.lives.find(uid, instance);
        let (is_so, ceased) = match up {
            Up::Created => (alive.is_some(), &self.gone),
            Up::Activated => (alive.is_some_and(|a| a.state == "Active"), &self.inactive),
        };
        if is_so || self.desired.is_by_hand(instance) {
            return true;
        }
        // A manager itself takes down what has lost a peer.
        let by_itself = spec
            .components
            .iter()
            .any(|c| c.instance == instance && c.policy.on_disconnect != OnDisconnect::Keep);
        let key = (uid.to_owned(), instance.to_owned());
        ceased.get(&key).is_some_and(|ceased| {
            // While a change is under way, nodes hear of it one after the other.
            let excused = ceased.excused || by_itself || in_force > 1;
            excused && at.saturating_sub(ceased.at) <= LATELY
        })
    }

    fn told(&self, uid: &str, instance: &str) -> String {
        match self.lives.find(uid, instance) {
            Some(alive) => format!("{instance} is {} on {}", alive.state, alive.subject.node),
            None => format!("{instance} is not there"),
        }
    }

    /// What ceases now by this event.
    fn ceases(&mut self, at: Duration, what: &Happened) {
        match what {
            Happened::State {
                of,
                from,
                to,
                cause,
            } if from == "Active" && to != "Active" => {
                self.cease(at, of, *cause, false);
            }
            Happened::Deleted(of, cause) => self.cease(at, of, *cause, true),
            Happened::ProcessEnded { process, cause, .. } => {
                self.cease_all(at, *cause, |alive| alive.subject.process == *process);
            }
            Happened::Rebooted { node } => {
                self.cease_all(at, Cause::Died, |alive| alive.subject.node == *node);
            }
            _ => {}
        }
    }

    fn cease_all(&mut self, at: Duration, cause: Cause, which: impl Fn(&Alive) -> bool) {
        let all = self.lives.all().filter(|alive| which(alive));
        let all: Vec<Subject> = all.map(|alive| alive.subject.clone()).collect();
        for subject in all {
            self.cease(at, &subject, cause, true);
        }
    }

    fn cease(&mut self, at: Duration, of: &Subject, cause: Cause, gone: bool) {
        let Some(system) = &of.system else {
            return;
        };
        let Some(alive) = self.lives.get(&of.incarnation) else {
            return;
        };
        let hit = alive.blemished || self.lives.process_is_blemished(&of.process);
        let excused = cause != Cause::Asked || hit;
        let key = (system.uid.clone(), of.instance.clone());
        let ceased = Ceased { at, excused };
        if alive.state == "Active" {
            self.inactive.insert(key.clone(), ceased);
        }
        if gone {
            self.gone.insert(key, ceased);
        }
    }
}

/// Where a component is asked to be, as far as that is said.
fn node_of<'a>(
    specs: impl Iterator<Item = &'a Arc<SystemSpec>>,
    instance: &str,
) -> Option<&'a str> {
    let mut all = specs.flat_map(|spec| &spec.components);
    let component = all.find(|c| c.instance == instance)?;
    component.placement.node.as_deref()
}

impl Witness for Prerequisites {
    fn see(&mut self, at: Duration, what: &Happened) {
        match what {
            Happened::StepBegan { node, step, .. } => {
                self.began.insert((node.clone(), step.clone()), at);
            }
            Happened::Created(subject) => self.judge(at, subject, Up::Created),
            Happened::State {
                of,
                to,
                cause: Cause::Asked,
                ..
            } if to == "Active" => self.judge(at, of, Up::Activated),
            what => self.ceases(at, what),
        }
        self.lives.see(at, what);
    }
}

#[cfg(test)]
mod tests;
