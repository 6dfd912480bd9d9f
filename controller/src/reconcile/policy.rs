//! `rtsctl.restart: never`: a component whose process ended by itself is not made again until its system changes.
//!
//! `on-failure` starts again like `always`: nothing tells this loop the exit status for certain, and an unknown one
//! counts as a failure.

use std::collections::{BTreeMap, BTreeSet};

use rts_plan::Placed;
use rts_plan::observed::{Inventory, NodeObserved, Observed};
use rts_plan::plan::Blocked;
use rts_plan::target;
use rts_schemas::system::RestartPolicy;

use super::runs::TakenDown;
use crate::core::Core;
use crate::view::Happening;

const REASON: &str = "its process ended and rtsctl.restart is never; apply a change to start it, or tear the system down and apply it";

/// Node, system uid and instance.
type Who = (String, String, String);

/// What was there, and what has ended for good.
#[derive(Debug, Default)]
pub struct Policies {
    /// Component → manager and its incarnation in which it was last seen.
    seen: BTreeMap<Who, (String, String)>,
    /// Component → generation of its system when its process ended.
    ended: BTreeMap<Who, u64>,
}

impl Policies {
    /// These are gone because the loop wanted it.
    pub fn took_down(&mut self, down: Vec<TakenDown>) {
        for gone in down {
            self.seen.retain(|(node, uid, instance), (manager, _)| {
                let here = *node == gone.node && *uid == gone.uid && *manager == gone.manager;
                !(here && gone.instance.as_ref().is_none_or(|i| i == instance))
            });
        }
    }

    /// Compares what is there with what was; systems that are being worked on are left out.
    pub fn look(
        &mut self,
        core: &Core,
        placed: &Placed,
        observed: &Observed,
        busy: &BTreeSet<String>,
    ) {
        let generations: BTreeMap<String, u64> = super::stamps(core)
            .into_iter()
            .map(|(uid, stamp)| (uid, stamp.generation))
            .collect();
        self.ended
            .retain(|(_, uid, _), at| generations.get(uid) == Some(at));
        self.seen
            .retain(|(_, uid, _), _| generations.contains_key(uid));
        for (node, spec) in &placed.desired.nodes {
            let Some(NodeObserved::Known(inventory)) = observed.nodes.get(node) else {
                continue;
            };
            for part in spec
                .systems
                .iter()
                .filter(|p| !busy.contains(&p.system.uid))
            {
                let never = |restart| restart == RestartPolicy::Never;
                for placed in part
                    .components
                    .iter()
                    .filter(|c| never(c.spec.policy.restart))
                {
                    let instance = &placed.spec.instance;
                    let who = (node.clone(), part.system.uid.clone(), instance.clone());
                    if self.has_ended(&who, inventory) {
                        let generation = generations.get(&who.1).copied().unwrap_or(0);
                        self.ended.insert(who, generation);
                        let name = target::component(instance);
                        let event = Happening::warning("NotRestarted", &name, REASON);
                        core.record(event.of(Some(&part.system.name)));
                    }
                }
            }
        }
    }

    /// Targets that are not brought up again.
    pub fn blocked(&self) -> Blocked {
        let ended = self.ended.keys();
        ended
            .map(|(node, _, instance)| {
                let key = target::on(node, &target::component(instance));
                (key, REASON.to_owned())
            })
            .collect()
    }

    /// Remembers where a component is. True when it has gone with the process that it was in.
    fn has_ended(&mut self, who: &Who, inventory: &Inventory) -> bool {
        let found = inventory.managers.iter().find(|manager| {
            let mut own = manager.components.iter();
            own.any(|c| c.instance == who.2 && c.system.as_ref().is_some_and(|s| s.uid == who.1))
        });
        if let Some(manager) = found {
            let place = (manager.key.name.clone(), manager.incarnation.clone());
            self.seen.insert(who.clone(), place);
            return false;
        }
        let gone = self.seen.remove(who);
        gone.is_some_and(|(_, incarnation)| {
            inventory
                .managers
                .iter()
                .all(|m| m.incarnation != incarnation)
        })
    }
}
