//! The execution context: the one thread that runs a component, from its creation to its end.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender};
use std::time::{Duration, Instant};

use rts_manager_api::control::{Failure, FailureCode};
use rts_runtime::abi::{callback, return_code};

use super::configuration::Sets;
use super::instance::{CallFailed, Instance};
use super::lifecycle::{Transition, Verdict, verdict};
use super::spawn::check_rate;
use super::{Action, Command, Component, State};
use crate::failure::{failure, invalid};
use crate::log::Level;
use crate::manager::Manager;
use crate::sync::lock;

type Reply = SyncSender<Result<(), Failure>>;

/// Runs a component until it is deleted. Tells `created` when it is initialised, or why not.
pub fn run(
    manager: &Manager,
    component: &Arc<Component>,
    commands: &Receiver<Command>,
    created: &Reply,
) {
    let mut context = match Context::start(manager, component) {
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
    context.end();
    manager.remove_component(component);
    component.log.write(Level::Info, "deleted");
    if deleted.send(Ok(())).is_err() {
        manager.events.changed(
            component.target(),
            "was deleted after its deadline".to_owned(),
        );
    }
}

struct Context<'a> {
    manager: &'a Manager,
    component: &'a Arc<Component>,
    instance: Instance,
    period: Duration,
    next: Instant,
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
        if let Err(error) = context.instance.callback(callback::STARTUP) {
            let _ = context.transition(Transition::Finalize);
            return Err(named(error));
        }
        Ok(context)
    }

    /// Obeys requests and executes until it is to be deleted; returns where to report that.
    fn serve(&mut self, commands: &Receiver<Command>) -> Reply {
        loop {
            let command = if self.ticks() {
                commands.recv_timeout(self.next.saturating_duration_since(Instant::now()))
            } else {
                commands.recv().map_err(RecvTimeoutError::from)
            };
            if let Ok(command) = command
                && let Some(deleted) = self.obey(command)
            {
                return deleted;
            }
            let now = Instant::now();
            if self.ticks() && now >= self.next {
                self.cycle();
                self.next = next_tick(self.next, Instant::now(), self.period);
            }
        }
    }

    fn ticks(&self) -> bool {
        matches!(self.component.state(), State::Active | State::Error)
    }

    fn cycle(&mut self) {
        match self.component.state() {
            State::Active => {
                self.component.executions.fetch_add(1, Ordering::Relaxed);
                let outcome = self
                    .instance
                    .callback(callback::EXECUTE)
                    .and_then(|()| self.instance.callback(callback::STATE_UPDATE));
                if let Err(error) = outcome {
                    self.abort(&error.message);
                }
            }
            State::Error => {
                // It is in Error already; on_error has no other way to complain than its log.
                let _ = self.instance.callback(callback::ERROR);
            }
            State::Created | State::Inactive => {}
        }
    }

    /// Carries out one request, unless its sender has given up. Returns the reply's way when it is to be deleted.
    fn obey(&mut self, command: Command) -> Option<Reply> {
        if Instant::now() >= command.deadline {
            return None;
        }
        let result = match command.action {
            Action::Activate => self.transition(Transition::Activate),
            Action::Deactivate => self.transition(Transition::Deactivate),
            Action::Reset => self.transition(Transition::Reset),
            Action::Configure { sets, active, rate } => {
                self.configure(&sets, active.as_deref(), rate)
            }
            Action::Delete => return Some(command.reply),
        };
        if command.reply.send(result).is_err() {
            let state = self.component.state().name();
            self.changed(&format!("is {state}, after its request's deadline"));
        }
        None
    }

    fn transition(&mut self, transition: Transition) -> Result<(), Failure> {
        let name = &self.component.identity.instance;
        let state = self.component.state();
        let (number, then, otherwise) = match verdict(state, transition) {
            Verdict::Already => return Ok(()),
            Verdict::Refused(why) => return Err(self.refused(why)),
            Verdict::Call {
                callback,
                then,
                otherwise,
            } => (callback, then, otherwise),
        };
        match self.instance.callback(number) {
            Ok(()) => {
                self.enter(then, None);
                self.next = Instant::now();
                Ok(())
            }
            Err(error) => {
                if otherwise == State::Error && state != State::Error {
                    self.abort(&error.message);
                } else {
                    self.enter(otherwise, Some(error.message.clone()));
                }
                Err(failure(
                    FailureCode::ComponentFailed,
                    format!("{name}: {}", error.message),
                ))
            }
        }
    }

    fn refused(&self, why: &str) -> Failure {
        let reason = match &lock(&self.component.status).message {
            Some(message) => format!(" ({message})"),
            None => String::new(),
        };
        failure(
            FailureCode::ComponentFailed,
            format!("{}: {why}{reason}", self.component.identity.instance),
        )
    }

    /// Goes to Error. The state shows before `on_aborting` is called, which might hang.
    fn abort(&mut self, reason: &str) {
        let Verdict::Call { callback, then, .. } =
            verdict(self.component.state(), Transition::Abort)
        else {
            return;
        };
        self.enter(then, Some(reason.to_owned()));
        self.changed(&format!("went to {}: {reason}", then.name()));
        if let Err(error) = self.instance.callback(callback) {
            self.component.log.write(Level::Warn, &error.message);
        }
    }

    fn enter(&self, state: State, message: Option<String>) {
        let mut status = lock(&self.component.status);
        let former = std::mem::replace(&mut status.state, state);
        status.message.clone_from(&message);
        drop(status);
        let (level, reason) = match message {
            Some(message) => (Level::Error, format!(": {message}")),
            None => (Level::Info, String::new()),
        };
        let line = format!("{} -> {}{reason}", former.name(), state.name());
        self.component.log.write(level, &line);
    }

    fn changed(&self, message: &str) {
        self.manager
            .events
            .changed(self.component.target(), message.to_owned());
    }

    /// Changes values, active set and rate. Either all values are taken or none.
    fn configure(
        &mut self,
        sets: &Sets,
        active: Option<&str>,
        rate: Option<f64>,
    ) -> Result<(), Failure> {
        rate.map_or(Ok(()), check_rate)?;
        let old = lock(&self.component.status).configuration.clone();
        let new = old
            .updated(sets, active)
            .map_err(|e| invalid(format!("{}: {e}", self.component.identity.instance)))?;
        let before = old.effective();
        let mut taken = Vec::new();
        for (name, value) in new.effective() {
            let former = before.get(name).copied();
            if former == Some(value) {
                continue;
            }
            if let Err(error) = self.instance.configure(name, value) {
                for (name, former) in taken {
                    let _ = self.instance.configure(name, former);
                }
                return Err(refusal(self.component, &error));
            }
            taken.extend(former.map(|former| (name, former)));
            self.component
                .log
                .write(Level::Info, &format!("configured {name} = {value}"));
        }
        lock(&self.component.status).configuration = new;
        rate.map_or(Ok(()), |rate| self.set_rate(rate))
    }

    fn set_rate(&mut self, rate: f64) -> Result<(), Failure> {
        let former = std::mem::replace(&mut lock(&self.component.status).rate, rate);
        if former == rate {
            return Ok(());
        }
        self.period = period(rate);
        self.next = self.next.min(Instant::now() + self.period);
        self.component
            .log
            .write(Level::Info, &format!("rate {former} Hz -> {rate} Hz"));
        self.instance
            .callback(callback::RATE_CHANGED)
            .map_err(|e| refusal(self.component, &e))
    }

    /// Takes the component down. What fails on the way is logged and goes on.
    fn end(mut self) {
        // A failing on_deactivated leads to Error, which is as good a state to finalise from.
        let _ = self.transition(Transition::Deactivate);
        self.manager.detach(self.component);
        if let Err(error) = self.instance.callback(callback::SHUTDOWN) {
            self.component.log.write(Level::Warn, &error.message);
        }
        let _ = self.transition(Transition::Finalize);
    }
}

/// A refused value is the sender's mistake, anything else the component's.
fn refusal(component: &Component, error: &CallFailed) -> Failure {
    let code = match error.code {
        return_code::BAD_PARAMETER => FailureCode::Invalid,
        _ => FailureCode::ComponentFailed,
    };
    failure(
        code,
        format!("{}: {}", component.identity.instance, error.message),
    )
}

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
