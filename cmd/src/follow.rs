//! Follows a system until it is where it should be: by watching, and by asking now and then, so that a broken watch
//! costs nothing but time.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use rts_controller_api::ClientError;
use rts_controller_api::client::Controller;
use rts_controller_api::objects::{Kind, Phase, System, Waiting};
use rts_controller_api::watch::{Watch, WatchType};

/// Longest time between two looks while the watch is silent.
const LOOK: Duration = Duration::from_secs(1);
/// Time between two looks without a watch.
const POLL: Duration = Duration::from_millis(200);
/// How long the controller may be silent.
const SILENCE: Duration = Duration::from_secs(5);

/// States of one system as they come.
pub struct Follower<'a> {
    controller: &'a Controller,
    name: String,
    uid: String,
    watch: Option<Watch<System>>,
    silent_since: Option<Instant>,
}

impl<'a> Follower<'a> {
    /// Follows a system from a state that is known.
    pub async fn new(controller: &'a Controller, from: &System) -> Self {
        let version = &from.metadata.resource_version;
        let watch = controller.watch(Kind::System, version);
        let watch = tokio::time::timeout(LOOK, watch).await;
        Self {
            controller,
            name: from.metadata.name.clone(),
            uid: from.metadata.uid.clone(),
            watch: watch.ok().and_then(Result::ok),
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
            let next = tokio::time::timeout_at(deadline.into(), self.next()).await;
            let Ok(state) = next else {
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
    pub async fn next(&mut self) -> Result<Option<System>, ClientError> {
        if let Some(state) = self.watched().await {
            return Ok(state);
        }
        loop {
            match self.controller.system(&self.name).await {
                Ok(system) => {
                    self.silent_since = None;
                    return Ok(self.same(system));
                }
                Err(ClientError::Problem(problem)) if problem.status == 404 => return Ok(None),
                Err(e) => {
                    let since = *self.silent_since.get_or_insert_with(Instant::now);
                    if since.elapsed() >= SILENCE {
                        return Err(e);
                    }
                    tokio::time::sleep(POLL).await;
                }
            }
        }
    }

    /// What the watch says within [`LOOK`]; `None` means: ask.
    async fn watched(&mut self) -> Option<Option<System>> {
        let Some(watch) = &mut self.watch else {
            tokio::time::sleep(POLL).await;
            return None;
        };
        let end = tokio::time::Instant::now() + LOOK;
        loop {
            match tokio::time::timeout_at(end, watch.next()).await {
                Err(_) => return None,
                Ok(None | Some(Err(_))) => {
                    self.watch = None;
                    return None;
                }
                Ok(Some(Ok(event))) => match (event.kind, event.object) {
                    (WatchType::Bookmark, _) | (_, None) => {}
                    (kind, Some(system)) if system.metadata.name == self.name => {
                        return match kind {
                            // Its successor may have come already: ask.
                            WatchType::Deleted if system.metadata.uid == self.uid => Some(None),
                            WatchType::Deleted => None,
                            _ => Some(self.same(system)),
                        };
                    }
                    _ => {}
                },
            }
        }
    }

    /// Another system of the same name means that ours is gone.
    fn same(&self, system: System) -> Option<System> {
        (system.metadata.uid == self.uid).then_some(system)
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
