//! In which order Create, Reset and Activate are done.

use super::Bringer;
use crate::graph::{Gate, Preference};
use crate::index::Id;
use crate::order::{Standing, made, making, visit};
use crate::plan::OrderName;

impl<'a> Bringer<'_, '_, 'a> {
    /// StartUp and Initializing order Create, Resetting orders Reset, Activation orders Activate.
    pub(super) fn orders(&mut self) {
        let facts = self.facts;
        for (uid, members) in &facts.members {
            let Some(system) = facts.orders.get(uid) else {
                continue;
            };
            let orders = system.orders;
            let making = making(orders);
            let resetting = [(OrderName::Resetting, orders.resetting.as_slice())];
            let activation = [(OrderName::Activation, orders.activation.as_slice())];
            let notes = [
                visit(facts, members, &making, |id, gate| {
                    self.create_order(id, gate)
                }),
                visit(facts, members, &resetting, |id, gate| self.reset(id, gate)),
                visit(facts, members, &activation, |id, gate| {
                    self.activate(id, gate)
                }),
            ];
            self.up.notes.extend(notes.into_iter().flatten());
        }
    }

    /// Who must wait for good was decided before.
    fn create_order(&mut self, id: Id<'a>, gate: Gate) -> Standing {
        if let Some(&create) = self.creates.get(&id) {
            self.steps.gate(create, gate);
            return Standing::Steps(vec![create]);
        }
        match self.decisions.present.get(&id) {
            Some(live) => made(&self.facts.lives[*live]),
            None => Standing::Waits,
        }
    }

    /// Where the profile is silent: what a source feeds is asked to start before the source, and who provides a service
    /// before who calls it.
    pub(super) fn prefer(&mut self) {
        if self.up.activates.is_empty() {
            return;
        }
        for link in self.facts.links.values() {
            let Some((first, why)) = Preference::of(&link.connector.spec) else {
                continue;
            };
            let ends = link.ends.map(|id| self.up.activates.get(&id).copied());
            if let (Some(first), Some(then)) = (ends[first], ends[1 - first]) {
                self.steps.prefer(then, first, why);
            }
        }
    }
}
