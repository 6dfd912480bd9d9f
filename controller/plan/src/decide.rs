//! Decides the fate of everything that is there, and what has to be made, before any step is written.
//!
//! Three rules stand behind it: what already is as desired is never touched; nothing is taken down whose replacement
//! cannot be tried now (it is *held*); what cannot be seen is not acted upon.

use std::collections::{BTreeMap, BTreeSet};

use crate::alone::{claims, does_not_answer, ends_silent, first_fate, moved};
use crate::index::{Facts, Id, Seat, Want};
use crate::order::{Order, Standing};
use crate::place::recreate_hash;
use crate::plan::Blocked;
use crate::target;

/// What becomes of an observed component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fate {
    /// Stays as it is.
    Keep,
    /// Is taken down.
    Gone,
}

/// Why a process is stopped.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Stop {
    /// Nothing is desired in it.
    Unwanted,
    /// It starts again.
    Restart(String),
}

/// A component that has to be created.
#[derive(Debug, Clone)]
pub(crate) struct Make {
    /// Its old instance, when there is one.
    pub old: Option<usize>,
    /// Why.
    pub reason: String,
}

/// All decisions.
#[derive(Debug, Default)]
pub(crate) struct Decisions<'a> {
    /// One for each of `Facts::lives`.
    pub fates: Vec<Fate>,
    /// Processes to stop.
    pub stops: BTreeMap<Seat<'a>, Stop>,
    /// Desired components that have an instance which stays, as desired or held.
    pub present: BTreeMap<Id<'a>, usize>,
    /// Desired components to create.
    pub makes: BTreeMap<Id<'a>, Make>,
    /// Desired components that cannot be brought to their desired state now, and why.
    pub waits: BTreeMap<Id<'a>, String>,
    /// Processes in which nothing is desired and that cannot be stopped now, and why.
    pub stuck: BTreeMap<Seat<'a>, String>,
}

/// Decides.
pub(crate) fn decide<'a>(facts: &Facts<'a>, blocked: &Blocked) -> Decisions<'a> {
    let mut decider = Decider {
        facts,
        blocked,
        claims: claims(facts),
        restarts: BTreeMap::new(),
        out: Decisions {
            fates: facts
                .lives
                .iter()
                .map(|live| first_fate(facts, blocked, live))
                .collect(),
            ..Decisions::default()
        },
    };
    for want in facts.wants.values() {
        decider.want(want);
    }
    decider.start_up_orders();
    decider.stop_processes();
    decider.keep_silent();
    decider.names();
    decider.start_up_orders();
    decider.out
}

struct Decider<'f, 'a> {
    facts: &'f Facts<'a>,
    blocked: &'f Blocked,
    claims: BTreeMap<(&'a str, &'a str), Id<'a>>,
    restarts: BTreeMap<Seat<'a>, String>,
    out: Decisions<'a>,
}

