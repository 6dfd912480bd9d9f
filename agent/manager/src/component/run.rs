//! The thread of an execution context: it runs one or more components in their order, each from its creation to its end.

use std::sync::Arc;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

use rts_manager_api::control::{Failure, FailureCode, RealtimeRequest};

use super::context::WantedRate;
use super::lifecycle::Transition;
use super::member::Member;
use super::spawn::check_rate;
use super::{
    Action, Change, Command, Component, ExecutionContext, Joining, Order, Reply, State, order,
    realtime,
};
use crate::data::Parting;
use crate::failure::{failure, invalid};
use crate::log::Level;
use crate::manager::Manager;
use crate::module::Execution;
use crate::sync::lock;

/// Runs the components of an execution context until the last one is deleted. The first one waits among the orders.
pub fn run(manager: &Manager, context: &ExecutionContext, orders: &Receiver<Order>) {
    let mut runner = Runner {
        manager,
        context,
        members: Vec::new(),
        ran: false,
        next: Instant::now(),
        ended: false,
    };
    realtime::wake_in_time();
    while !runner.ended {
        runner.turn(orders);
    }
}

/// The thread's own view of its execution context.
pub(super) struct Runner<'a> {
    manager: &'a Manager,
    context: &'a ExecutionContext,
    /// In the order in which they run.
    pub(super) members: Vec<Member<'a>>,
    /// One of them took part in cycles when that was last looked at.
    ran: bool,
    /// The next tick.
    next: Instant,
    /// The last of them has left.
    ended: bool,
}

impl<'a> Runner<'a> {
    /// Waits for an order or the next cycle, and carries it out.
    fn turn(&mut self, orders: &Receiver<Order>) {
        let order = self.wait(orders);
        if let Some(order) = &order {
            self.context.taken(order);
        }
        self.attend();
        match order {
            Some(Order::Join(joining)) => self.join(joining),
            Some(Order::Obey(command)) => self.obey(command),
            Some(Order::Attend | Order::Wake) | None => {}
        }
        self.attend();
        self.share_errors();
        if self.is_due() {
            self.cycle();
        }
    }

    fn wait(&self, orders: &Receiver<Order>) -> Option<Order> {
        match self.context.kind {
            Execution::Periodic if self.runs() => {
                let left = self.next.saturating_duration_since(Instant::now());
                orders.recv_timeout(left).ok()
            }
            Execution::EventDriven if self.is_woken() => orders.try_recv().ok(),
            // The execution context itself holds the other end.
            _ => orders.recv().ok(),
        }
    }

    /// Whether one of them takes part in cycles.
    fn runs(&self) -> bool {
        self.members.iter().any(Member::runs)
    }

    fn is_woken(&self) -> bool {
        let mut members = self.members.iter();
        members.any(|member| member.runs() && member.component.is_woken())
    }

    /// Whether it is time for a cycle that nobody asked for by a request. The grid of ticks begins with the first that
    /// runs.
    fn is_due(&mut self) -> bool {
        let runs = self.runs();
        let begins = runs && !std::mem::replace(&mut self.ran, runs);
        if begins {
            self.next = Instant::now();
        }
        runs && match self.context.kind {
            Execution::Periodic => Instant::now() >= self.next,
            Execution::EventDriven => self.is_woken(),
            Execution::External => false,
        }
    }

    fn cycle(&mut self) {
        let start = Instant::now();
        order::cycle(&mut self.members);
        self.share_errors();
        if self.context.kind != Execution::Periodic {
            return;
        }
        let (planned, now) = (self.next, Instant::now());
        let period = period(self.context.rate());
        let late = start.saturating_duration_since(planned);
        for member in &self.members {
            member.keep_time(late, now >= planned + period);
        }
        self.next = next_tick(planned, now, period);
    }

    /// Makes a component, unless who asked has given up.
    fn join(&mut self, joining: Joining) {
        let Joining {
            component,
            rate,
            realtime,
            deadline,
            reply,
        } = joining;
        let made = match Instant::now() >= deadline {
            true => Err(component.late("was busy until the request's deadline")),
            false => self.add(&component, rate, realtime.as_ref()),
        };
        if let Err(failure) = &made {
            component.log.write(Level::Error, &failure.message);
            self.forget(&component);
        }
        let message = match &made {
            Ok(()) => "was initialised after its deadline".to_owned(),
            Err(failure) => format!("was not created: {}", failure.message),
        };
        if reply.send(made).is_err() {
            self.manager.events.changed(component.target(), message);
        }
    }

