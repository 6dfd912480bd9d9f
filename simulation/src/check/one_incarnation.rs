//! Nothing runs twice: no instance of a system anywhere, and no manager on its node.

use std::collections::BTreeMap;
use std::time::Duration;

use rts_plan::desired::ManagerKey;

use super::lives::Lives;
use super::{Verdicts, Violation};
use crate::truth::{Happened, Subject, Witness};

const NAME: &str = "one-incarnation";

/// Never two live incarnations of one instance of a system, wherever, and never two processes of one manager on a node.
pub struct OneIncarnation {
    lives: Lives,
    /// Node and manager → incarnation of the process, and since when.
    processes: BTreeMap<(String, ManagerKey), (String, Duration)>,
    verdicts: Verdicts,
}

impl OneIncarnation {
    /// Of a run that begins now.
    pub fn new(verdicts: Verdicts) -> Self {
        Self {
            lives: Lives::default(),
            processes: BTreeMap::new(),
            verdicts,
        }
    }

    fn created(&self, at: Duration, subject: &Subject) {
        let Some(system) = &subject.system else {
            return;
        };
        let Some(other) = self.lives.find(&system.uid, &subject.instance) else {
            return;
        };
        let (born, other) = (other.born.as_secs_f64(), &other.subject);
        self.verdicts.add(Violation {
            at,
            invariant: NAME,
            subject: subject.shown(),
            what: format!(
                "was created in process {} while one lives on {} in process {} since {born:.3} s: an instance runs once, \
                 wherever",
                subject.process, other.node, other.process
            ),
        });
    }

    fn started(&mut self, at: Duration, node: &str, manager: &ManagerKey, process: &str) {
        let key = (node.to_owned(), manager.clone());
        let Some((other, since)) = self.processes.insert(key, (process.to_owned(), at)) else {
            return;
        };
        let since = since.as_secs_f64();
        self.verdicts.add(Violation {
            at,
            invariant: NAME,
            subject: format!("manager {} on {node}", manager.display_name()),
            what: format!(
                "process {process} was started while process {other} lives since {since:.3} s: the next one waits for the \
                 end of the last"
            ),
        });
    }
}

impl Witness for OneIncarnation {
    fn see(&mut self, at: Duration, what: &Happened) {
        match what {
            Happened::Created(subject) => self.created(at, subject),
            Happened::ProcessStarted {
                node,
                manager,
                process,
            } => self.started(at, node, manager, process),
            Happened::ProcessEnded { process, .. } => {
                self.processes.retain(|_, (own, _)| own != process);
            }
            Happened::Rebooted { node } => self.processes.retain(|(there, _), _| there != node),
            _ => {}
        }
        self.lives.see(at, what);
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::{created, deleted, ended, see, started, subject};
    use super::*;
    use crate::truth::Cause;

    fn verdict(all: &[Happened]) -> Option<String> {
        let verdicts = Verdicts::default();
        see(&mut OneIncarnation::new(verdicts.clone()), all);
        verdicts.first().map(|violation| violation.to_string())
    }

    #[test]
    fn one_after_the_other_is_well() {
        let (first, second) = (subject("A", "node1", "p1"), subject("A", "node1", "p2"));
        let good = [
            started("node1", "p1"),
            created(&first),
            deleted(&first, Cause::Asked),
            created(&first),
            // The end of a process is the end of all that is in it.
            ended("node1", "p1", Cause::Died),
            started("node1", "p2"),
            created(&second),
            Happened::Rebooted {
                node: "node1".to_owned(),
            },
            started("node1", "p3"),
            started("node2", "p4"),
            created(&subject("A", "node2", "p4")),
        ];
        assert_eq!(verdict(&good), None);
    }

    #[test]
    fn an_instance_that_runs_twice_is_named_with_both_places() {
        let twice = [
            created(&subject("A", "node1", "p1")),
            created(&subject("A", "node2", "p2")),
        ];
        assert_eq!(
            verdict(&twice).unwrap(),
            "at 1.000 s, one-incarnation: component A of hello on node2: was created in process p2 while one lives on \
             node1 in process p1 since 0.000 s: an instance runs once, wherever"
        );
    }

    #[test]
    fn a_manager_that_is_started_before_the_last_one_has_ended_is_named() {
        let early = [started("node1", "p1"), started("node1", "p2")];
        assert_eq!(
            verdict(&early).unwrap(),
            "at 1.000 s, one-incarnation: manager hello.main on node1: process p2 was started while process p1 lives since \
             0.000 s: the next one waits for the end of the last"
        );
    }
}
