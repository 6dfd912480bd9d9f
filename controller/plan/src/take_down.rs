//! Steps that take down: Deactivate, Disconnect, Delete, UnloadModule, StopManager, Unbind.

mod bindings;
mod orders;

use std::collections::BTreeMap;

pub(crate) use self::bindings::LeftEnd;
use crate::alone::made_by_hand;
use crate::decide::{Decisions, Fate, Stop};
use crate::graph::{Ix, NewStep, Steps};
use crate::index::{Facts, Id, LinkId, Live, Seat};
use crate::links::Links;
use crate::observed::LifeCycleState;
use crate::peers::acting;
use crate::plan::{Blocked, Work};
use crate::table::Table;
use crate::target;

/// Steps after which something is gone.
#[derive(Debug, Default)]
pub(crate) struct Down<'a> {
    /// Live component → the step after which it is gone.
    pub gone: BTreeMap<usize, Ix>,
    /// Components that stay and are deactivated for want of a connector.
    pub idled: Table<Id<'a>, Ix>,
    /// Process → its StopManager.
    pub stopped: Table<Seat<'a>, Ix>,
    /// System uid and connector → its Disconnect.
    pub cut: Table<LinkId<'a>, Ix>,
    /// Live components that are to go, in a process that stays, and are blocked; and why.
    pub stuck: BTreeMap<usize, String>,
    /// Connectors that are to go and are blocked, and why.
    pub stuck_cuts: Table<LinkId<'a>, String>,
    /// In-port ends that nobody wants.
    pub left_ends: Vec<LeftEnd<'a>>,
    /// System uid and connector → the Unbinds of its ends.
    pub unbound: Table<LinkId<'a>, Vec<Ix>>,
}

/// Adds the steps.
pub(crate) fn add<'a>(
    facts: &Facts<'a>,
    decisions: &Decisions<'a>,
    links: &Links<'a>,
    blocked: &Blocked,
    steps: &mut Steps,
) -> Down<'a> {
    let mut taker = Taker {
        facts,
        decisions,
        blocked,
        steps,
        deactivates: BTreeMap::new(),
        deletes: BTreeMap::new(),
        down: Down::default(),
    };
    taker.components();
    taker.idle(links);
    taker.processes();
    taker.connectors(links);
    taker.bindings();
    taker.modules();
    taker.orders();
    taker.prefer();
    taker.down
}

struct Taker<'s, 'f, 'a> {
    facts: &'f Facts<'a>,
    decisions: &'f Decisions<'a>,
    blocked: &'f Blocked,
    steps: &'s mut Steps,
    deactivates: BTreeMap<usize, Ix>,
    deletes: BTreeMap<usize, Ix>,
    down: Down<'a>,
}

impl<'a> Taker<'_, '_, 'a> {
    fn reason(&self, live: &Live<'a>) -> String {
        let id = live.id();
        let make = id.and_then(|id| self.decisions.makes.get(&id));
        if let Some(make) = make {
            return make.reason.clone();
        }
        let stays = !self.decisions.stops.contains_key(&live.seat());
        let why = id.and_then(|id| self.decisions.waits.get(&id));
        if let Some(why) = why.filter(|_| stays) {
            return why.clone();
        }
        if id.is_some_and(|id| self.facts.wants.contains_key(&id)) {
            return "is not wanted here".to_owned();
        }
        "is not wanted any more".to_owned()
    }

    fn components(&mut self) {
        for (ix, live) in self.facts.lives.iter().enumerate() {
            if self.decisions.fates[ix] == Fate::Keep || live.id().is_none() {
                continue;
            }
            if self.ends_unasked(live) {
                // Nobody would answer: the end of its process ends it.
                continue;
            }
            let instance = &live.component.instance;
            let target = target::component(instance);
            if let Some(why) = self.blocked.get(&target::on(live.node, &target)) {
                // It does not let itself be deactivated or deleted: the end of its process, or a later try, ends it.
                if !self.decisions.stops.contains_key(&live.seat()) {
                    self.down.stuck.insert(ix, why.clone());
                }
                continue;
            }
            let new = |work| NewStep {
                node: live.node,
                target: target.clone(),
                system: live.component.system.as_ref(),
                work,
                reason: self.reason(live),
            };
            let deactivate = (live.component.state == LifeCycleState::Active).then(|| {
                new(Work::Deactivate {
                    manager: live.manager.key.clone(),
                    instance: instance.clone(),
                })
            });
            let delete = new(Work::Delete {
                manager: live.manager.key.clone(),
                instance: instance.clone(),
            });
            let delete = self.steps.add(delete);
            if let Some(deactivate) = deactivate {
                let deactivate = self.steps.add(deactivate);
                self.steps.need(delete, [deactivate]);
                self.deactivates.insert(ix, deactivate);
            }
            self.deletes.insert(ix, delete);
            self.down.gone.insert(ix, delete);
        }
    }

    /// True when nothing is asked of a component that goes: its process does not answer, or is replaced for hanging.
    fn ends_unasked(&self, live: &Live<'a>) -> bool {
        let replaced = live.manager.expired.is_some();
        !live.manager.responsive || (replaced && self.decisions.stops.contains_key(&live.seat()))
    }

