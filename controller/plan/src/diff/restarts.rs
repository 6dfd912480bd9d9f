//! Whom a restart interrupts: the process, what is in it, and who is connected with that.

use std::collections::{BTreeMap, BTreeSet};

use crate::alone::made_by_hand;
use crate::decide::{Decisions, Fate, Stop};
use crate::index::{Facts, Live, Seat};
use crate::plan::{Affected, Restart};

/// Processes and components that are interrupted though they go on to exist.
pub(crate) fn restarts<'a>(facts: &Facts<'a>, decisions: &Decisions<'a>) -> Vec<Restart> {
    let mut again: BTreeMap<Seat<'a>, (Vec<String>, String)> = BTreeMap::new();
    for (seat, stop) in decisions.stops.iter() {
        if let Stop::Restart(reason) = stop {
            again.insert(*seat, (Vec::new(), reason.clone()));
        }
    }
    for (id, make) in decisions.makes.iter() {
        let Some(live) = make.old.map(|old| &facts.lives[old]) else {
            continue;
        };
        let entry = again.entry(live.seat());
        let (components, _) = entry.or_insert_with(|| (Vec::new(), make.reason.clone()));
        components.push(id.instance.to_owned());
    }
    if again.is_empty() {
        return Vec::new();
    }
    let mut blasts = Blasts::new(facts, decisions, again.keys().copied().collect());
    let restart = |(seat, (components, reason))| told(facts, decisions, seat, components, reason);
    let mut restarts: Vec<Restart> = again.into_iter().map(restart).collect();
    for (ix, restart) in restarts.iter_mut().enumerate() {
        let blast = std::mem::take(&mut blasts.found[ix]);
        restart.connectors = blast.connectors.into_iter().map(str::to_owned).collect();
        restart.affected = blast.affected.into_values().collect();
    }
    restarts
}

fn told<'a>(
    facts: &Facts<'a>,
    decisions: &Decisions<'a>,
    seat: Seat<'a>,
    mut components: Vec<String>,
    mut reason: String,
) -> Restart {
    let stops = decisions.stops.contains_key(&seat);
    let by_hand = made_by_hand(facts, &seat);
    if stops && !by_hand.is_empty() {
        let names = by_hand.iter().copied().collect::<Vec<_>>().join(", ");
        reason = format!("{reason}; made by hand and lost with it: {names}");
    }
    components.sort();
    let ends = |ix: &&usize| stops || decisions.fates[**ix] == Fate::Gone;
    let ended = facts.in_seat(&seat).iter().filter(ends);
    let names: BTreeSet<&str> = ended
        .map(|ix| facts.lives[*ix].component.instance.as_str())
        .collect();
    let also = names.into_iter().filter(|name| {
        let again = components.iter().any(|known| known == name);
        !again && !by_hand.contains(name)
    });
    Restart {
        also_stopped: also.map(str::to_owned).collect(),
        connectors: Vec::new(),
        affected: Vec::new(),
        node: seat.0.to_owned(),
        manager: seat.1.display_name(),
        pid: stops.then(|| facts.processes[&seat].pid),
        components,
        reason,
    }
}

/// What a restart means to connectors and peers.
#[derive(Default)]
struct Blast<'a> {
    connectors: BTreeSet<&'a str>,
    affected: BTreeMap<usize, Affected>,
}

/// The blasts of all restarts, in one walk over the connectors.
struct Blasts<'f, 'a> {
    facts: &'f Facts<'a>,
    decisions: &'f Decisions<'a>,
    /// Components that end → the restart that ends them.
    ends: BTreeMap<usize, usize>,
    found: Vec<Blast<'a>>,
}

impl<'f, 'a> Blasts<'f, 'a> {
    fn new(facts: &'f Facts<'a>, decisions: &'f Decisions<'a>, seats: Vec<Seat<'a>>) -> Self {
        let mut blasts = Self {
            facts,
            decisions,
            ends: BTreeMap::new(),
            found: seats.iter().map(|_| Blast::default()).collect(),
        };
        let mut names = BTreeSet::new();
        for (number, seat) in seats.iter().enumerate() {
            for ix in facts.in_seat(seat) {
                if blasts.is_gone(*ix) {
                    blasts.ends.insert(*ix, number);
                    names.insert(facts.lives[*ix].component.instance.as_str());
                }
            }
        }
        for (source, live) in facts.lives.iter().enumerate() {
            let from = blasts.ends.get(&source).copied();
            for connector in &live.component.connectors {
                // Most connectors are far from it all: looking each target up would cost more than the plan.
                if from.is_none() && !names.contains(connector.target.instance.as_str()) {
                    continue;
                }
                let target = connector.target_incarnation.as_str();
                let target = facts.by_incarnation.get(target).copied();
                let to = target.and_then(|ix| blasts.ends.get(&ix).copied());
                for number in from.into_iter().chain(to) {
                    blasts.found[number].connectors.insert(&connector.name);
                }
                if let (Some(number), Some(peer)) = (from, target) {
                    blasts.peer(number, peer, true);
                }
                if let Some(number) = to {
                    blasts.peer(number, source, false);
                }
            }
        }
        blasts
    }

    fn is_gone(&self, ix: usize) -> bool {
        let stops = &self.decisions.stops;
        self.decisions.fates[ix] == Fate::Gone || stops.contains_key(&self.facts.lives[ix].seat())
    }

    /// A component at the other end; one that ends itself is told elsewhere.
    fn peer(&mut self, number: usize, peer: usize, starved: bool) {
        if self.is_gone(peer) {
            return;
        }
        let affected = &mut self.found[number].affected;
        let entry = affected.entry(peer);
        let known = entry.or_insert_with(|| affected_of(&self.facts.lives[peer]));
        known.starved |= starved;
    }
}

fn affected_of(live: &Live<'_>) -> Affected {
    Affected {
        instance: live.component.instance.clone(),
        node: live.node.to_owned(),
        manager: live.manager.key.display_name(),
        starved: false,
    }
}
