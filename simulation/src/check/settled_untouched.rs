//! What is as desired is left alone.

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

    /// What makes a manager, or a plan, take down a settled component: its policy asks for all its connectors.
    fn needs_a_peer(&self, alive: &Alive, candidates: &Candidates) -> bool {
        let instance = &alive.subject.instance;
        let policy = candidates.agreed(instance).map(|spec| &spec.policy);
        if policy.is_none_or(|policy| policy.on_disconnect == OnDisconnect::Keep) {
            return false;
        }
        let uid = alive.subject.system.as_ref().map_or("", |s| s.uid.as_str());
        let connectors = candidates.present().flat_map(|spec| &spec.connectors);
        let mut own =
            connectors.filter(|c| c.source.instance == *instance || c.target.instance == *instance);
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
            !agreed || made != Some(&Some(target.subject.incarnation.clone()))
        })
    }

    fn touched(&self, at: Duration, subject: &Subject, deed: &str) {
        if let Some((alive, candidates)) = self.settled(&subject.incarnation)
            && !self.needs_a_peer(alive, &candidates)
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
mod tests {
    use rts_schemas::system::SystemSpec;

    use super::super::fixtures::{
        activated, blemished, connected, connector, created, deleted, desired_acked, disconnected,
        ended, hello, see, state, subject,
    };
    use super::*;

    fn spec() -> SystemSpec {
        let mut spec = hello(&["A", "B"]);
        spec.connectors = vec![connector("A.out-B.in", "A", "B")];
        spec
    }

    fn both() -> (Subject, Subject) {
        (subject("A", "node1", "p1"), subject("B", "node1", "p2"))
    }

    /// What is said when this happens to the running system, after this was asked for.
    fn verdict(ask: impl FnOnce(&Desired), then: &[Happened]) -> Option<String> {
        let verdicts = Verdicts::default();
        let mut desired = Desired::default();
        let mut witness = SettledUntouched::new(desired.clone(), verdicts.clone());
        desired.asked(&spec());
        let (a, b) = both();
        let up = [
            desired_acked(Some(1)),
            created(&a),
            created(&b),
            connected(&a, "A.out-B.in"),
            activated(&a),
            activated(&b),
        ];
        see(&mut desired, &up);
        see(&mut witness, &up);
        desired.converged();
        ask(&desired);
        see(&mut witness, then);
        verdicts.first().map(|violation| violation.to_string())
    }

    fn nothing(_: &Desired) {}

    fn deactivated(of: &Subject) -> Happened {
        state(of, "Active", "Inactive", Cause::Asked)
    }

    #[test]
    fn every_way_to_touch_what_is_well_is_named() {
        let (a, b) = both();
        assert_eq!(
            verdict(nothing, &[deactivated(&b)]).unwrap(),
            "at 0.000 s, settled-untouched: component B of hello on node1: it was deactivated, though it was Active, no \
             fault had hit it, and nobody had asked for a change of it"
        );
        let ways = [
            (vec![deleted(&a, Cause::Asked)], "it was deleted"),
            (
                vec![ended("node1", "p1", Cause::Asked)],
                "its process was ended",
            ),
            (
                vec![disconnected(&a, "A.out-B.in", Cause::Asked)],
                "its connector A.out-B.in was cut",
            ),
        ];
        for (all, deed) in ways {
            let text = verdict(nothing, &all).unwrap();
            assert!(text.contains(deed), "{text}");
        }
        let at_once =
            verdict_at_once(&[deleted(&a, Cause::Died), ended("node1", "p1", Cause::Asked)]);
        assert!(at_once.unwrap().contains("its process was ended"));
    }

    /// All of it at the same time.
    fn verdict_at_once(all: &[Happened]) -> Option<String> {
        let verdicts = Verdicts::default();
        let mut desired = Desired::default();
        desired.asked(&spec());
        let mut witness = SettledUntouched::new(desired.clone(), verdicts.clone());
        let (a, b) = both();
        let up = [created(&a), created(&b), activated(&a), activated(&b)];
        see(&mut desired, &up);
        see(&mut witness, &up);
        for what in all {
            witness.see(Duration::from_secs(9), what);
        }
        verdicts.first().map(|violation| violation.to_string())
    }

    #[test]
    fn faults_and_what_is_done_about_them_are_no_disturbance() {
        let (a, b) = both();
        let good: [&[Happened]; 5] = [
            &[
                state(&b, "Active", "Error", Cause::Fault),
                deleted(&b, Cause::Asked),
            ],
            &[
                ended("node1", "p2", Cause::Died),
                disconnected(&a, "A.out-B.in", Cause::Asked),
            ],
            &[blemished("p2", None), deactivated(&b)],
            &[
                blemished("p1", Some("A")),
                ended("node1", "p1", Cause::Asked),
            ],
            &[disconnected(&a, "A.out-B.in", Cause::Died)],
        ];
        for all in good {
            assert_eq!(verdict(nothing, all), None, "{all:?}");
        }
    }

    #[test]
    fn what_was_asked_for_is_done() {
        let (a, b) = both();
        let mut changed = spec();
        changed.components[1].configuration.active = Some("fast".to_owned());
        let change = |desired: &Desired| desired.asked(&changed);
        assert_eq!(verdict(change, &[deactivated(&b)]), None);
        let other = verdict(change, &[deactivated(&a)]);
        assert!(other.unwrap().contains("component A"), "only B was changed");
        let end = |desired: &Desired| desired.deletion_asked("hello");
        let all = [
            deactivated(&a),
            disconnected(&a, "A.out-B.in", Cause::Asked),
        ];
        assert_eq!(verdict(end, &all), None);
        let module = |desired: &Desired| desired.module_changed("Any");
        assert_eq!(verdict(module, &[ended("node1", "p1", Cause::Asked)]), None);
        let hand = |desired: &Desired| desired.by_hand("B");
        assert_eq!(verdict(hand, &[deactivated(&b)]), None);
        let mut unplugged = spec();
        unplugged.connectors.clear();
        let unplug = |desired: &Desired| desired.asked(&unplugged);
        assert_eq!(
            verdict(unplug, &[disconnected(&a, "A.out-B.in", Cause::Asked)]),
            None
        );
    }

    #[test]
    fn who_needs_a_peer_goes_when_that_is_lost() {
        let (a, b) = both();
        let mut strict = spec();
        strict.components[0].policy.on_disconnect = OnDisconnect::Deactivate;
        let ask = |desired: &Desired| {
            desired.asked(&strict);
            let mut desired = desired.clone();
            see(&mut desired, &[desired_acked(Some(2))]);
            desired.converged();
        };
        let lost = [state(&b, "Active", "Error", Cause::Fault), deactivated(&a)];
        assert_eq!(verdict(ask, &lost), None);
        assert!(verdict(ask, &[deactivated(&a)]).is_some());
    }
}
