//! The generations of NodeSpecs: each number is given out once, to one spec.
//!
//! A number may be sent while it is being made durable. An agent that has stored it tells it when it greets; for what may
//! be on its way to an agent when the controller ends, the next one leaves out so many numbers as may have been given out
//! beyond the durable ones.

use std::collections::BTreeMap;

use rts_plan::desired::NodeSpec;

use crate::core::{Core, Registry};
use crate::placement::Placement;
use crate::store::{NodeGeneration, StoreError, Write};

/// Numbers that may be given out to a node beyond the one that is durable.
pub(crate) const AHEAD: u64 = 4;

/// The number of a node's spec.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Number {
    /// It has one.
    Given(NodeGeneration),
    /// It has this new one, which is not durable.
    New(Taken),
    /// It is to have one that no other may have, which is just being stored.
    Pending,
}

/// A number that was not there before.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Taken {
    /// The number.
    pub given: NodeGeneration,
    /// What the node had until then.
    before: Option<NodeGeneration>,
}

/// Numbers by node.
pub(crate) type Numbers = BTreeMap<String, NodeGeneration>;

impl Core {
    /// The number of what a node is to run; a new one counts from now on, see [`Core::give_number`]. None when the node
    /// cannot be reached, or never ran anything.
    pub fn number_of(&self, node: &str, spec: &NodeSpec, digest: &str) -> Option<Number> {
        let mut registry = self.registry();
        // The first number of all is durable before it is sent.
        if !registry.nodes.contains_key(node) && !registry.pending.is_empty() {
            return Some(Number::Pending);
        }
        let number = self.next_number(&registry, node, spec, digest)?;
        if let Number::New(taken) = &number {
            registry.nodes.insert(node.to_owned(), taken.given.clone());
        }
        Some(number)
    }

    fn next_number(
        &self,
        registry: &Registry,
        node: &str,
        spec: &NodeSpec,
        digest: &str,
    ) -> Option<Number> {
        let before = registry.nodes.get(node).cloned();
        // Numbers are given out only where they are sent: a node that is away may come back with newer ones.
        let entry = self.sessions.get(node).filter(|entry| !entry.lost)?;
        let ledger = entry.session.ledger.as_ref();
        let own = ledger.filter(|ledger| ledger.cluster_uid == self.cluster_uid);
        let known = before.is_some() || own.is_some() || entry.session.claim.is_some();
        if !known && spec.systems.is_empty() {
            return None;
        }
        let mut given = before.clone().unwrap_or_default();
        if let Some(ledger) = own.filter(|ledger| ledger.generation > given.generation) {
            // The store wins over a newer ledger: its next number must be above what the agent has seen.
            given.generation = ledger.generation;
            given.digest.clear();
        }
        let epoch = self.epoch();
        if given.digest == digest && given.epoch == epoch {
            return Some(Number::Given(given));
        }
        let floor = registry.floors.get(node).copied().unwrap_or(0);
        given.generation = given.generation.max(floor).saturating_add(1);
        given.epoch = epoch;
        digest.clone_into(&mut given.digest);
        Some(Number::New(Taken { given, before }))
    }

    /// Makes a node's new number durable. Where what the node was told last is not durable either, for want of space, it
    /// is told what takes that back all the same.
    pub(crate) async fn give_number(
        &self,
        node: &str,
        taken: Taken,
    ) -> Result<NodeGeneration, StoreError> {
        let Taken { given, before } = taken;
        let stored = self.store.put_node(node.to_owned(), given.clone()).await;
        let mut registry = self.registry();
        let ahead = registry.ahead.get(node).copied().unwrap_or(0);
        match stored {
            Ok(()) => drop(registry.ahead.remove(node)),
            Err(_) if (1..AHEAD).contains(&ahead) => {
                registry.ahead.insert(node.to_owned(), ahead + 1);
            }
            Err(e) => {
                // It was never sent.
                if registry.nodes.get(node) == Some(&given) {
                    match before {
                        Some(before) => drop(registry.nodes.insert(node.to_owned(), before)),
                        None => drop(registry.nodes.remove(node)),
                    }
                }
                return Err(e);
            }
        }
        Ok(given)
    }

    /// Takes new numbers for all nodes whose specs change with what is desired. They count when the caller says so.
    pub(crate) fn next_numbers(&self, registry: &Registry, placed: &Placement) -> Numbers {
        let digests = placed.digests();
        let number = |(node, spec): (&String, &NodeSpec)| match self.next_number(
            registry,
            node,
            spec,
            digests.get(node)?,
        )? {
            Number::New(taken) => Some((node.clone(), taken.given)),
            Number::Given(_) | Number::Pending => None,
        };
        placed.desired.nodes.iter().filter_map(number).collect()
    }
}

/// What the next numbers of nodes must be above, when what is stored may not be what was given out last.
pub(crate) fn floors(stored: &Numbers) -> BTreeMap<String, u64> {
    let above = |given: &NodeGeneration| given.generation.saturating_add(AHEAD);
    let stored = stored.iter();
    stored
        .map(|(node, given)| (node.clone(), above(given)))
        .collect()
}

/// What makes numbers durable.
pub(crate) fn writes(numbers: &Numbers) -> impl Iterator<Item = Write> + '_ {
    let numbers = numbers.iter();
    numbers.map(|(node, given)| Write::PutNode(node.clone(), given.clone()))
}

impl Registry {
    /// Numbers that count from now on, and may be sent, though they are not durable yet.
    pub(crate) fn number_ahead(&mut self, numbers: &Numbers) {
        for (node, given) in numbers {
            *self.ahead.entry(node.clone()).or_default() += 1;
            self.nodes.insert(node.clone(), given.clone());
        }
    }

    /// Numbers that are durable.
    pub(crate) fn numbered(&mut self, numbers: &Numbers) {
        for (node, given) in numbers {
            self.ahead.remove(node);
            let newer = |own: &NodeGeneration| {
                (own.epoch, own.generation) > (given.epoch, given.generation)
            };
            // The loop may have given out another one since.
            if !self.nodes.get(node).is_some_and(newer) {
                self.nodes.insert(node.clone(), given.clone());
            }
        }
    }
}
