//! What stands in the way of a component.

use std::collections::BTreeSet;

use super::Decider;
use crate::alone::{does_not_answer, ends_unasked, has_not_said, may_be_in};
use crate::index::Want;
use crate::observed::ManagerObserved;
use crate::target;

impl<'a> Decider<'_, 'a> {
    /// Why nothing may be planned for a component: something of it cannot be seen.
    pub(super) fn out_of_sight(&self, want: &Want<'a>, instances: &[usize]) -> Option<String> {
        if let Some(reason) = self.facts.unknown.get(want.node) {
            return Some(format!("node {} is unknown: {reason}", want.node));
        }
        if let Some(unseen) = self.may_hold(want) {
            return Some(has_not_said(unseen));
        }
        if let Some(node) = self.may_run_elsewhere(want) {
            return Some(format!(
                "may still run on {node}, where only a controller can ask"
            ));
        }
        let seat = want.seat();
        let here = self.facts.processes.get(&seat).copied();
        let here = here.filter(|_| !ends_unasked(self.facts, self.blocked, &seat));
        let there = instances.iter().map(|live| &self.facts.lives[*live]);
        let there = there
            .filter(|live| !ends_unasked(self.facts, self.blocked, &live.seat()))
            .map(|live| live.manager);
        let silent = here.into_iter().chain(there).find(|m| !m.responsive)?;
        Some(does_not_answer(silent))
    }

    /// A process that stays and may hold a component that is seen nowhere.
    pub(super) fn may_hold(&self, want: &Want<'a>) -> Option<&'a ManagerObserved> {
        let mut unseen = self.facts.unseen.iter();
        let found = unseen.find(|(seat, manager)| {
            may_be_in(want, manager) && !ends_unasked(self.facts, self.blocked, seat)
        });
        let found = found.filter(|_| self.facts.instances(want.id()).is_empty());
        found.map(|(_, manager)| *manager)
    }

    /// The node where a component may still run that is seen nowhere here.
    pub(super) fn may_run_elsewhere(&self, want: &Want<'a>) -> Option<&'a str> {
        let node = self.facts.may_run.get(&want.id()).copied();
        node.filter(|_| self.facts.instances(want.id()).is_empty())
    }

    /// Why a component cannot be created now.
    pub(super) fn obstacle(&self, want: &Want<'a>) -> Option<String> {
        if let Some(why) = self.facts.held(want) {
            return Some(why.to_owned());
        }
        if self.blocked.is_empty() {
            return self.name_taken(want);
        }
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
            targets.push(target::manager(want.key));
        }
        if !loaded && want.placed.stand_in.is_none() {
            targets.push(target::package(type_name, want.node));
            targets.push(target::module(type_name, want.key));
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
                || ends_unasked(self.facts, self.blocked, &live.seat());
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
}
