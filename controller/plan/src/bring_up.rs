//! Steps that bring up: Install, StartManager, LoadModule, Create, Configure, Reset, Connect, Activate.

mod activate;
mod orders;

use std::collections::BTreeMap;

use rts_schemas::system::Configuration;

use crate::alone::may_be_in;
use crate::decide::{Decisions, Make};
use crate::graph::{Ix, NewStep, Steps};
use crate::in_place::{InPlace, in_place};
use crate::index::{Facts, Id, Seat, Want};
use crate::links::Links;
use crate::plan::{Blocked, Work};
use crate::table::Table;
use crate::take_down::Down;
use crate::target;

/// What the steps are, for the changes that are shown.
#[derive(Debug, Default)]
pub(crate) struct Up<'a> {
    /// Processes that start.
    pub starts: Table<Seat<'a>, Ix>,
    /// Components that change in place.
    pub in_place: Table<Id<'a>, InPlace>,
    /// Components that are reset.
    pub resets: Table<Id<'a>, Ix>,
    /// Components that are activated.
    pub activates: Table<Id<'a>, Ix>,
    /// Components that cannot become Active now, and why.
    pub waits: Table<Id<'a>, String>,
    /// Optional components that nobody waits for.
    pub notes: Vec<String>,
}

/// Adds the steps.
pub(crate) fn add<'a>(
    facts: &Facts<'a>,
    decisions: &Decisions<'a>,
    links: &Links<'a>,
    down: &Down<'a>,
    blocked: &Blocked,
    steps: &mut Steps,
) -> Up<'a> {
    let mut bringer = Bringer {
        facts,
        decisions,
        links,
        down,
        blocked,
        steps,
        installs: BTreeMap::new(),
        loads: BTreeMap::new(),
        creates: Table::default(),
        configures: Table::default(),
        connects: Table::default(),
        up: Up {
            waits: decisions.waits.clone(),
            ..Up::default()
        },
    };
    for (id, make) in decisions.makes.iter() {
        bringer.create(*id, make);
    }
    for (id, live) in decisions.present.iter() {
        bringer.change_in_place(*id, *live);
    }
    bringer.connect();
    bringer.orders();
    bringer.prefer();
    bringer.up
}

struct Bringer<'s, 'f, 'a> {
    facts: &'f Facts<'a>,
    decisions: &'f Decisions<'a>,
    links: &'f Links<'a>,
    down: &'f Down<'a>,
    blocked: &'f Blocked,
    steps: &'s mut Steps,
    /// Each system installs for itself, so that no step of one waits for another.
    installs: BTreeMap<(&'a str, &'a str, &'a str, Option<&'a str>), Ix>,
    loads: BTreeMap<(Seat<'a>, &'a str), Ix>,
    creates: Table<Id<'a>, Ix>,
    configures: Table<Id<'a>, Ix>,
    /// Connect steps at either end of a component.
    connects: Table<Id<'a>, Vec<Ix>>,
    up: Up<'a>,
}

impl<'a> Bringer<'_, '_, 'a> {
    fn create(&mut self, id: Id<'a>, make: &Make) {
        let want = &self.facts.wants[&id];
        let spec = &want.placed.spec;
        let before = match want.placed.stand_in {
            // Its manager makes it by itself.
            Some(_) => self.process(want),
            None => self.module(want),
        };
        let create = self.steps.add(NewStep {
            node: want.node,
            target: target::component(&spec.instance),
            system: Some(want.system),
            work: Work::Create {
                manager: want.key.clone(),
                instance: spec.instance.clone(),
                type_name: spec.type_name.clone(),
                recreate_hash: want.placed.recreate_hash.clone(),
                configuration: spec.configuration.clone(),
                execution_kind: spec.execution_context.kind,
                rate: spec.execution_context.rate,
                execution_context: spec.execution_context.shared(),
                on_disconnect: spec.policy.on_disconnect,
                stand_in: want.placed.stand_in.clone(),
                realtime: want.placed.realtime(),
            },
            reason: make.reason.clone(),
        });
        self.steps.need(create, before);
        // Never two of one name on a node, never two of one identity anywhere.
        let stopped = self.down.stopped.get(&want.seat());
        let others = self.facts.by_name.get(&(want.node, id.instance));
        let own = self.facts.instances(id);
        for live in others.into_iter().flatten().chain(own) {
            let implied = stopped.is_some() && self.facts.lives[*live].seat() == want.seat();
            if let Some(&gone) = self.down.gone.get(live).filter(|_| !implied) {
                self.steps.need(create, [gone]);
            }
        }
        for (seat, manager) in &self.facts.unseen {
            // It may be in one that goes, or another of its name.
            let own = own.is_empty() && may_be_in(want, manager);
            let concerns = (own || seat.0 == want.node) && *seat != want.seat();
            let stopped = self.down.stopped.get(seat).filter(|_| concerns);
            self.steps.need(create, stopped.copied());
        }
        self.creates.insert(id, create);
    }

