//! Decides the fate of everything that is there, and what has to be made, before any step is written.
//!
//! Three rules stand behind it: what already is as desired is never touched; nothing is taken down whose replacement
//! cannot be tried now (it is *held*); what cannot be seen is not acted upon.

mod obstacle;
mod processes;

use std::collections::BTreeSet;

use rustc_hash::FxHashMap;

use crate::alone::{claims, ends_unasked, first_fate, moved};
use crate::index::{Facts, Id, Seat, Want};
use crate::observed::ManagerObserved;
use crate::order::{Standing, made, making, visit};
use crate::place::{Context, recreate_hash};
use crate::plan::Blocked;
use crate::table::Table;
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
    pub stops: Table<Seat<'a>, Stop>,
    /// Desired components that have an instance which stays, as desired or held.
    pub present: Table<Id<'a>, usize>,
    /// Desired components to create.
    pub makes: Table<Id<'a>, Make>,
    /// Desired components that cannot be brought to their desired state now, and why.
    pub waits: Table<Id<'a>, String>,
    /// Desired components that are seen nowhere, and of which nobody can say that they are not there: a process of their
    /// system that stays has not said what it holds, or another node may still run them. They wait.
    pub unseen: BTreeSet<Id<'a>>,
    /// Processes that have to stop and cannot be stopped now, and why not.
    pub stuck: Table<Seat<'a>, (Stop, String)>,
}

/// Desired components that go all the same, since a peer is lost (`onDisconnect: stop`), and why.
pub(crate) type Doomed<'a> = Table<Id<'a>, String>;

/// Decides.
pub(crate) fn decide<'a>(
    facts: &Facts<'a>,
    blocked: &Blocked,
    doomed: &Doomed<'a>,
) -> Decisions<'a> {
    let expired = |(seat, manager): (&Seat<'a>, &&ManagerObserved)| {
        let why = manager.expired.as_ref()?;
        ends_unasked(facts, blocked, seat).then(|| (*seat, why.clone()))
    };
    let mut decider = Decider {
        facts,
        blocked,
        doomed,
        claims: claims(facts),
        restarts: facts.processes.iter().filter_map(expired).collect(),
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
    decider.dependants();
    decider.stop_processes();
    decider.keep_silent();
    decider.names();
    decider.dependants();
    decider.out
}

struct Decider<'f, 'a> {
    facts: &'f Facts<'a>,
    blocked: &'f Blocked,
    doomed: &'f Doomed<'a>,
    claims: FxHashMap<(&'a str, &'a str), Id<'a>>,
    /// Processes that something asks to be replaced, and why.
    restarts: Table<Seat<'a>, String>,
    out: Decisions<'a>,
}

