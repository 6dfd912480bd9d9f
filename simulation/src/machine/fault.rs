//! What goes wrong on the machine when the schedule says so.

use std::time::Duration;

use rts_agent::launch::Exit;
use rts_host::clock::Chance;
use tokio::time::sleep;

use super::SimMachine;
use super::handle::Handle;
use super::state::{At, EXECUTE, FIRST_PID, LifeCycle, Process, Run, State};
use crate::faults::Misbehaviour;
use crate::modules::SimModule;
use crate::truth::{Cause, Happened};

/// How SIGKILL ends a process.
const KILLED: Exit = Exit::Signal(9);
/// When what happens some time after the activation happens, in milliseconds.
const LATER: (u64, u64) = (200, 3_000);

impl SimMachine {
    /// Adds a module, or replaces the one of its type.
    pub fn install(&self, module: SimModule) {
        self.0.change(|state| {
            state.modules.0.insert(module.type_name.clone(), module);
        });
    }

    /// The file of a module is replaced by another one with this digest.
    pub fn replace_module(&self, type_name: &str, digest: &str) {
        self.module(type_name, |module| digest.clone_into(&mut module.digest));
    }

    /// From now on a module cannot be loaded, or can again.
    pub fn fail_module(&self, type_name: &str, fails: bool) {
        self.module(type_name, |module| module.fails = fails);
    }

    fn module(&self, type_name: &str, change: impl FnOnce(&mut SimModule)) {
        self.0.change(|state| {
            if let Some(module) = state.modules.0.get_mut(type_name) {
                change(module);
            }
        });
    }

    /// Probability with which processes that start from now on start one of their own.
    pub fn grandchildren(&self, probability: f64) {
        self.0.change(|state| state.grandchildren = probability);
    }

    /// From now on processes end before they say Hello, or no more.
    pub fn fail_to_start(&self, fails: bool) {
        self.0.change(|state| state.fails_to_start = fails);
    }

    /// True while the process of a manager lives; by its display name, or any.
    pub fn has(&self, manager: Option<&str>) -> bool {
        self.0.change(|state| {
            let mut living = state.processes.values().filter(|p| p.lives());
            living.any(|p| manager.is_none_or(|name| p.key.display_name() == name))
        })
    }

    /// The process of a manager dies; by its display name, or any. Gives which.
    pub fn kill(&self, manager: Option<&str>) -> Option<String> {
        self.hit(manager, |state, number| {
            state.blemish(number, None, "it is killed".to_owned());
            state.end(number, KILLED, Cause::Fault);
        })
    }

    /// The process of a manager stops answering for ever, and does not die of SIGTERM. Gives which.
    pub fn hang(&self, manager: Option<&str>) -> Option<String> {
        self.hit(manager, |state, number| {
            state.blemish(number, None, "it hangs".to_owned());
            if let Some(process) = state.living(number) {
                process.run.send_replace(Run::Hangs);
            }
        })
    }

    fn hit(&self, manager: Option<&str>, hit: impl FnOnce(&mut State, u64)) -> Option<String> {
        self.0.change(|state| {
            let is =
                |p: &&Process| p.lives() && manager.is_none_or(|name| p.key.display_name() == name);
            let them: Vec<_> = state.processes.values().filter(is).collect();
            let process = self.0.streams.faults.pick(&them)?;
            let (number, name) = (process.number, process.key.display_name());
            hit(state, number);
            Some(name)
        })
    }

    /// The machine loses its power and comes back: no process is left, the run folders are. The program that runs on it
    /// and its disk are somebody else's.
    pub fn reboot(&self) {
        let boot_id = self.0.streams.ids.uuid();
        self.0.change(|state| {
            let numbers: Vec<u64> = state.processes.keys().copied().collect();
            for number in numbers.iter().copied() {
                state.blemish(number, None, "its machine loses its power".to_owned());
                // None of them sees the end of the others.
                if let Some(process) = state.living(number) {
                    process.stopping = true;
                }
            }
            for number in numbers.iter().copied() {
                state.end(number, KILLED, Cause::Fault);
                state.kill_grandchildren(number);
            }
            state.boot_id = boot_id;
            state.pid = FIRST_PID;
            let node = state.node.clone();
            state.news.push(Happened::Rebooted { node });
        });
    }

    /// From now on an instance misbehaves so, also when it is made anew; none to behave well again, which ends a callback
    /// that hangs.
    pub fn misbehave(&self, instance: &str, how: Option<Misbehaviour>) {
        let living: Vec<(Handle, At)> = self.0.change(|state| {
            match how {
                Some(how) => state.misbehaviours.insert(instance.to_owned(), how),
                None => state.misbehaviours.remove(instance),
            };
            let living = state.processes.values().filter(|p| p.lives());
            let found = living.filter_map(|process| {
                let component = process.components.get(instance)?;
                let handle = Handle::new(self.0.clone(), process);
                let active = component.state == LifeCycle::Active;
                active.then(|| (handle, component.at(process.number)))
            });
            found.collect()
        });
        self.0.misbehaviour.send_modify(|changes| *changes += 1);
        for (handle, at) in living {
            handle.misbehave(&at);
        }
    }
}

impl Handle {
    /// Lets a component that has just become Active do later what it does wrong then, if anything.
    pub fn misbehave(&self, at: &At) {
        use Misbehaviour as M;
        let Some(how) = self.misbehaviour(at) else {
            return;
        };
        let after = match how {
            M::HangExecute | M::Panic => Duration::from_millis(10),
            M::CrashLater | M::ErrorExecute => {
                let (low, high) = LATER;
                Duration::from_millis(self.shared.streams.faults.between(low, high))
            }
            _ => return,
        };
        let (handle, at) = (self.clone(), at.clone());
        self.spawn(async move {
            sleep(after).await;
            handle.runs().await;
            handle.execute_wrongly(&at, how).await;
        });
    }

    async fn execute_wrongly(&self, at: &At, how: Misbehaviour) {
        let Some(_turn) = self.turn(at).await else {
            return;
        };
        let active = self.component(at, |c| c.state == LifeCycle::Active);
        if active != Some(true) || self.misbehaviour(at) != Some(how) {
            return;
        }
        let error = match how {
            Misbehaviour::CrashLater => self.crash(at, EXECUTE).await,
            Misbehaviour::HangExecute => {
                self.busy(at, Some(EXECUTE));
                self.hang(at, EXECUTE).await;
                return self.busy(at, None);
            }
            Misbehaviour::Panic => "on_execute: it panicked: simulated",
            _ => "on_execute returned RTC_ERROR",
        };
        self.blemish(at, error);
        self.abort(at, error).await;
    }
}
