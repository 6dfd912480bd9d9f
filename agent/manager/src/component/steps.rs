//! What becomes of a component by a request or a cycle: transitions of the life cycle, and configuration.

use std::sync::Arc;

use rts_manager_api::control::{Failure, FailureCode};
use rts_runtime::abi::return_code;
use rts_schemas::system::OnDisconnect;

use super::configuration::Sets;
use super::instance::CallFailed;
use super::lifecycle::{Transition, Verdict, verdict};
use super::member::Member;
use super::{Component, State};
use crate::failure::{failure, invalid};
use crate::log::Level;
use crate::sync::lock;

impl Member<'_> {
    pub fn transition(&mut self, transition: Transition) -> Result<(), Failure> {
        let component = Arc::clone(&self.component);
        let name = &component.identity.instance;
        let state = component.state();
        let (number, then, otherwise) = match verdict(state, transition) {
            Verdict::Already => return Ok(()),
            Verdict::Refused(why) => return Err(self.refused(why)),
            Verdict::Call {
                callback,
                then,
                otherwise,
            } => (callback, then, otherwise),
        };
        let starts = transition == Transition::Activate;
        if starts {
            self.check_peers()?;
            // What asked for a cycle before has nothing to ask for any more.
            self.component.take_wake();
            self.forget_samples();
        }
        match self.instance.callback(number) {
            Ok(()) => {
                if starts {
                    self.forget_samples();
                }
                if then != state {
                    self.enter(then, None);
                }
                Ok(())
            }
            Err(error) => {
                self.failed(transition, state, otherwise, &error);
                Err(failure(
                    FailureCode::ComponentFailed,
                    format!("{name}: {}", error.message),
                ))
            }
        }
    }

    /// A callback failed: what becomes of the component.
    fn failed(&mut self, transition: Transition, from: State, to: State, error: &CallFailed) {
        use Transition::{Dwell, Initialize, Reset, StartUp};
        match transition {
            Initialize | Reset => self.enter(to, Some(error.message.clone())),
            // Creation says why it fails; what is in Error has said why, and would say it each cycle.
            StartUp | Dwell => {}
            _ if to == State::Error && from != State::Error => self.abort(&error.message),
            _ if to != from => self.enter(to, Some(error.message.clone())),
            _ => self.component.log.write(Level::Warn, &error.message),
        }
    }

    pub fn activate(&mut self) -> Result<(), Failure> {
        let done = self.transition(Transition::Activate);
        self.component.activated();
        done
    }

    pub fn deactivate(&mut self, by_hand: Option<String>) -> Result<(), Failure> {
        let done = self.transition(Transition::Deactivate);
        if let Some(mark) = by_hand {
            self.component.deactivated_by(mark);
        }
        done
    }

    /// What was sent while it was not Active is not done when it is: old set points would move a robot late.
    fn forget_samples(&self) {
        self.component.in_ports().for_each(|port| port.clear());
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
    pub fn abort(&mut self, reason: &str) {
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

    pub fn changed(&self, message: &str) {
        self.manager
            .events
            .changed(self.component.target(), message.to_owned());
    }

    /// Changes values, active set and policy. Either all values are taken or none. True when a value in force is another.
    pub fn set_values(
        &mut self,
        sets: &Sets,
        active: Option<&str>,
        on_disconnect: Option<OnDisconnect>,
    ) -> Result<bool, Failure> {
        let old = lock(&self.component.status).configuration.clone();
        let new = old
            .updated(sets, active, &self.component.module.limits)
            .map_err(|e| invalid(format!("{}: {e}", self.component.identity.instance)))?;
        let before = old.effective();
        let mut taken = Vec::new();
        let mut told = Vec::new();
        for (name, value) in new.effective() {
            let former = before.get(name).copied();
            if former == Some(value) {
                continue;
            }
            if let Err(error) = self.instance.configure(name, value) {
                for (name, former) in taken {
                    let _ = self.instance.configure(name, former);
                }
                return Err(refusal(&self.component, &error));
            }
            taken.extend(former.map(|former| (name, former)));
            told.push(format!("configured {name} = {value}"));
        }
        // Not before all are taken: the log names no value that was not in force.
        for line in told {
            self.component.log.write(Level::Info, &line);
        }
        let any = before != new.effective();
        let mut status = lock(&self.component.status);
        status.configuration = new;
        status.on_disconnect = on_disconnect.unwrap_or(status.on_disconnect);
        Ok(any)
    }
}

/// A refused value is the sender's mistake, anything else the component's.
pub fn refusal(component: &Component, error: &CallFailed) -> Failure {
    let code = match error.code {
        return_code::BAD_PARAMETER => FailureCode::Invalid,
        _ => FailureCode::ComponentFailed,
    };
    failure(
        code,
        format!("{}: {}", component.identity.instance, error.message),
    )
}