    fn add(
        &mut self,
        component: &Arc<Component>,
        rate: WantedRate,
        asked: Option<&RealtimeRequest>,
    ) -> Result<(), Failure> {
        if let Some(asked) = asked {
            let others = self.members.iter().map(|member| &*member.component);
            realtime::join(self.manager, component, asked, others)?;
        }
        let _ = self.change_rate(self.context.rate_with(rate), rate.said.is_some(), component);
        let member = Member::start(self.manager, component)?;
        self.members.push(member);
        self.sort();
        Ok(())
    }

    /// Brings them into the order of their places.
    fn sort(&mut self) {
        let context = self.context;
        self.members
            .sort_by_cached_key(|member| context.position(&member.component));
    }

    fn index(&self, component: &Arc<Component>) -> Option<usize> {
        self.members.iter().position(|member| member.is(component))
    }

    /// Acts on the losses of peers. One that is to be stopped for it is deleted.
    fn attend(&mut self) {
        let mut index = 0;
        while let Some(member) = self.members.get_mut(index) {
            let was_active = member.component.state() == State::Active;
            if member.attend() {
                self.remove(index, None);
                continue;
            }
            let component = Arc::clone(&member.component);
            if was_active && component.state() == State::Inactive {
                self.deactivate_others(&component, None);
            }
            index += 1;
        }
    }

    /// Deletes a component, for whoever waits for that or for the loss of a peer.
    fn remove(&mut self, index: usize, reply: Option<Reply>) {
        let member = self.members.remove(index);
        let component = Arc::clone(&member.component);
        member.end(match reply {
            Some(_) => Parting::GoodBye,
            None => Parting::Loss,
        });
        self.forget(&component);
        component.log.write(Level::Info, "deleted");
        let told = match reply.map(|reply| reply.send(Ok(()))) {
            Some(Ok(())) => return,
            Some(Err(_)) => "was deleted after its deadline",
            None => "was deleted after the loss of a peer",
        };
        let events = &self.manager.events;
        events.changed(component.target(), told.to_owned());
    }

    fn forget(&mut self, component: &Arc<Component>) {
        self.manager.remove_component(component);
        self.ended = self.manager.contexts.leave(component);
    }

    /// Carries out one request, unless its sender has given up.
    fn obey(&mut self, command: Command) {
        let Command {
            component,
            action,
            deadline,
            reply,
        } = command;
        let Some(index) = self.index(&component) else {
            let _ = reply.send(Err(component.gone()));
            return;
        };
        if Instant::now() >= deadline {
            // Without an answer its sender might take the component for deleted.
            let late = component.late("was busy until the request's deadline");
            let _ = reply.send(Err(late));
            return;
        }
        let result = match action {
            Action::Activate => self.activate(index),
            Action::Deactivate { by_hand } => self.deactivate(index, by_hand.as_ref()),
            Action::Reset => self.reset(index),
            Action::Tick { cycles } => self.tick(&component, cycles, deadline),
            Action::Configure { change, by_hand } => {
                let done = self.configure(index, &change);
                // What sets nothing that a person may have set leaves the mark.
                if done.is_ok() && (change.sets_values() || by_hand.is_some()) {
                    component.configured_by(by_hand);
                }
                done
            }
            Action::Delete => return self.remove(index, Some(reply)),
        };
        if reply.send(result).is_err() {
            let state = component.state().name();
            let message = format!("is {state}, after its request's deadline");
            self.manager.events.changed(component.target(), message);
        }
    }

    /// Changes values, active set, rate, policy and place in the order. Either all values are taken or none.
    fn configure(&mut self, index: usize, change: &Change) -> Result<(), Failure> {
        change.rate.map_or(Ok(()), check_rate)?;
        let member = &mut self.members[index];
        let any =
            member.set_values(&change.sets, change.active.as_deref(), change.on_disconnect)?;
        let component = Arc::clone(&member.component);
        if let Some(number) = change.order {
            self.context.reorder(&component, number);
            self.sort();
        }
        let own = |member: &&mut Member<'_>| member.is(&component);
        let rate = change
            .rate
            .map_or(Ok(()), |rate| self.change_rate(rate, true, &component));
        let told = match self.members.iter_mut().find(own) {
            Some(member) if any => member.transition(Transition::Configure),
            _ => Ok(()),
        };
        rate.and(told)
    }

