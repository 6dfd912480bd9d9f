//! Follows what the controller does: systems until they are where they should be, objects as they change, and logs.

mod known;
mod log;
mod watching;

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rts_controller_api::ClientError;
use rts_controller_api::client::Controller;
use rts_controller_api::objects::{Kind, Phase, System, SystemState, Waiting};
use rts_controller_api::watch::WatchType;
use rts_schemas::system::SystemSpec;
use tokio::time::timeout_at;

pub use self::known::{Change, Memory};
pub use self::log::{Log, LogNews, time_of};
pub use self::watching::{News, Watching};

/// Longest time without a look at the system while the watch is silent.
const LOOK: Duration = Duration::from_secs(1);
/// How long the controller may be silent.
const SILENCE: Duration = Duration::from_secs(5);
/// How long it may be too busy to answer what it was asked.
const BUSY: Duration = Duration::from_secs(60);

/// States of one system as they come: by watching, and by asking now and then, so that a watch that tells nothing costs
/// nothing but time.
pub struct Follower {
    controller: Controller,
    name: String,
    uid: String,
    /// It does not change while it is followed; the controller is asked only for the rest.
    spec: Arc<SystemSpec>,
    watching: Watching<SystemState>,
    silent_since: Option<Instant>,
}

impl Follower {
    /// Follows a system from a state that is known.
    pub fn new(controller: &Controller, from: &System) -> Self {
        let version = from.metadata.resource_version.clone();
        Self {
            controller: controller.clone(),
            name: from.metadata.name.clone(),
            uid: from.metadata.uid.clone(),
            spec: Arc::clone(&from.spec),
            watching: Watching::new(&controller.states(), Kind::System, Some(version)),
            silent_since: None,
        }
    }

    /// Shows each state (`None`: it is gone) until `see` is content; `None` when time is up before.
    pub async fn until<T>(
        &mut self,
        deadline: Instant,
        mut see: impl FnMut(Option<System>) -> ControlFlow<T>,
    ) -> Result<Option<T>, ClientError> {
        loop {
            let Ok(state) = timeout_at(deadline.into(), self.next()).await else {
                return Ok(None);
            };
            let state = state?;
            let gone = state.is_none();
            match see(state) {
                ControlFlow::Break(end) => return Ok(Some(end)),
                ControlFlow::Continue(()) if gone => return Ok(None),
                ControlFlow::Continue(()) => {}
            }
        }
    }

    /// The next state; `None` once the system is gone.
    async fn next(&mut self) -> Result<Option<System>, ClientError> {
        let mut look = tokio::time::Instant::now() + LOOK;
        loop {
            let Ok(news) = timeout_at(look, self.watching.next()).await else {
                match self.ask().await? {
                    Some(state) => return Ok(state),
                    None => look = tokio::time::Instant::now() + LOOK,
                }
                continue;
            };
            match news? {
                News::Silent(e) => self.silent(e)?,
                News::Back => self.silent_since = None,
                News::All(list) => {
                    let mut items = list.items.into_iter();
                    let own = items.find(|s| s.metadata.name == self.name && self.same(s));
                    return Ok(own.map(|state| self.whole(state)));
                }
                News::Change(_, system) if system.metadata.name != self.name => {}
                News::Change(WatchType::Deleted, system) => {
                    if self.same(&system) {
                        return Ok(None);
                    }
                }
                News::Change(_, system) => {
                    let own = Some(system).filter(|s| self.same(s));
                    return Ok(own.map(|state| self.whole(state)));
                }
            }
        }
    }

    /// How it is now; none when the controller is silent, for a while.
    async fn ask(&mut self) -> Result<Option<Option<System>>, ClientError> {
        let asked = timeout_at(
            tokio::time::Instant::now() + SILENCE,
            self.controller.system_state(&self.name),
        );
        match asked.await {
            Ok(Ok(system)) => {
                self.silent_since = None;
                let own = Some(system).filter(|s| self.same(s));
                Ok(Some(own.map(|state| self.whole(state))))
            }
            Ok(Err(ClientError::Problem(problem))) if problem.status == 404 => Ok(Some(None)),
            Ok(Err(e)) => self.silent(e).map(|()| None),
            // It has taken the question: it is there, and busy.
            Err(_) => {
                let error = self.controller.silent("it takes too long to answer");
                self.waited(error, BUSY).map(|()| None)
            }
        }
    }

    /// The controller is silent: an error once that lasts too long.
    fn silent(&mut self, error: ClientError) -> Result<(), ClientError> {
        self.waited(error, SILENCE)
    }

