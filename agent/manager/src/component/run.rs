//! The execution context: the one thread that runs a component, from its creation to its end.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, SyncSender};
use std::time::{Duration, Instant};

use rts_manager_api::control::{Failure, FailureCode, RealtimeRequest};

use super::instance::{CallFailed, Instance};
use super::lifecycle::Transition;
use super::steps::refusal;
use super::{Action, Command, Component, Order, State, realtime};
use crate::data::Parting;
use crate::failure::{failure, invalid};
use crate::log::Level;
use crate::manager::Manager;
use crate::module::Execution;
use crate::sync::lock;

type Reply = SyncSender<Result<(), Failure>>;

/// Runs a component until it is deleted. Tells `created` when it is initialised, or why not.
pub fn run(
    manager: &Manager,
    component: &Arc<Component>,
    asked: Option<&RealtimeRequest>,
    commands: &Receiver<Order>,
    created: &Reply,
) {
    let prepared = realtime::prepare(manager, component, asked);
    let mut context = match prepared.and_then(|()| Context::start(manager, component)) {
        Ok(context) => context,
        Err(failure) => {
            component.log.write(Level::Error, &failure.message);
            manager.remove_component(component);
            let message = format!("was not created: {}", failure.message);
            if created.send(Err(failure)).is_err() {
                manager.events.changed(component.target(), message);
            }
            return;
        }
    };
    if created.send(Ok(())).is_err() {
        context.changed("was initialised after its deadline");
    }
    let deleted = context.serve(commands);
    context.end(match deleted {
        Some(_) => Parting::GoodBye,
        None => Parting::Loss,
    });
    manager.remove_component(component);
    component.log.write(Level::Info, "deleted");
    let told = match deleted {
        Some(deleted) if deleted.send(Ok(())).is_ok() => return,
        Some(_) => "was deleted after its deadline",
        None => "was deleted after the loss of a peer",
    };
    manager.events.changed(component.target(), told.to_owned());
}

/// The thread's own view of its component.
pub struct Context<'a> {
    /// The manager that holds it.
    pub manager: &'a Manager,
    /// Its visible part.
    pub component: &'a Arc<Component>,
    /// The instance.
    pub instance: Instance,
    /// Between two ticks.
    pub period: Duration,
    /// The next tick.
    pub next: Instant,
}

impl<'a> Context<'a> {
    fn start(manager: &'a Manager, component: &'a Arc<Component>) -> Result<Self, Failure> {
        let named = |e: CallFailed| refusal(component, &e);
        let (configuration, rate) = {
            let status = lock(&component.status);
            (status.configuration.clone(), status.rate)
        };
        let mut instance = Instance::create(component).map_err(named)?;
        for (name, value) in configuration.effective() {
            instance.configure(name, value).map_err(named)?;
        }
        let mut context = Self {
            manager,
            component,
            instance,
            period: period(rate),
            next: Instant::now(),
        };
        context.transition(Transition::Initialize)?;
        if let Err(failure) = context.transition(Transition::StartUp) {
            let _ = context.transition(Transition::Finalize);
            return Err(failure);
        }
        Ok(context)
    }

    /// Obeys requests and executes until it is to be deleted; returns where to report that, or none when the loss of a
    /// peer is why.
    fn serve(&mut self, orders: &Receiver<Order>) -> Option<Reply> {
        loop {
            let order = self.wait(orders);
            if self.attend() {
                return None;
            }
            if let Some(Order::Obey(command)) = order
                && let Some(deleted) = self.obey(command)
            {
                return Some(deleted);
            }
            if self.attend() {
                return None;
            }
            if self.is_due() {
                self.cycle();
            }
        }
    }

    /// Waits for an order, or for the next cycle.
    fn wait(&self, orders: &Receiver<Order>) -> Option<Order> {
        match self.component.execution {
            Execution::Periodic if self.runs() => {
                let left = self.next.saturating_duration_since(Instant::now());
                orders.recv_timeout(left).ok()
            }
            Execution::EventDriven if self.runs() && self.component.is_woken() => {
                orders.try_recv().ok()
            }
            // The component itself holds the other end.
            _ => orders.recv().ok(),
        }
    }

    fn runs(&self) -> bool {
        matches!(self.component.state(), State::Active | State::Error)
    }