impl<'a> Decider<'_, 'a> {
    fn want(&mut self, want: &Want<'a>) {
        let id = want.id();
        let instances = self.facts.instances(id);
        let here = instances
            .iter()
            .copied()
            .find(|live| self.facts.lives[*live].seat() == want.seat());
        if let Some(problem) = self.out_of_sight(want, instances) {
            return self.hold(id, problem);
        }
        let Some(live) = here else {
            let old = instances.first().copied();
            let reason = old.map_or("is not there yet".to_owned(), |live| {
                moved(&self.facts.lives[live], want)
            });
            return self.make(want, Make { old, reason });
        };
        let component = self.facts.lives[live].component;
        if component.recreate_hash == want.placed.recreate_hash {
            self.out.fates[live] = Fate::Keep;
            self.out.present.insert(id, live);
            return;
        }
        self.remake(want, live);
    }

    /// The instance in the right place was made with another hash.
    fn remake(&mut self, want: &Want<'a>, live: usize) {
        let component = self.facts.lives[live].component;
        let spec = &want.placed.spec;
        let kind = spec.execution_context.kind;
        let old = Some(live);
        if component.type_name != spec.type_name {
            let (from, to) = (&component.type_name, &spec.type_name);
            let reason = format!("type changed from {from} to {to}");
            return self.make(want, Make { old, reason });
        }
        let same_module = recreate_hash(
            &component.type_name,
            want.placed.module_digest.as_deref(),
            &want.placed.manager,
            component.execution_kind,
        ) == component.recreate_hash;
        if same_module {
            let from = component.execution_kind;
            let reason = format!("execution kind changed from {from:?} to {kind:?}");
            return self.make(want, Make { old, reason });
        }
        // A module stays mapped in its process, so that a new file needs a new process.
        let manager = target::manager(&want.key);
        if let Some(why) = self.blocked.get(&target::on(want.node, &manager)) {
            return self.hold(want.id(), format!("{manager} is blocked: {why}"));
        }
        let reason = format!("the module file of {} changed", spec.type_name);
        self.make(
            want,
            Make {
                old,
                reason: reason.clone(),
            },
        );
        if self.out.makes.contains_key(&want.id()) {
            self.restarts.entry(want.seat()).or_insert(reason);
        }
    }

    /// Why nothing may be planned for a component: something of it cannot be seen.
    fn out_of_sight(&self, want: &Want<'a>, instances: &[usize]) -> Option<String> {
        if let Some(reason) = self.facts.unknown.get(want.node) {
            return Some(format!("node {} is unknown: {reason}", want.node));
        }
        let here = self.facts.processes.get(&want.seat()).copied();
        let there = instances.iter().map(|live| &self.facts.lives[*live]);
        let there = there
            .filter(|live| !ends_silent(self.facts, self.blocked, &live.seat()))
            .map(|live| live.manager);
        let silent = here.into_iter().chain(there).find(|m| !m.responsive)?;
        Some(does_not_answer(silent))
    }

    /// Leaves whatever there is of a component alone, unless its process stops anyway.
    fn hold(&mut self, id: Id<'a>, problem: String) {
        self.out.makes.remove(&id);
        self.out.waits.insert(id, problem);
        for &live in self.facts.instances(id) {
            if !self.out.stops.contains_key(&self.facts.lives[live].seat()) {
                self.out.fates[live] = Fate::Keep;
                self.out.present.entry(id).or_insert(live);
            }
        }
    }

    fn make(&mut self, want: &Want<'a>, make: Make) {
        match self.obstacle(want) {
            Some(problem) => self.hold(want.id(), problem),
            None => {
                self.out.makes.insert(want.id(), make);
            }
        }
    }

    /// Why a component cannot be created now.
    fn obstacle(&self, want: &Want<'a>) -> Option<String> {
        let process = self.facts.processes.get(&want.seat());
        let restarts = self.restarts.contains_key(&want.seat());
        let process = process.filter(|_| !restarts);
        let type_name = &want.placed.spec.type_name;
        let loaded = process.is_some_and(|m| m.modules.contains(type_name));
        let own = target::component(&want.placed.spec.instance);
        let old = self.facts.instances(want.id()).iter();
        // An instance that does not let itself be taken down blocks the next one, wherever it is.
        let old: BTreeSet<&str> = old.map(|live| self.facts.lives[*live].node).collect();
        let old = old
            .into_iter()
            .find_map(|node| self.blocked.get(&target::on(node, &own)));
        if let Some(why) = old {
            return Some(why.clone());
        }
        let mut targets = vec![own];
        if process.is_none() {
            targets.push(target::manager(&want.key));
        }
        if !loaded {
            targets.push(target::package(type_name, want.node));
            targets.push(target::module(type_name, &want.key));
        }
        let blocked = targets.into_iter().enumerate().find_map(|(nr, target)| {
            let why = self.blocked.get(&target::on(want.node, &target))?;
            let own = nr == 0;
            Some(if own {
                why.clone()
            } else {
                format!("{target} is blocked: {why}")
            })
        });
        blocked.or_else(|| self.name_taken(want))
    }

    fn name_taken(&self, want: &Want<'a>) -> Option<String> {
        let id = want.id();
        let name = (want.node, id.instance);
        let claim = self.claims.get(&name).filter(|claim| **claim != id);
        if let Some(other) = claim.and_then(|claim| self.facts.wants.get(claim)) {
            let (system, node) = (&other.system.name, want.node);
            return Some(format!(
                "system {system} has a component of this name on node {node}"
            ));
        }
        let others = self.facts.by_name.get(&name)?;
        others.iter().find_map(|live| {
            let live = &self.facts.lives[*live];
            let manager = live.manager.key.display_name();
            let ends = live.manager.responsive
                || ends_silent(self.facts, self.blocked, &live.seat());
            if !ends {
                return Some(format!(
                    "manager {manager} has a component of this name and does not answer"
                ));
            }
            let by_hand = live.component.system.is_none();
            let stays = live.manager.key.system.is_none()
                || self.facts.wanted_seats.contains_key(&live.seat());
            (by_hand && stays).then(|| {
                format!(
                    "a component of this name was made by hand in manager {manager}: delete it first"
                )
            })
        })
    }

    /// Last look: whatever the reason why a namesake stays, no second one is made.
    fn names(&mut self) {
        let facts = self.facts;
        let taken = |id: &&Id<'a>| {
            let name = (facts.wants[*id].node, id.instance);
            let lives = facts.by_name.get(&name).into_iter().flatten();
            lives
                .copied()
                .any(|live| self.out.fates[live] == Fate::Keep)
        };
        let taken: Vec<_> = self.out.makes.keys().filter(taken).copied().collect();
        for id in taken {
            let node = facts.wants[&id].node;
            self.hold(
                id,
                format!("another component of this name stays on node {node}"),
            );
        }
    }

    /// StartUp and Initializing orders: what needs a component that cannot be created cannot be created either.
    fn start_up_orders(&mut self) {
        for (uid, members) in self.facts.members() {
            let Some(system) = self.facts.orders.get(uid) else {
                continue;
            };
            let lists = [
                system.orders.start_up.as_slice(),
                system.orders.initializing.as_slice(),
            ];
            if lists.iter().all(|list| list.is_empty()) {
                continue;
            }
            Order::new("StartUp", &lists, members).walk(|instance, gate| {
                let id = Id { uid, instance };
                if let (Some(problem), true) = (gate.waits, self.out.makes.contains_key(&id)) {
                    self.hold(id, problem);
                }
                let absent =
                    self.out.waits.contains_key(&id) && !self.out.present.contains_key(&id);
                if absent {
                    Standing::Waits
                } else {
                    Standing::Done
                }
            });
        }
    }

    fn stop_processes(&mut self) {
        let facts = self.facts;
        for (seat, manager) in &facts.processes {
            let ours = manager.key.system.is_some() && facts.nodes.contains(seat.0);
            let seen = manager.responsive || ends_silent(facts, self.blocked, seat);
            if !ours || !seen {
                continue;
            }
            let held = || {
                facts.in_seat(seat).iter().any(|live| {
                    self.out.fates[*live] == Fate::Keep && facts.lives[*live].id().is_some()
                })
            };
            // A restart is off when the component that asked for it was held after all.
            let restart = self.restarts.get(seat).filter(|_| {
                let ids = facts.wanted_seats.get(seat);
                ids.is_some_and(|ids| ids.iter().any(|id| self.out.makes.contains_key(id)))
            });
            let stop = match restart {
                Some(reason) => Stop::Restart(reason.clone()),
                None if facts.wanted_seats.contains_key(seat) || held() => continue,
                None => Stop::Unwanted,
            };
            let blocked = target::on(seat.0, &target::manager(&seat.1));
            if let Some(why) = self.blocked.get(&blocked) {
                self.out.stuck.insert(seat.clone(), why.clone());
                continue;
            }
            self.out.stops.insert(seat.clone(), stop.clone());
            self.end_contents(seat, &stop);
        }
    }

    /// A silent process that does not end after all keeps what it holds, and nothing takes its place.
    fn keep_silent(&mut self) {
        for (ix, live) in self.facts.lives.iter().enumerate() {
            if live.manager.responsive || self.out.stops.contains_key(&live.seat()) {
                continue;
            }
            self.out.fates[ix] = Fate::Keep;
            let id = live.id().filter(|id| self.out.makes.contains_key(id));
            if let Some(id) = id {
                self.hold(id, does_not_answer(live.manager));
            }
        }
    }

    /// Everything in a process that stops is made again, if it is desired and can be.
    fn end_contents(&mut self, seat: &Seat<'a>, stop: &Stop) {
        for &live in self.facts.in_seat(seat) {
            self.out.fates[live] = Fate::Gone;
            let Some(id) = self.facts.lives[live].id() else {
                continue;
            };
            if self.out.present.get(&id) != Some(&live) {
                continue;
            }
            self.out.present.remove(&id);
            if let (Stop::Restart(reason), false) = (stop, self.out.waits.contains_key(&id)) {
                let make = Make {
                    old: Some(live),
                    reason: format!("its process restarts: {reason}"),
                };
                self.out.makes.insert(id, make);
            }
        }
        // The new process starts without modules: what was no obstacle before may be one now.
        for id in self.facts.wanted_seats.get(seat).into_iter().flatten() {
            if !self.out.makes.contains_key(id) {
                continue;
            }
            if let Some(problem) = self.obstacle(&self.facts.wants[id]) {
                self.hold(*id, problem);
            }
        }
    }
}