    /// It has not answered: an error once that has lasted for so long.
    fn waited(&mut self, error: ClientError, most: Duration) -> Result<(), ClientError> {
        let since = *self.silent_since.get_or_insert_with(Instant::now);
        if since.elapsed() < most {
            return Ok(());
        }
        Err(error)
    }

    /// Another system of the same name means that ours is gone.
    fn same(&self, system: &SystemState) -> bool {
        system.metadata.uid == self.uid
    }

    fn whole(&self, state: SystemState) -> System {
        state.with_spec(Arc::clone(&self.spec))
    }
}

/// How an apply stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// Work goes on.
    Going,
    /// Everything required runs; what does not is listed.
    Converged(Vec<Waiting>),
    /// Something required does not run, and trying has begun to back off or is in vain.
    Partly(Vec<Waiting>),
    /// It is said not to be well, and nobody says what is missing.
    Unclear,
}

/// Judges a system's state against the generation that was applied.
pub fn judge(system: &System, generation: u64) -> Verdict {
    let status = &system.status;
    if status.observed_generation < generation {
        return Verdict::Going;
    }
    // What passes by itself decides nothing.
    let (transient, waiting): (Vec<_>, Vec<_>) =
        status.waiting_on.iter().cloned().partition(|w| w.transient);
    let backs_off = |w: &Waiting| w.tries >= 1 || w.next_try.is_none();
    match status.phase {
        Phase::Converged => Verdict::Converged(waiting),
        Phase::Degraded if waiting.iter().any(|w| w.required && backs_off(w)) => {
            Verdict::Partly(waiting)
        }
        Phase::Degraded if !transient.is_empty() => Verdict::Going,
        Phase::Degraded if waiting.is_empty() => Verdict::Unclear,
        Phase::Degraded if waiting.iter().all(|w| !w.required && backs_off(w)) => {
            Verdict::Converged(waiting)
        }
        Phase::Degraded | Phase::Progressing | Phase::Terminating => Verdict::Going,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::show::samples;

    fn waiting(required: bool, tries: u32) -> Waiting {
        Waiting {
            target: "component/Motor0".to_owned(),
            reason: "its module failed".to_owned(),
            required,
            transient: false,
            tries,
            next_try: Some(jiff::Timestamp::UNIX_EPOCH),
        }
    }

    fn verdict(phase: Phase, waiting_on: Vec<Waiting>) -> Verdict {
        let mut system = samples::system();
        system.status.phase = phase;
        system.status.observed_generation = 2;
        system.status.waiting_on = waiting_on;
        judge(&system, 2)
    }

    #[test]
    fn an_older_generation_says_nothing_of_this_one() {
        let mut system = samples::system();
        system.status.phase = Phase::Converged;
        system.status.observed_generation = 1;
        assert_eq!(judge(&system, 2), Verdict::Going);
    }

    #[test]
    fn a_required_component_decides_once_it_was_tried() {
        assert_eq!(
            verdict(Phase::Converged, vec![]),
            Verdict::Converged(vec![])
        );
        assert_eq!(
            verdict(Phase::Progressing, vec![waiting(true, 3)]),
            Verdict::Going
        );
        assert_eq!(
            verdict(Phase::Degraded, vec![waiting(true, 0)]),
            Verdict::Going
        );
        assert!(matches!(
            verdict(Phase::Degraded, vec![waiting(true, 1)]),
            Verdict::Partly(_)
        ));
        let mut never = waiting(true, 0);
        never.next_try = None;
        assert!(matches!(
            verdict(Phase::Degraded, vec![never]),
            Verdict::Partly(_)
        ));
    }

    #[test]
    fn what_passes_by_itself_is_waited_for() {
        let question = Waiting {
            transient: true,
            next_try: None,
            ..waiting(true, 0)
        };
        let of = |waiting| verdict(Phase::Degraded, waiting);
        assert_eq!(of(vec![question.clone()]), Verdict::Going);
        assert_eq!(
            of(vec![question.clone(), waiting(false, 1)]),
            Verdict::Going
        );
        assert_eq!(
            of(vec![question, waiting(true, 1)]),
            Verdict::Partly(vec![waiting(true, 1)])
        );
    }

    #[test]
    fn degraded_without_a_reason_is_told_apart() {
        assert_eq!(verdict(Phase::Degraded, vec![]), Verdict::Unclear);
    }

    #[test]
    fn an_optional_component_that_fails_is_only_a_warning() {
        let optional = vec![waiting(false, 1)];
        assert_eq!(
            verdict(Phase::Degraded, optional.clone()),
            Verdict::Converged(optional)
        );
    }
}
