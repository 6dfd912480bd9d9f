//! A component as the thread of its execution context sees it: its creation, its part in a cycle, its end.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use rts_manager_api::control::Failure;

use super::instance::Instance;
use super::lifecycle::Transition;
use super::order::TakesPart;
use super::steps::refusal;
use super::{Component, State};
use crate::data::Parting;
use crate::manager::Manager;
use crate::module::Execution;
use crate::sync::lock;

/// A component that is run.
pub struct Member<'a> {
    /// The manager that holds it.
    pub manager: &'a Manager,
    /// Its visible part.
    pub component: Arc<Component>,
    /// The instance.
    pub instance: Instance,
    /// How long its first pass of this cycle took; none when there is no second one for it.
    first: Option<Duration>,
    /// It has executed in this cycle.
    executed: bool,
}

impl<'a> Member<'a> {
    /// Makes and initialises it.
    pub fn start(manager: &'a Manager, component: &Arc<Component>) -> Result<Self, Failure> {
        let named = |e| refusal(component, &e);
        let configuration = lock(&component.status).configuration.clone();
        let mut instance = Instance::create(component).map_err(named)?;
        for (name, value) in configuration.effective() {
            instance.configure(name, value).map_err(named)?;
        }
        let mut member = Self {
            manager,
            component: Arc::clone(component),
            instance,
            first: None,
            executed: false,
        };
        member.transition(Transition::Initialize)?;
        if let Err(failure) = member.transition(Transition::StartUp) {
            let _ = member.transition(Transition::Finalize);
            return Err(failure);
        }
        Ok(member)
    }

    /// Takes it down. What fails on the way is logged and goes on.
    pub fn end(mut self, parting: Parting) {
        // A failing on_deactivated leads to Error, which is as good a state to finalise from.
        let _ = self.transition(Transition::Deactivate);
        self.manager.detach(&self.component, parting);
        let _ = self.transition(Transition::ShutDown);
        let _ = self.transition(Transition::Finalize);
    }

    /// Whether it takes part in cycles.
    pub fn runs(&self) -> bool {
        matches!(self.component.state(), State::Active | State::Error)
    }

    /// Whether it is the visible part of this one.
    pub fn is(&self, component: &Arc<Component>) -> bool {
        Arc::ptr_eq(&self.component, component)
    }

    /// Counts how late the cycle began that it executed in, and whether that ended in time.
    pub fn keep_time(&self, late: Duration, is_over: bool) {
        let timing = &self.component.timing;
        if self.executed {
            timing.jitter.add(late);
        }
        if is_over && self.runs() {
            timing.count_overrun();
        }
    }
}

impl TakesPart for Member<'_> {
    fn first(&mut self) {
        (self.first, self.executed) = (None, false);
        // With an event-driven execution context only who was woken; also by one that went before it in this cycle.
        if self.component.context.kind == Execution::EventDriven
            && !(self.runs() && self.component.take_wake())
        {
            return;
        }
        match self.component.state() {
            State::Active => {
                self.executed = true;
                self.component.executions.fetch_add(1, Ordering::Relaxed);
                let start = Instant::now();
                // A failure leads to Error, where it is told.
                let done = self.transition(Transition::Execute);
                match done {
                    Ok(()) => self.first = Some(start.elapsed()),
                    Err(_) => self.component.timing.ran(start.elapsed()),
                }
            }
            State::Error => {
                let _ = self.transition(Transition::Dwell);
            }
            State::Created | State::Inactive => {}
        }
    }

    fn second(&mut self) {
        if let Some(first) = self.first {
            let start = Instant::now();
            let _ = self.transition(Transition::UpdateState);
            let timing = &self.component.timing;
            timing.ran(first + start.elapsed());
        }
    }
}
