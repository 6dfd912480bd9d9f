//! What is as desired is left alone.

use std::collections::BTreeSet;
use std::time::Duration;

use rts_schemas::names;
use rts_schemas::system::{ComponentSpec, OnDisconnect};

use super::desired::Candidates;
use super::lives::{Alive, Lives};
use super::{Desired, Verdicts, Violation};
use crate::truth::{Cause, Happened, Subject, Witness};

const NAME: &str = "settled-untouched";

/// A component that is Active, that no fault has hit, and of which all versions that may be in force say the same, is not
/// deactivated, deleted, or ended with its process by anybody's asking; nor is a connector cut between two such ones.
pub struct SettledUntouched {
    lives: Lives,
    /// Components that have just ended with their process, settled as they were.
    dying: Vec<(Duration, Subject)>,
    desired: Desired,
    verdicts: Verdicts,
}

impl SettledUntouched {
    /// Of a run that begins now.
    pub fn new(desired: Desired, verdicts: Verdicts) -> Self {
        Self {
            lives: Lives::default(),
            dying: Vec::new(),
            desired,
            verdicts,
        }
    }

    /// The component, where it is as desired, and nobody desires anything else of it.
    fn settled(&self, incarnation: &str) -> Option<(&Alive, Candidates)> {
        let alive = self.lives.get(incarnation)?;
        let subject = &alive.subject;
        let system = subject.system.as_ref()?;
        let candidates = self.desired.candidates(&system.name);
        let spec = candidates.agreed(&subject.instance)?;
        let hit = alive.blemished || self.lives.process_is_blemished(&subject.process);
        let other = candidates
            .present()
            .any(|s| self.desired.has_other_module(s));
        let as_desired = alive.state == "Active"
            && candidates.uid.as_ref() == Some(&system.uid)
            && is_in_place(subject, spec)
            && !self.desired.is_by_hand(&subject.instance);
        (as_desired && !hit && !other).then_some((alive, candidates))
    }

    /// What makes a manager, or a plan, take down a settled component: its policy asks for all its connectors, and one of
    /// them is not there, or ends at a component that goes for this same reason.
    fn needs_a_peer<'a>(
        &'a self,
        alive: &'a Alive,
        candidates: &Candidates,
        seen: &mut BTreeSet<&'a str>,
    ) -> bool {
        let instance = alive.subject.instance.as_str();
        let policy = candidates.agreed(instance).map(|spec| &spec.policy);
        let keeps = policy.is_none_or(|policy| policy.on_disconnect == OnDisconnect::Keep);
        if keeps || !seen.insert(instance) {
            return false;
        }
        let uid = alive.subject.system.as_ref().map_or("", |s| s.uid.as_str());
        let connectors = candidates.present().flat_map(|spec| &spec.connectors);
        let mut own =
            connectors.filter(|c| c.source.instance == instance || c.target.instance == instance);
        own.any(|connector| {
            let agreed = candidates.agreed_connector(&connector.name).is_some();
            let ends = [&connector.source.instance, &connector.target.instance];
            let settled = ends.map(|end| {
                let alive = self.lives.find(uid, end)?;
                self.settled(&alive.subject.incarnation).map(|(a, _)| a)
            });
            let [Some(source), Some(target)] = settled else {
                return true;
            };
            let made = source.connectors.get(&connector.name);
            !agreed
                || made != Some(&Some(target.subject.incarnation.clone()))
                || self.needs_a_peer(source, candidates, seen)
                || self.needs_a_peer(target, candidates, seen)
        })
    }

    fn touched(&self, at: Duration, subject: &Subject, deed: &str) {
        if let Some((alive, candidates)) = self.settled(&subject.incarnation)
            && !self.needs_a_peer(alive, &candidates, &mut BTreeSet::new())
        {
            self.broken(at, subject, deed);
        }
    }

    fn broken(&self, at: Duration, subject: &Subject, deed: &str) {
        self.verdicts.add(Violation {
            at,
            invariant: NAME,
            subject: subject.shown(),
            what: format!(
                "{deed}, though it was Active, no fault had hit it, and nobody had asked for a change of it"
            ),
        });
    }

    fn connected(&mut self, of: &Subject, connector: &str) {
        let Some(system) = &of.system else {
            return;
        };
        let candidates = self.desired.candidates(&system.name);
        let mut specs = candidates.present().flat_map(|spec| &spec.connectors);
        let spec = specs.find(|c| c.name == connector);
        let target = spec.and_then(|c| self.lives.find(&system.uid, &c.target.instance));
        let target = target.map(|alive| alive.subject.incarnation.clone());
        if let Some(alive) = self.lives.get_mut(&of.incarnation) {
            alive.connectors.insert(connector.to_owned(), target);
        }
    }

    fn disconnected(&mut self, at: Duration, of: &Subject, connector: &str, cause: Cause) {
        let made = self.lives.get_mut(&of.incarnation);
        let target = made.and_then(|alive| alive.connectors.remove(connector));
        let (Cause::Asked, Some(Some(target))) = (cause, target) else {
            return;
        };
        let Some((_, candidates)) = self.settled(&of.incarnation) else {
            return;
        };
        let agreed = candidates.agreed_connector(connector).is_some();
        if agreed && self.settled(&target).is_some() {
            let deed = format!("its connector {connector} was cut between two that are well");
            self.broken(at, of, &deed);
        }
    }

    fn ended(&mut self, at: Duration, process: &str, cause: Cause) {
        let here = |subject: &&Subject| subject.process == process;
        let mut all: Vec<Subject> = Vec::new();
        let alive = self.lives.all().map(|alive| &alive.subject).filter(here);
        all.extend(
            alive
                .filter(|s| self.settled(&s.incarnation).is_some())
                .cloned(),
        );
        let dying = self.dying.iter().filter(|(when, _)| *when == at);
        all.extend(dying.map(|(_, subject)| subject).filter(here).cloned());
        if cause == Cause::Asked
            && let Some(subject) = all.first()
        {
            self.broken(at, subject, "its process was ended");
        }
        self.dying.clear();
    }
}

/// True where the profile wants it to be, as far as it says so itself.
fn is_in_place(subject: &Subject, spec: &ComponentSpec) -> bool {
    let place = &spec.placement;
    let node = place.node.as_ref().is_none_or(|node| *node == subject.node);
    let named = place.manager.as_ref();
    let named = named.filter(|name| !place.isolated && names::is_manager_name(name));
    node && named.is_none_or(|name| *name == subject.manager.name)
}

impl Witness for SettledUntouched {
    fn see(&mut self, at: Duration, what: &Happened) {
        match what {
            Happened::State {
                of,
                from,
                cause: Cause::Asked,
                ..
            } if from == "Active" => self.touched(at, of, "it was deactivated"),
            Happened::Deleted(of, Cause::Asked) => self.touched(at, of, "it was deleted"),
            Happened::Deleted(of, Cause::Died) if self.settled(&of.incarnation).is_some() => {
                self.dying.push((at, of.clone()));
            }
            Happened::Connected { of, connector } => self.connected(of, connector),
            Happened::Disconnected {
                of,
                connector,
                cause,
            } => self.disconnected(at, of, connector, *cause),
            Happened::ProcessEnded { process, cause, .. } => self.ended(at, process, *cause),
            _ => {}
        }
        self.lives.see(at, what);
    }
}

#[cfg(test)]
mod tests;
