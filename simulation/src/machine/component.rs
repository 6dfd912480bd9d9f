//! What a component does when it is asked to: one thing after the other, each in its turn.

use rts_manager_api::control::{Failure, FailureCode};
use rts_schemas::system::rate_problem;
use tokio::sync::{OwnedMutexGuard, oneshot};
use tokio::time::Instant;

use super::configuration::Sets;
use super::connection::refuse;
use super::handle::Handle;
use super::loss::policy;
use super::state::{At, Component, LifeCycle, Parting, State};
use crate::truth::{Cause, Happened};

/// What to do.
pub(super) enum Action {
    Activate,
    Deactivate {
        by_hand: Option<String>,
    },
    Reset,
    Delete,
    Configure {
        sets: Sets,
        active: Option<String>,
        rate: Option<f64>,
        on_disconnect: Option<String>,
        order: Option<i32>,
        by_hand: Option<String>,
    },
}

/// The answer when it was deleted meanwhile.
pub(super) fn gone(instance: &str) -> Failure {
    refuse(FailureCode::NotFound, format!("{instance} was deleted"))
}

/// The answer when it did not do it in time.
pub(super) fn late(handle: &Handle, at: &At, otherwise: &str) -> Failure {
    let busy = handle.change(|state| state.component(at).and_then(|c| c.busy));
    let name = &at.instance;
    let message = match busy {
        Some((callback, since)) => {
            let seconds = since.elapsed().as_secs_f64();
            format!("{name} has been in {callback} for {seconds:.1} s")
        }
        None => format!("{name} {otherwise}"),
    };
    refuse(FailureCode::Deadline, message)
}

/// Carries a request out in its turn, unless its sender has given up by then.
pub(super) async fn obey(
    handle: Handle,
    at: At,
    action: Action,
    deadline: Instant,
    reply: oneshot::Sender<Result<(), Failure>>,
) {
    let Some(_turn) = handle.turn(&at).await else {
        return;
    };
    if Instant::now() >= deadline {
        let late = late(&handle, &at, "was busy until the request's deadline");
        let _ = reply.send(Err(late));
        return;
    }
    let deleted = matches!(action, Action::Delete);
    let done = handle.carry_out(&at, action).await;
    if reply.send(done).is_ok() {
        return;
    }
    let state = handle.change(|state| state.component(&at).map(|c| c.state.name()));
    match state {
        Some(state) => handle.told(&at, format!("is {state}, after its request's deadline")),
        None if deleted => handle.told(&at, "was deleted after its deadline".to_owned()),
        None => {}
    }
}

impl Handle {
    /// The turn of a component; none when it is gone.
    pub async fn turn(&self, at: &At) -> Option<OwnedMutexGuard<()>> {
        let turn = self.change(|state| state.component(at).map(|c| c.turn.clone()))?;
        let turn = turn.lock_owned().await;
        self.runs().await;
        self.change(|state| state.component(at).map(|_| ()))?;
        Some(turn)
    }

    async fn carry_out(&self, at: &At, action: Action) -> Result<(), Failure> {
        match action {
            Action::Activate => {
                let done = self.activate(at).await;
                self.component(at, |component| {
                    if component.state != LifeCycle::Inactive {
                        component.by_hand.deactivated = None;
                    }
                });
                done
            }
            Action::Deactivate { by_hand } => {
                let done = self.deactivate(at, Cause::Asked).await;
                self.component(at, |component| {
                    if let (LifeCycle::Inactive, Some(mark)) = (component.state, by_hand) {
                        component.by_hand.deactivated = Some(mark);
                    }
                });
                done
            }
            Action::Reset => self.reset(at).await,
            Action::Delete => {
                self.delete(at, Parting::GoodBye, Cause::Asked).await;
                Ok(())
            }
            Action::Configure {
                sets,
                active,
                rate,
                on_disconnect,
                order,
                by_hand,
            } => {
                self.work(50, 1_000).await;
                let configure = |component: &mut Component| {
                    let sets_values = !sets.is_empty() || active.is_some();
                    component.configure(&sets, active.as_deref(), rate, on_disconnect)?;
                    if let (Some(order), Some(shared)) = (order, &mut component.shared) {
                        shared.order = order;
                    }
                    if sets_values || by_hand.is_some() {
                        component.by_hand.configured = by_hand;
                    }
                    Ok(())
                };
                let done = self.component(at, configure);
                done.unwrap_or_else(|| Err(gone(&at.instance)))
            }
        }
    }

    /// Looks at a component, or changes it.
    pub fn component<T>(&self, at: &At, work: impl FnOnce(&mut Component) -> T) -> Option<T> {
        self.change(|state| state.component(at).map(work))
    }

    fn state(&self, at: &At) -> LifeCycle {
        let state = self.component(at, |component| component.state);
        state.unwrap_or(LifeCycle::Created)
    }

    fn failed(&self, at: &At, why: &str) -> Failure {
        let message = format!("{}: {why}", at.instance);
        refuse(FailureCode::ComponentFailed, message)
    }