impl<'a> Decider<'_, 'a> {
    fn want(&mut self, want: &Want<'a>) {
        let id = want.id();
        if let Some(why) = self.doomed.get(&id) {
            self.out.waits.insert(id, why.clone());
            return;
        }
        let instances = self.facts.instances(id);
        let here = instances
            .iter()
            .copied()
            .find(|live| self.facts.lives[*live].seat() == want.seat());
        if let Some(problem) = self.out_of_sight(want, instances) {
            if self.may_hold(want).is_some() || self.may_run_elsewhere(want).is_some() {
                self.out.unseen.insert(id);
            }
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
        let old = Some(live);
        if component.type_name != spec.type_name {
            let (from, to) = (&component.type_name, &spec.type_name);
            let reason = format!("type changed from {from} to {to}");
            return self.make(want, Make { old, reason });
        }
        let reason = match (component.stand_in, want.placed.stand_in.is_some()) {
            (false, false) => None,
            (false, true) => Some("a stand-in takes its place"),
            (true, false) => Some("it takes the place of its stand-in"),
            (true, true) => Some("its stand-in changed"),
        };
        if let Some(reason) = reason.map(str::to_owned) {
            return self.make(want, Make { old, reason });
        }
        let found = Context::found(component);
        let same_module = recreate_hash(
            &component.type_name,
            want.placed.module_digest.as_deref(),
            &want.placed.manager,
            &found,
            None,
        ) == component.recreate_hash;
        if same_module {
            let reason = found.changed(&Context::of(spec, false));
            return self.make(want, Make { old, reason });
        }
        let reason = format!("the module file of {} changed", spec.type_name);
        self.replace_process(want, Make { old, reason });
    }

    /// Leaves whatever there is of a component alone, unless its process stops anyway.
    fn hold(&mut self, id: Id<'a>, problem: String) {
        self.out.makes.remove(&id);
        self.out.waits.insert(id, problem);
        for &live in self.facts.instances(id) {
            if !self.out.stops.contains_key(&self.facts.lives[live].seat()) {
                self.out.fates[live] = Fate::Keep;
                self.out.present.or_insert_with(id, || live);
            }
        }
    }

    fn make(&mut self, want: &Want<'a>, make: Make) {
        if self.has_old_code(want) {
            return self.replace_process(want, make);
        }
        self.make_there(want, make);
    }

    fn make_there(&mut self, want: &Want<'a>, make: Make) {
        match self.obstacle(want) {
            Some(problem) => self.hold(want.id(), problem),
            None => {
                self.out.makes.insert(want.id(), make);
            }
        }
    }

    /// True when its process has opened another file for its type: for a component that is gone, or that never came up.
    fn has_old_code(&self, want: &Want<'a>) -> bool {
        let process = self.facts.processes.get(&want.seat());
        let opened = process.and_then(|m| m.opened.get(&want.placed.spec.type_name));
        let wanted = want.placed.module_digest.as_ref();
        matches!((opened, wanted), (Some(opened), Some(wanted)) if opened != wanted)
    }

    /// A module stays mapped in its process, so that a new file needs a new process.
    fn replace_process(&mut self, want: &Want<'a>, make: Make) {
        let manager = target::manager(want.key);
        if let Some(why) = self.blocked.get(&target::on(want.node, &manager)) {
            return self.hold(want.id(), format!("{manager} is blocked: {why}"));
        }
        self.make_there(want, make);
        if self.out.makes.contains_key(&want.id()) {
            let reason = format!("the module file of {} changed", want.placed.spec.type_name);
            self.restarts.or_insert_with(want.seat(), || reason);
        }
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

    /// What cannot be created because something else cannot be.
    fn dependants(&mut self) {
        loop {
            let before = self.out.makes.len();
            self.orphans();
            self.start_up_orders();
            if self.facts.leans.is_empty() || self.out.makes.len() == before {
                return;
            }
        }
    }

    /// With `onDisconnect: stop` a component is not created while a peer cannot be. It starts from what cannot be
    /// created for another reason, so that two that need each other never wait for each other.
    fn orphans(&mut self) {
        let facts = self.facts;
        let peers = facts.leans.keys().copied();
        let mut open: Vec<Id<'a>> = peers.filter(|id| self.absent(id)).collect();
        while let Some(peer) = open.pop() {
            for (id, _) in facts.leans.get(&peer).into_iter().flatten() {
                if !self.out.makes.contains_key(id) {
                    continue;
                }
                let name = peer.instance;
                let why = format!("waits for its peer {name}: rtsctl.onDisconnect is stop");
                self.hold(*id, why);
                if self.absent(id) {
                    open.push(*id);
                }
            }
        }
    }

    /// True for a desired component that will not be there.
    fn absent(&self, id: &Id<'a>) -> bool {
        !self.out.makes.contains_key(id) && !self.out.present.contains_key(id)
    }

    /// StartUp and Initializing orders: what needs a component that cannot be created cannot be created either, unless
    /// that one is optional.
    fn start_up_orders(&mut self) {
        let facts = self.facts;
        for (uid, members) in &facts.members {
            let Some(system) = facts.orders.get(uid) else {
                continue;
            };
            let lists = making(system.orders);
            if lists.iter().all(|(_, list)| list.is_empty()) {
                continue;
            }
            // What it has to say is said with the steps.
            visit(facts, members, &lists, |id, gate| {
                if let (Some(problem), true) = (gate.waits, self.out.makes.contains_key(&id)) {
                    self.hold(id, problem);
                }
                let present = self.out.present.get(&id);
                match present.map(|live| &self.facts.lives[*live]) {
                    Some(live) if self.ends(&live.seat()) => Standing::Done,
                    Some(live) => made(live),
                    None if self.out.waits.contains_key(&id) => Standing::Waits,
                    None => Standing::Done,
                }
            });
        }
    }
}
