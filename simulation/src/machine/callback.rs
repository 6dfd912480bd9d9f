//! A call into a component's code, which may take its time, fail, not return, or take the whole process down.

use std::future::pending;

use rts_agent::launch::Exit;

use super::handle::Handle;
use super::state::At;
use crate::faults::Misbehaviour;
use crate::truth::Cause;

/// How SIGABRT ends a process.
pub(super) const ABORTED: Exit = Exit::Signal(6);
/// What a slow activation takes, in microseconds.
const SLOW: u64 = 2_000_000;

/// What a misbehaviour makes of a callback.
enum Deed {
    Well,
    Slow,
    Fails,
    Hangs,
    Crashes,
}

fn deed(how: Option<Misbehaviour>, callback: &str) -> Deed {
    use Misbehaviour as M;
    match (how, callback) {
        (Some(M::CrashAtOnce), "on_initialize") => Deed::Crashes,
        (Some(M::HangInitialize), "on_initialize")
        | (Some(M::HangActivate), "on_activated")
        | (Some(M::HangDeactivate), "on_deactivated")
        | (Some(M::HangFinalize), "on_finalize") => Deed::Hangs,
        (Some(M::ErrorInitialize), "on_initialize")
        | (Some(M::ErrorActivate), "on_activated")
        | (Some(M::IgnoreDeactivate), "on_deactivated") => Deed::Fails,
        (Some(M::SlowActivate), "on_activated") => Deed::Slow,
        _ => Deed::Well,
    }
}

impl Handle {
    /// Calls a callback; the error is what the component says. Had by whoever has the component's turn.
    pub async fn callback(&self, at: &At, callback: &'static str) -> Result<(), String> {
        self.busy(at, Some(callback));
        self.work(50, 1_500).await;
        let how = self.misbehaviour(at);
        let failed = format!("{callback} returned RTC_ERROR");
        let done = match deed(how, callback) {
            Deed::Well => Ok(()),
            Deed::Slow => {
                self.blemish(at, "it is slow to activate");
                self.work(SLOW, SLOW).await;
                Ok(())
            }
            Deed::Fails => {
                self.blemish(at, &failed);
                Err(failed)
            }
            Deed::Hangs => {
                self.hang(at, callback).await;
                Ok(())
            }
            Deed::Crashes => self.crash(at, callback).await,
        };
        self.busy(at, None);
        done
    }

    /// A callback does not return before what misbehaves changes.
    pub async fn hang(&self, at: &At, callback: &'static str) {
        self.blemish(at, &format!("{callback} does not return"));
        let number = self.number;
        self.change(|state| {
            let told = state.component(at).is_some_and(|c| c.is_told());
            if !told {
                // Nobody was told of it, and yet its process may have to go for it.
                let what = format!("{} hangs in it", at.instance);
                state.blemish(number, None, what);
            }
        });
        let how = self.misbehaviour(at);
        let mut changes = self.shared.misbehaviour.subscribe();
        while self.misbehaviour(at) == how {
            if changes.changed().await.is_err() {
                pending::<()>().await;
            }
        }
        self.runs().await;
    }

    /// The component takes the process down.
    pub async fn crash<T>(&self, at: &At, callback: &str) -> T {
        self.blemish(at, &format!("{callback} crashes"));
        let number = self.number;
        self.change(|state| {
            state.blemish(number, None, format!("{} crashes in it", at.instance));
            state.end(number, ABORTED, Cause::Fault);
        });
        pending().await
    }

    /// Shows which callback runs.
    pub fn busy(&self, at: &At, callback: Option<&'static str>) {
        self.change(|state| {
            if let Some(component) = state.component(at) {
                component.busy = callback.map(|c| (c, tokio::time::Instant::now()));
            }
        });
    }

    /// How a component misbehaves now.
    pub fn misbehaviour(&self, at: &At) -> Option<Misbehaviour> {
        self.change(|state| state.misbehaviours.get(&at.instance).copied())
    }

    pub fn blemish(&self, at: &At, what: &str) {
        let number = self.number;
        self.change(|state| state.blemish(number, Some(&at.instance), what.to_owned()));
    }
}
