//! In which order Create, Reset and Activate are done.

use super::Bringer;
use crate::graph::{Gate, Preference};
use crate::index::{Id, ends};
use crate::order::{Order, Standing, making, members};
use crate::plan::OrderName;

impl<'a> Bringer<'_, '_, 'a> {
    /// StartUp and Initializing order Create, Resetting orders Reset, Activation orders Activate.
    pub(super) fn orders(&mut self) {
        let facts = self.facts;
        for (uid, names) in facts.members() {
            let Some(system) = facts.orders.get(uid) else {
                continue;
            };
            let orders = system.orders;
            let members = || members(facts, uid, names.iter().copied());
            let order = Order::new(&making(orders), members());
            let over = order.walk(|instance, gate| self.create_order(Id { uid, instance }, gate));
            self.up.notes.extend(order.tell(&over));
            let list = (OrderName::Resetting, orders.resetting.as_slice());
            let order = Order::new(&[list], members());
            let over = order.walk(|instance, gate| self.reset(Id { uid, instance }, gate));
            self.up.notes.extend(order.tell(&over));
            let list = (OrderName::Activation, orders.activation.as_slice());
            let order = Order::new(&[list], members());
            let over = order.walk(|instance, gate| self.activate(Id { uid, instance }, gate));
            self.up.notes.extend(order.tell(&over));
        }
    }

    /// Who must wait for good was decided before.
    fn create_order(&mut self, id: Id<'a>, gate: Gate) -> Standing {
        if let Some(&create) = self.creates.get(&id) {
            self.steps.gate(create, gate);
            return Standing::Steps(vec![create]);
        }
        match self.decisions.present.contains_key(&id) {
            true => Standing::Done,
            false => Standing::Waits,
        }
    }

    /// Where the profile is silent: what a source feeds is asked to start before the source, and who provides a service
    /// before who calls it.
    pub(super) fn prefer(&mut self) {
        for ((uid, _), (_, connector)) in &self.facts.links {
            let Some((first, why)) = Preference::of(&connector.spec) else {
                continue;
            };
            let ends = ends(uid, connector).map(|id| self.up.activates.get(&id).copied());
            if let (Some(first), Some(then)) = (ends[first], ends[1 - first]) {
                self.steps.prefer(then, first, why);
            }
        }
    }
}
