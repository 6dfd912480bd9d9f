//! What was acknowledged is never lost, whatever crashes when.

use std::collections::BTreeMap;
use std::time::Duration;

use rts_agent_api::messages::LedgerFence;

use super::{Desired, Verdicts, Violation};
use crate::truth::{Happened, Witness};

const NAME: &str = "acknowledged-kept";

/// Every later reading of a store or ledger shows what was acknowledged, or something later. What was never acknowledged
/// may be there or not.
pub struct AcknowledgedKept {
    /// System → generation; none once its deletion was acknowledged.
    systems: BTreeMap<String, Option<u64>>,
    /// Node → fence.
    ledgers: BTreeMap<String, LedgerFence>,
    desired: Desired,
    /// As told by [`Desired::restored`] when it was looked at last.
    restores: u64,
    verdicts: Verdicts,
}

impl AcknowledgedKept {
    /// Of a run that begins now.
    pub fn new(desired: Desired, verdicts: Verdicts) -> Self {
        Self {
            systems: BTreeMap::new(),
            ledgers: BTreeMap::new(),
            desired,
            restores: 0,
            verdicts,
        }
    }

    fn desired_acked(&mut self, at: Duration, system: &str, generation: Option<u64>) {
        self.forget_after_restore();
        if self.desired.is_of_before(system) {
            return;
        }
        let before = self.systems.insert(system.to_owned(), generation);
        if let (Some(Some(before)), Some(now)) = (before, generation)
            && now < before
        {
            let what = format!("generation {now} was acknowledged after generation {before}");
            self.broken(at, format!("system {system}"), what);
        }
    }

    fn store_read(&mut self, at: Duration, stored: &[(String, Option<u64>)]) {
        self.forget_after_restore();
        for (system, acked) in &self.systems {
            let found = stored.iter().find(|(name, _)| name == system);
            let found = found.map(|(_, generation)| *generation);
            let why = match (acked, found) {
                // It may be gone altogether by now.
                (Some(_), None | Some(None)) => {
                    let asked = self.desired.is_in_flight(system, true);
                    (!asked)
                        .then(|| "does not have it, and nobody has asked for its end".to_owned())
                }
                (Some(acked), Some(Some(found))) => {
                    (found < *acked).then(|| format!("has generation {found}"))
                }
                (None, Some(Some(found))) => {
                    let asked = self.desired.is_in_flight(system, false);
                    (!asked).then(|| format!("has generation {found}"))
                }
                (None, None | Some(None)) => None,
            };
            if let Some(why) = why {
                let acked = acked.map_or("its deletion".to_owned(), |g| format!("generation {g}"));
                let what = format!("{acked} was acknowledged, and a controller that started {why}");
                self.broken(at, format!("system {system}"), what);
            }
        }
    }

    fn ledger_read(&self, at: Duration, node: &str, read: Option<&LedgerFence>) {
        let Some(acked) = self.ledgers.get(node) else {
            return;
        };
        let shown = |fence: &LedgerFence| {
            format!(
                "epoch {}, generation {} of store {} (digest {})",
                fence.epoch, fence.generation, fence.cluster_uid, fence.digest
            )
        };
        let kept = read.is_some_and(|read| {
            let number = |fence: &LedgerFence| (fence.epoch, fence.generation);
            // A take-over that was never acknowledged may have come to the disk.
            let other = read.cluster_uid != acked.cluster_uid;
            let same = number(read) == number(acked) && read.digest == acked.digest;
            other || same || number(read) > number(acked)
        });
        if !kept {
            let read = read.map_or("nothing".to_owned(), shown);
            let acked = shown(acked);
            let what = format!("{acked} was acknowledged, and an agent that started read {read}");
            self.broken(at, format!("ledger of {node}"), what);
        }
    }

    fn broken(&self, at: Duration, subject: String, what: String) {
        self.verdicts.add(Violation {
            at,
            invariant: NAME,
            subject,
            what,
        });
    }

    /// An older store was put in the place of this one on purpose.
    fn forget_after_restore(&mut self) {
        let restores = self.desired.restores();
        if restores != self.restores {
            self.restores = restores;
            self.systems.clear();
        }
    }
}

