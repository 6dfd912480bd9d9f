//! Processes that stop, and what that means for their contents.

use super::{Decider, Fate, Make, Stop};
use crate::alone::{does_not_answer, ends_unasked};
use crate::index::Seat;
use crate::target;

impl<'a> Decider<'_, 'a> {
    pub(super) fn stop_processes(&mut self) {
        let facts = self.facts;
        for (seat, manager) in facts.processes.iter() {
            let ours = manager.key.system.is_some() && facts.nodes.contains(seat.0);
            let seen = manager.responsive
                || manager.expired.is_some()
                || ends_unasked(facts, self.blocked, seat);
            if !ours || !seen {
                continue;
            }
            let held = || {
                facts.in_seat(seat).iter().any(|live| {
                    self.out.fates[*live] == Fate::Keep && facts.lives[*live].id().is_some()
                })
            };
            let stop = match self.restart(seat) {
                Some(reason) => Stop::Restart(reason),
                None if facts.wanted_seats.contains_key(seat) || held() => continue,
                None => Stop::Unwanted,
            };
            let blocked = target::on(seat.0, &target::manager(seat.1));
            if let Some(why) = self.blocked.get(&blocked) {
                self.out.stuck.insert(*seat, (stop, why.clone()));
                continue;
            }
            self.out.stops.insert(*seat, stop.clone());
            self.end_contents(seat, &stop);
        }
    }

    /// Why a process in which something is desired has to be replaced. A restart is off when the component that asked
    /// for it was held after all.
    fn restart(&self, seat: &Seat<'a>) -> Option<String> {
        let ids = self.facts.wanted_seats.get(seat)?;
        let expired = self.facts.processes.get(seat)?.expired.clone();
        let made = || ids.iter().any(|id| self.out.makes.contains_key(id));
        expired.or_else(|| self.restarts.get(seat).filter(|_| made()).cloned())
    }

    /// True for a process that has to be replaced, as far as that is known, and can be.
    pub(super) fn ends(&self, seat: &Seat<'a>) -> bool {
        self.restart(seat).is_some() && !self.out.stuck.contains_key(seat)
    }

    /// A silent process that does not end after all keeps what it holds, and nothing takes its place.
    pub(super) fn keep_silent(&mut self) {
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
