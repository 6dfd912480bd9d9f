//! In which order Deactivate and Delete are done.

use std::collections::{BTreeMap, BTreeSet};

use super::Taker;
use crate::graph::{Ix, Preference};
use crate::index::SystemOrders;
use crate::order::{List, Member, Order, Standing, deleting};
use crate::plan::OrderName;

type BySystem<'a> = BTreeMap<&'a str, Vec<Ix>>;

impl<'a> Taker<'_, '_, 'a> {
    pub(super) fn orders(&mut self) {
        let deactivates = self.by_system(&self.deactivates);
        let deletes = self.by_system(&self.deletes);
        for (uid, SystemOrders { orders }) in &self.facts.orders {
            if let Some(steps) = deactivates.get(uid) {
                let list = (OrderName::Deactivation, orders.deactivation.as_slice());
                self.order(&[list], steps);
            }
            if let Some(steps) = deletes.get(uid) {
                self.order(&deleting(orders), steps);
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

    /// Orders steps. No order keeps anything alive: of a cycle is left out what closes it, and who comes after a component
    /// waits for the end of its steps, whether they succeed or not.
    fn order(&mut self, lists: &[List<'a>], of: &BySystem<'a>) {
        if lists.iter().all(|(_, list)| list.is_empty()) {
            return;
        }
        let members = of.keys().map(|name| Member {
            name,
            required: false,
        });
        Order::new(lists, members).walk(|instance, gate| {
            let own = &of[instance];
            let given_up = own.iter().any(|step| self.steps.needs_any(*step));
            for step in own {
                self.steps.gate(*step, gate.clone());
            }
            match given_up {
                true => Standing::Steps(own.clone()),
                false => Standing::Certain(own.clone()),
            }
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
