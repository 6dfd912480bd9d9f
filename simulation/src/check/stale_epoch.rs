//! No agent obeys the past, or a stranger.

use std::collections::BTreeMap;
use std::time::Duration;

use rts_agent_api::messages::LedgerFence;

use super::{Desired, Verdicts, Violation};
use crate::truth::{Happened, Witness};

const NAME: &str = "stale-epoch";

/// After an agent has acknowledged epoch E and generation G it begins no step for less, nor acknowledges less; and none of
/// another store while it holds a set of something, unless somebody has handed its node over.
pub struct StaleEpoch {
    /// Node → what it acknowledged last.
    held: BTreeMap<String, Held>,
    desired: Desired,
    verdicts: Verdicts,
}

struct Held {
    fence: LedgerFence,
    /// It holds a set of something.
    filled: bool,
}

/// What an agent obeyed.
struct Obeyed<'a> {
    cluster: &'a str,
    number: (u64, u64),
    deed: &'a str,
}

impl StaleEpoch {
    /// Of a run that begins now.
    pub fn new(desired: Desired, verdicts: Verdicts) -> Self {
        Self {
            held: BTreeMap::new(),
            desired,
            verdicts,
        }
    }

    fn judge(&self, at: Duration, node: &str, obeyed: &Obeyed<'_>) {
        let Some(held) = self.held.get(node) else {
            return;
        };
        let (cluster, (epoch, generation)) = (obeyed.cluster, obeyed.number);
        let own = &held.fence;
        let why = if own.cluster_uid == cluster {
            match obeyed.number < (own.epoch, own.generation) {
                true => "is of the past",
                false => return,
            }
        } else {
            match held.filled && !self.desired.is_handed_over(node) {
                true => "is of another store, and nobody has handed the node over",
                false => return,
            }
        };
        self.verdicts.add(Violation {
            at,
            invariant: NAME,
            subject: format!("node {node}"),
            what: format!(
                "{} for epoch {epoch}, generation {generation} of store {cluster}, which {why}: it had acknowledged epoch \
                 {}, generation {} of store {}",
                obeyed.deed, own.epoch, own.generation, own.cluster_uid
            ),
        });
    }

    fn acked(&mut self, at: Duration, node: &str, fence: &LedgerFence, filled: bool) {
        let obeyed = Obeyed {
            cluster: &fence.cluster_uid,
            number: (fence.epoch, fence.generation),
            deed: "a set was acknowledged",
        };
        self.judge(at, node, &obeyed);
        if let Some(held) = self.held.get(node) {
            self.same_digest(at, node, &held.fence, fence);
        }
        let fence = fence.clone();
        self.held.insert(node.to_owned(), Held { fence, filled });
    }

    fn same_digest(&self, at: Duration, node: &str, held: &LedgerFence, new: &LedgerFence) {
        let number = |fence: &LedgerFence| {
            let cluster = fence.cluster_uid.clone();
            (cluster, fence.epoch, fence.generation)
        };
        if number(held) != number(new) || held.digest == new.digest {
            return;
        }
        self.verdicts.add(Violation {
            at,
            invariant: NAME,
            subject: format!("node {node}"),
            what: format!(
                "acknowledged two sets under epoch {}, generation {}: {} and {}",
                held.epoch, held.generation, held.digest, new.digest
            ),
        });
    }
}

impl Witness for StaleEpoch {
    fn see(&mut self, at: Duration, what: &Happened) {
        match what {
            Happened::LedgerAcked {
                node,
                fence,
                systems,
            } => self.acked(at, node, fence, !systems.is_empty()),
            Happened::StepBegan {
                node,
                cluster,
                epoch,
                generation,
                step,
            } => {
                let obeyed = Obeyed {
                    cluster,
                    number: (*epoch, *generation),
                    deed: &format!("step `{step}` began"),
                };
                self.judge(at, node, &obeyed);
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::{fence, ledger_acked, see};
    use super::*;

    fn began(cluster: &str, epoch: u64, generation: u64) -> Happened {
        Happened::StepBegan {
            node: "node1".to_owned(),
            cluster: cluster.to_owned(),
            epoch,
            generation,
            step: "Activate A".to_owned(),
        }
    }

    fn verdict(all: &[Happened]) -> Option<String> {
        verdict_with(&Desired::default(), all)
    }

    fn verdict_with(desired: &Desired, all: &[Happened]) -> Option<String> {
        let verdicts = Verdicts::default();
        see(&mut StaleEpoch::new(desired.clone(), verdicts.clone()), all);
        verdicts.first().map(|violation| violation.to_string())
    }

    #[test]
    fn numbers_that_rise_are_well() {
        let good = [
            began("c", 1, 1),
            ledger_acked(fence("c", 1, 1, "x"), &["u1"]),
            ledger_acked(fence("c", 1, 1, "x"), &["u1"]),
            began("c", 1, 1),
            // Stored, and its acknowledgement was lost.
            began("c", 1, 2),
            ledger_acked(fence("c", 2, 1, "y"), &[]),
            began("c", 2, 1),
            // Nobody misses an empty set.
            ledger_acked(fence("d", 1, 1, "z"), &["u2"]),
        ];
        assert_eq!(verdict(&good), None);
    }

    #[test]
    fn a_step_or_set_of_the_past_is_named_with_both_numbers() {
        let held = ledger_acked(fence("c", 2, 5, "x"), &["u1"]);
        let step = verdict(&[held.clone(), began("c", 1, 9)]);
        assert_eq!(
            step.unwrap(),
            "at 1.000 s, stale-epoch: node node1: step `Activate A` began for epoch 1, generation 9 of store c, which is of \
             the past: it had acknowledged epoch 2, generation 5 of store c"
        );
        let set = verdict(&[held, ledger_acked(fence("c", 2, 4, "w"), &["u1"])]);
        assert!(
            set.unwrap()
                .contains("a set was acknowledged for epoch 2, generation 4")
        );
    }

    #[test]
    fn a_stranger_is_obeyed_only_where_the_node_was_handed_over() {
        let all = [
            ledger_acked(fence("c", 1, 1, "x"), &["u1"]),
            ledger_acked(fence("d", 7, 7, "y"), &["u2"]),
        ];
        assert!(verdict(&all).unwrap().contains("of another store"));
        let desired = Desired::default();
        desired.handed_over("node1");
        assert_eq!(verdict_with(&desired, &all), None);
    }

    #[test]
    fn two_sets_under_one_number_are_named() {
        let two = [
            ledger_acked(fence("c", 1, 1, "x"), &["u1"]),
            ledger_acked(fence("c", 1, 1, "y"), &["u1"]),
        ];
        assert!(
            verdict(&two)
                .unwrap()
                .contains("two sets under epoch 1, generation 1: x and y")
        );
    }
}