    /// Components that stay, and must not be Active without a connector that cannot be made now.
    fn idle(&mut self, links: &Links<'a>) {
        let certain = links.idle.iter().filter(|(_, idle)| idle.certain);
        for (id, idle) in certain {
            let Some((ix, live)) = acting(self.facts, self.decisions, self.blocked, id) else {
                continue;
            };
            let step = self.steps.add(NewStep {
                node: live.node,
                target: target::component(id.instance),
                system: live.component.system.as_ref(),
                work: Work::Deactivate {
                    manager: live.manager.key.clone(),
                    instance: id.instance.to_owned(),
                },
                reason: idle.reason.clone(),
            });
            self.deactivates.insert(ix, step);
            self.down.idled.insert(*id, step);
        }
    }

    fn processes(&mut self) {
        for (seat, stop) in self.decisions.stops.iter() {
            let manager = self.facts.processes[seat];
            let mut reason = match stop {
                Stop::Unwanted => "nothing is wanted in it any more".to_owned(),
                Stop::Restart(reason) => format!("restarts: {reason}"),
            };
            let by_hand = made_by_hand(self.facts, seat);
            if !by_hand.is_empty() {
                let names = by_hand.into_iter().collect::<Vec<_>>().join(", ");
                reason = format!("{reason}; made by hand and lost with it: {names}");
            }
            let step = self.steps.add(NewStep {
                node: seat.0,
                target: target::manager(seat.1),
                system: seat.1.system.as_ref(),
                work: Work::StopManager {
                    manager: seat.1.clone(),
                    incarnation: manager.incarnation.clone(),
                },
                reason,
            });
            for live in self.facts.in_seat(seat) {
                match self.down.gone.get(live) {
                    Some(&delete) => self.steps.need(step, [delete]),
                    None => drop(self.down.gone.insert(*live, step)),
                }
            }
            self.down.stopped.insert(*seat, step);
        }
    }

    fn connectors(&mut self, links: &Links<'a>) {
        for (key, cut) in links.cuts.iter() {
            let live = &self.facts.lives[cut.source];
            let name = target::connector(&cut.connector.name);
            let blocked = self.blocked.get(&target::on(live.node, &name));
            if let (Some(why), None) = (blocked, cut.dying_target) {
                self.down.stuck_cuts.insert(*key, why.clone());
                continue;
            }
            let step = self.steps.add(NewStep {
                node: live.node,
                target: name,
                system: live.component.system.as_ref(),
                work: Work::Disconnect {
                    manager: live.manager.key.clone(),
                    instance: live.component.instance.clone(),
                    connector: cut.connector.name.clone(),
                },
                reason: cut.reason.clone(),
            });
            if let Some(target) = cut.dying_target {
                self.steps
                    .need(step, self.deactivates.get(&target).copied());
                // Such an end waits for nobody.
                let unasked = self.ends_unasked(&self.facts.lives[target]);
                if let Some(&gone) = self.down.gone.get(&target).filter(|_| !unasked) {
                    self.steps.need(gone, [step]);
                }
            }
            self.down.cut.insert(*key, step);
        }
    }

    /// A module whose last component goes, in a process that stays.
    fn modules(&mut self) {
        let mut dying: BTreeMap<(Seat<'a>, &'a str), Vec<usize>> = BTreeMap::new();
        for &ix in self.deletes.keys() {
            let live = &self.facts.lives[ix];
            if !self.decisions.stops.contains_key(&live.seat()) {
                let key = (live.seat(), live.component.type_name.as_str());
                dying.entry(key).or_default().push(ix);
            }
        }
        for ((seat, type_name), lives) in dying {
            let loaded = self.facts.processes[&seat].modules.contains(type_name);
            let name = target::module(type_name, seat.1);
            let blocked = self.blocked.contains_key(&target::on(seat.0, &name));
            if !loaded || blocked || self.module_used(&seat, type_name) {
                continue;
            }
            let step = self.steps.add(NewStep {
                node: seat.0,
                target: name,
                system: seat.1.system.as_ref(),
                work: Work::UnloadModule {
                    manager: seat.1.clone(),
                    type_name: type_name.to_owned(),
                },
                reason: "its last component goes".to_owned(),
            });
            for live in lives {
                self.steps.need(step, self.deletes.get(&live).copied());
            }
        }
    }

    fn module_used(&self, seat: &Seat<'a>, type_name: &str) -> bool {
        let stays = self.facts.in_seat(seat).iter().any(|live| {
            (self.decisions.fates[*live] == Fate::Keep || self.down.stuck.contains_key(live))
                && self.facts.lives[*live].component.type_name == type_name
                && !self.facts.lives[*live].component.stand_in
        });
        let wanted = self.facts.wanted_seats.get(seat).into_iter().flatten();
        stays
            || wanted
                .map(|id| self.facts.wants[id].placed)
                .any(|wanted| wanted.stand_in.is_none() && wanted.spec.type_name == type_name)
    }
}