    /// Changes the rate for all. The new one holds even when `on_rate_changed` of one fails; that leads to Error, as in
    /// OpenRTM-aist, so that a component which does not run as it should is not taken for one that does. Returns what
    /// became of the one that was asked.
    fn change_rate(
        &mut self,
        rate: f64,
        said: bool,
        asked: &Arc<Component>,
    ) -> Result<(), Failure> {
        let former = self.context.set_rate(rate, said);
        if former == rate {
            return Ok(());
        }
        self.next = self.next.min(Instant::now() + period(rate));
        let mut result = Ok(());
        for member in &mut self.members {
            let line = format!("rate {former} Hz -> {rate} Hz");
            member.component.log.write(Level::Info, &line);
            let told = member.transition(Transition::ChangeRate);
            if member.is(asked) {
                result = told;
            }
        }
        result
    }

    /// Runs cycles for whoever drives it from outside, for as long as the component that is named is Active.
    fn tick(
        &mut self,
        component: &Arc<Component>,
        cycles: u32,
        deadline: Instant,
    ) -> Result<(), Failure> {
        let name = &component.identity.instance;
        let kind = self.context.kind;
        if kind != Execution::External {
            return Err(invalid(format!(
                "{name} is run by {} ({}); only one of the kind {} is ticked",
                self.context.called(),
                kind.name(),
                Execution::External.name()
            )));
        }
        let begun = component.state();
        // The answer is to come before whoever waits for it gives up.
        let left = deadline.saturating_duration_since(Instant::now());
        let last = deadline - (left / 10).min(ANSWER);
        for done in 0..cycles {
            let state = component.state();
            if state != begun || !matches!(state, State::Active | State::Error) {
                return Err(stopped(
                    component,
                    &format!("after {done} of {cycles} cycles"),
                ));
            }
            if done > 0 && Instant::now() >= last {
                let message = format!("{name} ran {done} of {cycles} cycles in time");
                return Err(failure(FailureCode::Deadline, message));
            }
            if done > 0 && self.context.is_asked() {
                let message = format!(
                    "{name} ran {done} of {cycles} cycles, until something else was asked of {}",
                    self.context.called()
                );
                return Err(failure(FailureCode::ComponentFailed, message));
            }
            self.cycle();
            let stops = lock(&component.loss).is_some();
            if stops && done + 1 < cycles {
                let message = format!("{name} lost a peer after {} of {cycles} cycles", done + 1);
                return Err(failure(FailureCode::ComponentFailed, message));
            }
            if !stops {
                self.attend();
            }
        }
        match component.state() {
            State::Active => Ok(()),
            _ => Err(stopped(
                component,
                &format!("after {cycles} of {cycles} cycles"),
            )),
        }
    }
}

/// Time before the deadline of a request at which its answer is given at the latest.
const ANSWER: Duration = Duration::from_millis(200);

/// Says in which state a component is, and why.
fn stopped(component: &Component, when: &str) -> Failure {
    let status = lock(&component.status);
    let reason = status.message.as_ref();
    let reason = reason.map_or(String::new(), |reason| format!(": {reason}"));
    let name = &component.identity.instance;
    let message = format!("{name} is {} {when}{reason}", status.state.name());
    failure(FailureCode::ComponentFailed, message)
}

/// Time between two ticks.
fn period(rate: f64) -> Duration {
    Duration::from_secs_f64(1.0 / rate)
}

/// The tick after `last` that is not over at `now`: missed ones are skipped, and the grid stays as it was.
fn next_tick(last: Instant, now: Instant, period: Duration) -> Instant {
    let next = last + period;
    match now.checked_duration_since(next) {
        None => next,
        Some(behind) => {
            let into = behind.as_nanos() % period.as_nanos().max(1);
            now + period - Duration::from_nanos(u64::try_from(into).unwrap_or(0))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_stay_on_their_grid_and_missed_ones_are_skipped() {
        let ms = Duration::from_millis;
        let start = Instant::now();
        let after = |now| next_tick(start, start + ms(now), ms(10)) - start;
        assert_eq!(after(3), ms(10));
        assert_eq!(after(9), ms(10));
        assert_eq!(after(10), ms(20));
        assert_eq!(after(37), ms(40));
        assert_eq!(after(60_005), ms(60_010));
    }
}