impl Witness for AcknowledgedKept {
    fn see(&mut self, at: Duration, what: &Happened) {
        match what {
            Happened::DesiredAcked { system, generation } => {
                self.desired_acked(at, system, *generation);
            }
            Happened::StoreRead { systems, .. } => self.store_read(at, systems),
            Happened::LedgerAcked { node, fence, .. } => {
                self.ledgers.insert(node.clone(), fence.clone());
            }
            Happened::LedgerRead { node, fence } => self.ledger_read(at, node, fence.as_ref()),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::{desired_acked, fence, hello, ledger_acked, ledger_read, see};
    use super::*;

    fn verdict(desired: &Desired, all: &[Happened]) -> Option<String> {
        let verdicts = Verdicts::default();
        see(
            &mut AcknowledgedKept::new(desired.clone(), verdicts.clone()),
            all,
        );
        verdicts.first().map(|violation| violation.to_string())
    }

    fn read(systems: &[(&str, Option<u64>)]) -> Happened {
        let own = |(name, generation): &(&str, Option<u64>)| ((*name).to_owned(), *generation);
        Happened::StoreRead {
            epoch: 1,
            systems: systems.iter().map(own).collect(),
        }
    }

    #[test]
    fn what_was_acknowledged_or_something_later_is_well() {
        let desired = Desired::default();
        let good = [
            read(&[]),
            // Never acknowledged.
            read(&[("hello", Some(1))]),
            desired_acked(Some(1)),
            read(&[("hello", Some(1)), ("other", None)]),
            read(&[("hello", Some(3))]),
            desired_acked(None),
            read(&[("hello", None)]),
            read(&[]),
            desired_acked(Some(1)),
            read(&[("hello", Some(1))]),
        ];
        assert_eq!(verdict(&desired, &good), None);
    }

    #[test]
    fn a_system_that_is_lost_or_older_is_named() {
        let desired = Desired::default();
        let lost = verdict(&desired, &[desired_acked(Some(2)), read(&[])]);
        assert_eq!(
            lost.unwrap(),
            "at 1.000 s, acknowledged-kept: system hello: generation 2 was acknowledged, and a controller that started \
             does not have it, and nobody has asked for its end"
        );
        let older = verdict(
            &desired,
            &[desired_acked(Some(2)), read(&[("hello", Some(1))])],
        );
        assert!(
            older
                .unwrap()
                .ends_with("a controller that started has generation 1")
        );
        let back = verdict(
            &desired,
            &[desired_acked(None), read(&[("hello", Some(2))])],
        );
        assert!(back.unwrap().contains("its deletion was acknowledged"));
    }

    #[test]
    fn what_was_asked_for_meanwhile_may_have_been_done() {
        let acked = [desired_acked(Some(2)), read(&[])];
        let desired = Desired::default();
        desired.deletion_asked("hello");
        assert_eq!(verdict(&desired, &acked), None);
        let deleted = [desired_acked(None), read(&[("hello", Some(1))])];
        desired.asked(&hello(&["A"]));
        assert_eq!(verdict(&desired, &deleted), None);
        let desired = Desired::default();
        desired.restored();
        let mut witness = AcknowledgedKept::new(Desired::default(), Verdicts::default());
        witness.systems.insert("hello".to_owned(), Some(4));
        witness.desired = desired;
        witness.see(Duration::ZERO, &read(&[]));
        assert_eq!(witness.verdicts.first(), None);
    }

    #[test]
    fn what_a_controller_of_before_acknowledges_counts_no_more() {
        let desired = Desired::default();
        desired.asked(&hello(&["A"]));
        desired.restored();
        let acked = [desired_acked(Some(1)), read(&[])];
        assert_eq!(verdict(&desired, &acked), None);
        desired.asked(&hello(&["A"]));
        assert!(verdict(&desired, &acked).is_some());
    }

    #[test]
    fn a_ledger_that_is_lost_older_or_another_is_named() {
        let desired = Desired::default();
        let acked = || ledger_acked(fence("c", 1, 2, "x"), &["u1"]);
        for good in [("c", 1, 2, "x"), ("c", 1, 3, "y"), ("c", 2, 1, "y")] {
            let (cluster, epoch, generation, digest) = good;
            let read = ledger_read(Some(fence(cluster, epoch, generation, digest)));
            assert_eq!(verdict(&desired, &[ledger_read(None), acked(), read]), None);
        }
        for bad in [
            None,
            Some(fence("c", 1, 1, "w")),
            Some(fence("c", 1, 2, "y")),
        ] {
            let text = verdict(&desired, &[acked(), ledger_read(bad)]).unwrap();
            assert!(
                text.contains("ledger of node1: epoch 1, generation 2 of store c"),
                "{text}"
            );
        }
    }
}
