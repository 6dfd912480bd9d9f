//! In which order Deactivate and Delete are done.

use std::collections::{BTreeMap, BTreeSet};

use super::Taker;
use crate::graph::{Ix, Preference};
use crate::index::SystemOrders;
use crate::order::{List, Order, Standing, deleting, members};
use crate::plan::OrderName;

type BySystem<'a> = BTreeMap<&'a str, Vec<Ix>>;

impl<'a> Taker<'_, '_, 'a> {
    pub(super) fn orders(&mut self) {
        let deactivates = self.by_system(&self.deactivates);
        let deletes = self.by_system(&self.deletes);
        for (uid, SystemOrders { orders }) in &self.facts.orders {
            if let Some(steps) = deactivates.get(uid) {
                let list = (OrderName::Deactivation, orders.deactivation.as_slice());
                self.order(uid, &[list], steps);
            }
            if let Some(steps) = deletes.get(uid) {
                self.order(uid, &deleting(orders), steps);
            }
        }
    }

    /// System uid → instance → its steps.
    fn by_system(&self, steps: &BTreeMap<usize, Ix>) -> BTreeMap<&'a str, BySystem<'a>> {
        let mut by_system: BTreeMap<&'a str, BySystem<'a>> = BTreeMap::new();
        for (live, step) in steps {
            if let Some(id) = self.facts.lives[*live].id() {
                let system = by_system.entry(id.uid).or_default();
                system.entry(id.instance).or_default().push(*step);
            }
        }
        by_system
    }

    /// Orders steps. A cycle must not keep anything alive: what closes it is left out.
    fn order(&mut self, uid: &'a str, lists: &[List<'a>], of: &BySystem<'a>) {
        if lists.iter().all(|(_, list)| list.is_empty()) {
            return;
        }
        let members = members(self.facts, uid, of.keys().copied());
        Order::new(lists, members).walk(|instance, gate| {
            for step in &of[instance] {
                self.steps.gate(*step, gate.clone());
            }
            Standing::Steps(of[instance].clone())
        });
    }

    /// Where the profile is silent, a source is asked to stop before what it feeds, and who calls a service before who
    /// provides it.
    pub(super) fn prefer(&mut self) {
        for (&source, &first) in &self.deactivates {
            let live = &self.facts.lives[source];
            let connectors = live.component.connectors.iter();
            let targets: BTreeSet<&str> =
                connectors.map(|c| c.target_incarnation.as_str()).collect();
            for target in targets {
                let target = self.facts.by_incarnation.get(target);
                if let Some(&then) = target.and_then(|live| self.deactivates.get(live)) {
                    self.steps.prefer(then, first, Preference::DataFlow);
                }
            }
        }
        if !self.deactivates.is_empty() {
            self.prefer_as_desired();
        }
    }

    /// A connector that is wanted counts too, whether or not it is there: services are not observed, and another may be
    /// broken for a moment.
    fn prefer_as_desired(&mut self) {
        for link in self.facts.links.values() {
            let Some((last, why)) = Preference::of(&link.connector.spec) else {
                continue;
            };
            let of = |id| {
                let lives = self.facts.instances(id).iter();
                lives.filter_map(|live| self.deactivates.get(live).copied())
            };
            for then in of(link.ends[last]) {
                for first in of(link.ends[1 - last]) {
                    self.steps.prefer(then, first, why);
                }
            }
        }
    }
}
