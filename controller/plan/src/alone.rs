//! What can be said of one component or process by itself, before anything is decided about the whole.

use std::collections::BTreeSet;

use rustc_hash::FxHashMap;

use crate::decide::Fate;
use crate::index::{Facts, Id, Live, Seat, Want};
use crate::observed::{ConnectorState, ManagerObserved};
use crate::plan::Blocked;
use crate::target;

/// Fate of a component by itself; instances of desired components are looked at one by one later.
pub(crate) fn first_fate<'a>(facts: &Facts<'a>, blocked: &Blocked, live: &Live<'a>) -> Fate {
    let told = facts.nodes.contains(live.node);
    let ours = live
        .id()
        .is_some_and(|id| told || facts.wants.contains_key(&id));
    let ends = live.manager.responsive || ends_unasked(facts, blocked, &live.seat());
    if ours && ends { Fate::Gone } else { Fate::Keep }
}

/// True for a process that ends without a word to its components: one that does not answer and in which nothing is
/// desired, or one that has to be replaced.
pub(crate) fn ends_unasked<'a>(facts: &Facts<'a>, blocked: &Blocked, seat: &Seat<'a>) -> bool {
    let silent = |m: &&&ManagerObserved| !m.responsive && !facts.wanted_seats.contains_key(seat);
    let process = facts.processes.get(seat);
    let unasked = process.is_some_and(|m| m.expired.is_some() || silent(&m));
    let ours = seat.1.system.is_some() && facts.nodes.contains(seat.0);
    let blocked = || blocked.contains_key(&target::on(seat.0, &target::manager(seat.1)));
    unasked && ours && !blocked()
}

pub(crate) fn does_not_answer(manager: &ManagerObserved) -> String {
    let (name, pid) = (manager.key.display_name(), manager.pid);
    format!("manager {name} (pid {pid}) does not answer")
}

pub(crate) fn has_not_said(manager: &ManagerObserved) -> String {
    let name = manager.key.display_name();
    format!("manager {name} has not said what it holds")
}

/// True when a component that is seen nowhere may be in a process that has not said what it holds: it is of its system,
/// since that is all that is known.
pub(crate) fn may_be_in(want: &Want<'_>, unseen: &ManagerObserved) -> bool {
    let system = unseen.key.system.as_ref();
    system.is_some_and(|system| system.name == want.system.name)
}

/// Who may have an instance name on a node: one that is there already, else the first.
pub(crate) fn claims<'a>(facts: &Facts<'a>) -> FxHashMap<(&'a str, &'a str), Id<'a>> {
    let mut claims: FxHashMap<(&'a str, &'a str), Id<'a>> = FxHashMap::default();
    for (id, want) in facts.wants.iter() {
        let claim = claims.entry((want.node, id.instance)).or_insert(*id);
        if facts.instances(*claim).is_empty() && !facts.instances(*id).is_empty() {
            *claim = *id;
        }
    }
    claims
}

pub(crate) fn moved(live: &Live<'_>, want: &Want<'_>) -> String {
    if live.node == want.node {
        let (from, to) = (&live.manager.key.name, &want.key.name);
        format!("moved from manager {from} to {to}")
    } else {
        format!("moved from node {} to {}", live.node, want.node)
    }
}

/// Components that someone must be told about because they end with a process, though nobody asked for it.
pub(crate) fn made_by_hand<'a>(facts: &Facts<'a>, seat: &Seat<'a>) -> BTreeSet<&'a str> {
    let lives = facts.in_seat(seat).iter().map(|live| facts.lives[*live]);
    lives
        .filter(|live| live.component.system.is_none())
        .map(|live| live.component.instance.as_str())
        .collect()
}

/// Notes on the connectors from components that a person made to components of a system: no plan touches them.
pub(crate) fn feeds_by_hand(facts: &Facts<'_>, fates: &[Fate]) -> Vec<String> {
    let mut notes = Vec::new();
    let hand_made = facts.lives.iter().filter(|l| l.component.system.is_none());
    for connector in hand_made.flat_map(|live| &live.component.connectors) {
        let target = connector.target_incarnation.as_str();
        let target = facts.by_incarnation.get(target).copied();
        let stays = target.filter(|live| fates[*live] == Fate::Keep);
        let system = stays.and_then(|live| facts.lives[live].component.system.as_ref());
        let lost = connector.state == ConnectorState::Disconnected;
        if let Some(system) = system.filter(|_| !lost) {
            notes.push(format!(
                "connector {} from {}, made by hand, feeds {} of system {}: it is left alone",
                connector.name, connector.source, connector.target, system.name
            ));
        }
    }
    notes
}
