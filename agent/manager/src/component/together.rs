//! Components that share their state with the other members of a composite, all on one execution context: they are
//! deactivated and reset together, none is activated while another is in Error, and an error of one is that of all.

use std::sync::Arc;

use rts_manager_api::control::{Failure, FailureCode};

use super::lifecycle::Transition;
use super::run::Runner;
use super::{Component, State};
use crate::failure::failure;
use crate::sync::lock;

impl Component {
    /// True when both share their state.
    fn is_with(&self, other: &Self) -> bool {
        let own = &self.identity.shared_state;
        own.is_some() && *own == other.identity.shared_state
    }
}

impl Runner<'_> {
    /// Indices of the others that share their state with a component.
    fn others(&self, component: &Arc<Component>) -> Vec<usize> {
        let members = self.members.iter().enumerate();
        members
            .filter(|(_, other)| !other.is(component) && other.component.is_with(component))
            .map(|(index, _)| index)
            .collect()
    }

    /// Activates a component, unless another one of its composite is in Error.
    pub(super) fn activate(&mut self, index: usize) -> Result<(), Failure> {
        let component = Arc::clone(&self.members[index].component);
        let others = self.others(&component).into_iter();
        let mut others = others.map(|other| &self.members[other].component);
        if let Some(other) = others.find(|other| other.state() == State::Error) {
            let message = format!(
                "{}: {}, with which it shares its state in {}, is in Error: reset that first",
                component.identity.instance,
                other.identity.instance,
                component
                    .identity
                    .shared_state
                    .as_deref()
                    .unwrap_or_default()
            );
            return Err(failure(FailureCode::ComponentFailed, message));
        }
        self.members[index].activate()
    }

    /// Deactivates a component, and all that share their state with it.
    pub(super) fn deactivate(
        &mut self,
        index: usize,
        by_hand: Option<&String>,
    ) -> Result<(), Failure> {
        let component = Arc::clone(&self.members[index].component);
        let done = self.members[index].deactivate(by_hand.cloned());
        self.deactivate_others(&component, by_hand);
        done
    }

    /// The others go where one went that was deactivated.
    pub(super) fn deactivate_others(
        &mut self,
        component: &Arc<Component>,
        by_hand: Option<&String>,
    ) {
        for other in self.others(component) {
            let other = &mut self.members[other];
            if other.component.state() == State::Active {
                // A failure leads to Error, where it is told.
                let _ = other.deactivate(by_hand.cloned());
            }
        }
    }

    /// Resets a component, and all that share their state with it.
    pub(super) fn reset(&mut self, index: usize) -> Result<(), Failure> {
        let component = Arc::clone(&self.members[index].component);
        let mut done = self.members[index].transition(Transition::Reset);
        for other in self.others(&component) {
            let other = &mut self.members[other];
            if other.component.state() == State::Error {
                done = done.and(other.transition(Transition::Reset));
            }
        }
        done
    }

    /// Takes those to Error that are Active while one is in Error with which they share their state.
    pub(super) fn share_errors(&mut self) {
        for index in 0..self.members.len() {
            let failed = &self.members[index].component;
            if failed.identity.shared_state.is_none() || failed.state() != State::Error {
                continue;
            }
            let failed = Arc::clone(failed);
            for other in self.others(&failed) {
                let other = &mut self.members[other];
                if other.component.state() == State::Active {
                    let why = lock(&failed.status).message.clone();
                    let why = why.map_or(String::new(), |why| format!(": {why}"));
                    let (name, composite) = (
                        &failed.identity.instance,
                        failed.identity.shared_state.as_deref(),
                    );
                    let composite = composite.unwrap_or_default();
                    other.abort(&format!("{name} of {composite} is in Error{why}"));
                }
            }
        }
    }
}