    /// The step that starts a component's process, if it does not run.
    fn process(&mut self, want: &Want<'a>) -> Option<Ix> {
        let seat = want.seat();
        let runs = self.facts.processes.contains_key(&seat);
        let stays = runs && !self.decisions.stops.contains_key(&seat);
        (!stays).then(|| self.start(&seat))
    }

    /// The last step that makes a type available in a component's process, if any is needed.
    fn module(&mut self, want: &Want<'a>) -> Option<Ix> {
        let seat = want.seat();
        let stays = !self.decisions.stops.contains_key(&seat);
        let process = self.facts.processes.get(&seat).filter(|_| stays);
        let type_name = want.placed.spec.type_name.as_str();
        if process.is_some_and(|manager| manager.modules.contains(type_name)) {
            return None;
        }
        if let Some(&load) = self.loads.get(&(seat, type_name)) {
            return Some(load);
        }
        let start = process.is_none().then(|| self.start(&seat));
        let install = self.install(want);
        let load = self.steps.add(NewStep {
            node: want.node,
            target: target::module(type_name, want.key),
            system: Some(want.system),
            work: Work::LoadModule {
                manager: want.key.clone(),
                type_name: type_name.to_owned(),
                module_digest: want.placed.module_digest.clone(),
            },
            reason: format!("{} needs it", want.placed.spec.instance),
        });
        self.steps.need(load, start.into_iter().chain([install]));
        self.loads.insert((seat, type_name), load);
        Some(load)
    }

    fn start(&mut self, seat: &Seat<'a>) -> Ix {
        if let Some(&start) = self.up.starts.get(seat) {
            return start;
        }
        let stop = self.down.stopped.get(seat).copied();
        let reason = match stop {
            Some(_) => "starts again",
            None => "is not running",
        };
        let start = self.steps.add(NewStep {
            node: seat.0,
            target: target::manager(seat.1),
            system: seat.1.system.as_ref(),
            work: Work::StartManager {
                manager: seat.1.clone(),
            },
            reason: reason.to_owned(),
        });
        self.steps.need(start, stop);
        self.up.starts.insert(*seat, start);
        start
    }

    fn install(&mut self, want: &Want<'a>) -> Ix {
        let type_name = want.placed.spec.type_name.as_str();
        let digest = want.placed.module_digest.as_deref();
        let steps = &mut *self.steps;
        let install = self
            .installs
            .entry((&want.system.uid, want.node, type_name, digest));
        *install.or_insert_with(|| {
            steps.add(NewStep {
                node: want.node,
                target: target::package(type_name, want.node),
                system: Some(want.system),
                work: Work::Install {
                    type_name: type_name.to_owned(),
                    module_digest: digest.map(str::to_owned),
                },
                reason: format!("{} needs it", want.placed.spec.instance),
            })
        })
    }

    fn change_in_place(&mut self, id: Id<'a>, live: usize) {
        let want = &self.facts.wants[&id];
        let live = &self.facts.lives[live];
        if self.decisions.waits.contains_key(&id) {
            return;
        }
        let Some(change) = in_place(want.placed, live.component) else {
            return;
        };
        let target = target::component(id.instance);
        if let Some(why) = self.blocked.get(&target::on(want.node, &target)) {
            self.up.waits.insert(id, why.clone());
            return;
        }
        let configure = self.steps.add(NewStep {
            node: want.node,
            target,
            system: Some(want.system),
            work: Work::Configure {
                manager: want.key.clone(),
                instance: id.instance.to_owned(),
                configuration: Configuration::clone(&change.configuration),
                rate: change.rate,
                on_disconnect: change.on_disconnect,
                order: change.order,
            },
            reason: change.reason.clone(),
        });
        self.configures.insert(id, configure);
        self.up.in_place.insert(id, change);
    }

    fn connect(&mut self) {
        for (key, join) in self.links.joins.iter() {
            let connector = join.connector;
            let step = self.steps.add(NewStep {
                node: &connector.source.node,
                target: target::connector(&connector.spec.name),
                system: Some(join.system),
                work: Work::Connect {
                    connector: connector.clone(),
                },
                reason: join.reason.clone(),
            });
            self.steps.need(step, self.down.cut.get(key).copied());
            let ends = self.down.unbound.get(key).into_iter().flatten();
            self.steps.need(step, ends.copied());
            for id in self.facts.links[key].ends {
                self.steps.need(step, self.creates.get(&id).copied());
                self.connects.or_default(id).push(step);
            }
        }
    }
}