    /// Whether it is time for a cycle that nobody asked for by a request.
    fn is_due(&self) -> bool {
        self.runs()
            && match self.component.execution {
                Execution::Periodic => Instant::now() >= self.next,
                Execution::EventDriven => self.component.take_wake(),
                Execution::External => false,
            }
    }

    fn cycle(&mut self) {
        let start = Instant::now();
        let planned = self.next;
        let is_periodic = self.component.execution == Execution::Periodic;
        if self.component.state() == State::Active {
            self.component.executions.fetch_add(1, Ordering::Relaxed);
            // A failure leads to Error, where it is told.
            let _ = self
                .transition(Transition::Execute)
                .and_then(|()| self.transition(Transition::UpdateState));
            let timing = &self.component.timing;
            timing.ran(start.elapsed());
            if is_periodic {
                timing.jitter.add(start.saturating_duration_since(planned));
            }
        } else {
            let _ = self.transition(Transition::Dwell);
        }
        if is_periodic {
            let now = Instant::now();
            if now >= planned + self.period {
                self.component.timing.count_overrun();
            }
            self.next = next_tick(planned, now, self.period);
        }
    }

    /// Runs cycles for whoever drives it from outside.
    fn tick(&mut self, cycles: u32, deadline: Instant) -> Result<(), Failure> {
        let name = &self.component.identity.instance;
        let execution = self.component.execution;
        if execution != Execution::External {
            return Err(invalid(format!(
                "{name} is run by its own execution context ({}); only one of the kind {} is ticked",
                execution.name(),
                Execution::External.name()
            )));
        }
        for done in 0..cycles {
            let state = self.component.state();
            if state != State::Active {
                let message = format!("{name} is {} after {done} of {cycles} cycles", state.name());
                return Err(failure(FailureCode::ComponentFailed, message));
            }
            if Instant::now() >= deadline {
                let message = format!("{name} ran {done} of {cycles} cycles in time");
                return Err(failure(FailureCode::Deadline, message));
            }
            self.cycle();
            let stops = lock(&self.component.loss).is_some();
            if stops && done + 1 < cycles {
                let message = format!("{name} lost a peer after {} of {cycles} cycles", done + 1);
                return Err(failure(FailureCode::ComponentFailed, message));
            }
        }
        match self.component.state() {
            State::Active => Ok(()),
            state => {
                let reason = lock(&self.component.status).message.clone();
                let reason = reason.map_or(String::new(), |reason| format!(": {reason}"));
                let message = format!("{name} went to {}{reason}", state.name());
                Err(failure(FailureCode::ComponentFailed, message))
            }
        }
    }

    /// Carries out one request, unless its sender has given up. Returns the reply's way when it is to be deleted.
    fn obey(&mut self, command: Command) -> Option<Reply> {
        if Instant::now() >= command.deadline {
            // Without an answer its sender might take the component for deleted.
            let late = self.component.late("was busy until the request's deadline");
            let _ = command.reply.send(Err(late));
            return None;
        }
        let result = match command.action {
            Action::Activate => self.activate(),
            Action::Deactivate { by_hand } => self.deactivate(by_hand),
            Action::Reset => self.transition(Transition::Reset),
            Action::Tick { cycles } => self.tick(cycles, command.deadline),
            Action::Configure {
                sets,
                active,
                rate,
                on_disconnect,
                by_hand,
            } => {
                // What sets nothing that a person may have set leaves the mark.
                let sets_values = !sets.is_empty() || active.is_some();
                let done = self.configure(&sets, active.as_deref(), rate, on_disconnect);
                if done.is_ok() && (sets_values || by_hand.is_some()) {
                    self.component.configured_by(by_hand);
                }
                done
            }
            Action::Delete => return Some(command.reply),
        };
        if command.reply.send(result).is_err() {
            let state = self.component.state().name();
            self.changed(&format!("is {state}, after its request's deadline"));
        }
        None
    }

    /// Takes the component down. What fails on the way is logged and goes on.
    fn end(mut self, parting: Parting) {
        // A failing on_deactivated leads to Error, which is as good a state to finalise from.
        let _ = self.transition(Transition::Deactivate);
        self.manager.detach(self.component, parting);
        let _ = self.transition(Transition::ShutDown);
        let _ = self.transition(Transition::Finalize);
    }
}

/// Time between two ticks.
pub fn period(rate: f64) -> Duration {
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
