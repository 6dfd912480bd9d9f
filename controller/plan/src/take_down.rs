//! Steps that take down: Deactivate, Disconnect, Delete, UnloadModule, StopManager.

use std::collections::{BTreeMap, BTreeSet};

use rts_schemas::system::Condition;

use crate::alone::made_by_hand;
use crate::decide::{Decisions, Fate, Stop};
use crate::graph::{Ix, NewStep, Steps};
use crate::index::{Facts, Live, Seat, SystemOrders};
use crate::links::Links;
use crate::observed::LifeCycleState;
use crate::order::{Order, Standing};
use crate::plan::{Blocked, Work};
use crate::target;

/// Steps after which something is gone.
#[derive(Debug, Default)]
pub(crate) struct Down<'a> {
    /// Live component → the step after which it is gone.
    pub gone: BTreeMap<usize, Ix>,
    /// Process → its StopManager.
    pub stopped: BTreeMap<Seat<'a>, Ix>,
    /// System uid and connector → its Disconnect.
    pub cut: BTreeMap<(&'a str, &'a str), Ix>,
    /// Live components that are to go, in a process that stays, and are blocked; and why.
    pub stuck: BTreeMap<usize, String>,
    /// Connectors that are to go and are blocked, and why.
    pub stuck_cuts: BTreeMap<(&'a str, &'a str), String>,
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
    taker.processes();
    taker.connectors(links);
    taker.modules();
    taker.orders();
    taker.prefer_up_stream_first();
    taker.down
}

type BySystem<'a> = BTreeMap<&'a str, Vec<Ix>>;

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
            if !live.manager.responsive {
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

    fn processes(&mut self) {
        for (seat, stop) in &self.decisions.stops {
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
                target: target::manager(&seat.1),
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
            self.down.stopped.insert(seat.clone(), step);
        }
    }

    fn connectors(&mut self, links: &Links<'a>) {
        for (key, cut) in &links.cuts {
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
                // The end of a silent process waits for nobody.
                let silent = !self.facts.lives[target].manager.responsive;
                if let Some(&gone) = self.down.gone.get(&target).filter(|_| !silent) {
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
            let name = target::module(type_name, &seat.1);
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
        });
        let wanted = self.facts.wanted_seats.get(seat).into_iter().flatten();
        stays
            || wanted
                .map(|id| &self.facts.wants[id].placed.spec.type_name)
                .any(|wanted| wanted == type_name)
    }

    fn orders(&mut self) {
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
    fn prefer_up_stream_first(&mut self) {
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
