//! In which order Deactivate and Delete are done.

use std::collections::{BTreeMap, BTreeSet};

use rts_schemas::system::Condition;

use super::Taker;
use crate::graph::Ix;
use crate::index::SystemOrders;
use crate::order::{Order, Standing};

type BySystem<'a> = BTreeMap<&'a str, Vec<Ix>>;

impl<'a> Taker<'_, '_, 'a> {
    pub(super) fn orders(&mut self) {
        let deactivates = self.by_system(&self.deactivates);
        let deletes = self.by_system(&self.deletes);
        for (uid, SystemOrders { orders }) in &self.facts.orders {
            if let Some(steps) = deactivates.get(uid) {
                self.order("Deactivation", &[&orders.deactivation], steps);
            }
            if let Some(steps) = deletes.get(uid) {
                self.order("ShutDown", &[&orders.shut_down, &orders.finalizing], steps);
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
    fn order(&mut self, name: &'a str, lists: &[&'a [Condition]], of: &BySystem<'a>) {
        if lists.iter().all(|list| list.is_empty()) {
            return;
        }
        Order::new(name, lists, of.keys().copied()).walk(|instance, gate| {
            for step in &of[instance] {
                self.steps.gate(*step, gate.clone());
            }
            Standing::Steps(of[instance].clone())
        });
    }

    /// Where the profile is silent, a source is asked to stop before what it feeds.
    pub(super) fn prefer_up_stream_first(&mut self) {
        for (&source, &first) in &self.deactivates {
            let live = &self.facts.lives[source];
            let targets: BTreeSet<&str> = live
                .component
                .connectors
                .iter()
                .map(|c| c.target_incarnation.as_str())
                .collect();
            for target in targets {
                let target = self.facts.by_incarnation.get(target);
                if let Some(&then) = target.and_then(|live| self.deactivates.get(live)) {
                    self.steps.prefer(then, first);
                }
            }
        }
    }
}