    async fn activate(&self, at: &At) -> Result<(), Failure> {
        match self.state(at) {
            LifeCycle::Active => return Ok(()),
            LifeCycle::Inactive => {}
            LifeCycle::Error => return Err(self.failed(at, "it is in Error: reset it first")),
            LifeCycle::Created => return Err(self.failed(at, "it is not initialised")),
        }
        if let Some(why) = self.change(|state| state.why_lost(at)) {
            return Err(self.failed(at, &why));
        }
        match self.callback(at, "on_activated").await {
            Ok(()) => {
                self.change(|state| state.enter(at, LifeCycle::Active, None, Cause::Asked));
                self.misbehave(at);
                Ok(())
            }
            Err(why) => {
                self.abort(at, &why).await;
                Err(self.failed(at, &why))
            }
        }
    }

    /// Deactivates it; the cause is told.
    pub async fn deactivate(&self, at: &At, cause: Cause) -> Result<(), Failure> {
        match self.state(at) {
            LifeCycle::Inactive | LifeCycle::Error => return Ok(()),
            LifeCycle::Created => return Err(self.failed(at, "it is not initialised")),
            LifeCycle::Active => {}
        }
        match self.callback(at, "on_deactivated").await {
            Ok(()) => {
                self.change(|state| state.enter(at, LifeCycle::Inactive, None, cause));
                Ok(())
            }
            Err(why) => {
                self.abort(at, &why).await;
                Err(self.failed(at, &why))
            }
        }
    }

    async fn reset(&self, at: &At) -> Result<(), Failure> {
        match self.state(at) {
            LifeCycle::Inactive => return Ok(()),
            LifeCycle::Active => return Err(self.failed(at, "it is Active: nothing to reset")),
            LifeCycle::Created => return Err(self.failed(at, "it is not initialised")),
            LifeCycle::Error => {}
        }
        let done = self.callback(at, "on_reset").await;
        done.map_err(|why| self.failed(at, &why))?;
        self.change(|state| state.enter(at, LifeCycle::Inactive, None, Cause::Asked));
        Ok(())
    }

    /// Goes to Error by itself.
    pub async fn abort(&self, at: &At, why: &str) {
        let told = format!("went to Error: {why}");
        self.change(|state| {
            let why = Some(why.to_owned());
            state.enter(at, LifeCycle::Error, why, Cause::Fault);
        });
        self.told(at, told);
        let _ = self.callback(at, "on_aborting").await;
    }

    /// Takes it down, and forgets it. What fails on the way goes on.
    pub async fn delete(&self, at: &At, parting: Parting, cause: Cause) {
        let _ = self.deactivate(at, cause).await;
        self.change(|state| state.detach(at, parting, cause));
        let initialised = self.state(at) != LifeCycle::Created;
        if initialised {
            let _ = self.callback(at, "on_finalize").await;
        }
        self.change(|state| state.remove(at, parting, cause));
    }

    /// Tells all control connections something of a component.
    pub fn told(&self, at: &At, message: String) {
        let target = format!("component/{}", at.instance);
        self.with(|process| process.changed(target, message, None));
    }
}

impl Component {
    fn configure(
        &mut self,
        sets: &Sets,
        active: Option<&str>,
        rate: Option<f64>,
        on_disconnect: Option<String>,
    ) -> Result<(), Failure> {
        let name = &self.subject.instance;
        let invalid = |why: String| refuse(FailureCode::Invalid, format!("{name}: {why}"));
        if let Some(problem) = rate.and_then(rate_problem) {
            return Err(invalid(problem));
        }
        let policy = policy(on_disconnect.as_deref())?;
        let updated = self.configuration.updated(sets, active);
        self.configuration = updated.map_err(invalid)?;
        if let Some(policy) = policy {
            policy.clone_into(&mut self.on_disconnect);
        }
        self.rate = rate.unwrap_or(self.rate);
        Ok(())
    }

    /// True once its creation was told.
    pub fn is_told(&self) -> bool {
        self.state != LifeCycle::Created
    }
}

impl State {
    /// Changes the state of a component.
    pub fn enter(&mut self, at: &At, to: LifeCycle, message: Option<String>, cause: Cause) {
        let Some(component) = self.component(at) else {
            return;
        };
        let from = std::mem::replace(&mut component.state, to);
        component.message = message;
        if from == to {
            return;
        }
        let of = component.subject.clone();
        self.news.push(Happened::State {
            of,
            from: from.name().to_owned(),
            to: to.name().to_owned(),
            cause,
        });
    }

    /// Forgets a component, with its ends of connectors.
    pub fn remove(&mut self, at: &At, parting: Parting, cause: Cause) {
        self.detach(at, parting, cause);
        if self.component(at).is_none() {
            return;
        }
        let Some(process) = self.living(at.process) else {
            return;
        };
        if let Some(component) = process.components.remove(&at.instance)
            && component.is_told()
        {
            let deleted = Happened::Deleted(component.subject, cause);
            self.news.push(deleted);
        }
    }
}
