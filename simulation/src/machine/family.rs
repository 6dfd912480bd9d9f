//! A process and what it started, as an agent has them.

use std::sync::Arc;
use std::time::Duration;

use futures_util::future::BoxFuture;
use rts_agent::launch::{Exit, ExitFuture};
use rts_agent::machine::{Family, Signal};

use super::Shared;
use super::handle::Handle;
use super::shutdown;
use super::state::Run;
use crate::life::Life;
use crate::truth::Cause;

/// SIGKILL.
const KILLED: i32 = 9;

/// A family in the hands of one life of an agent.
#[derive(Clone)]
pub(super) struct SimFamily {
    pub handle: Handle,
    pub pid: u32,
    pub life: Life,
}

impl std::fmt::Debug for SimFamily {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "SimFamily({})", self.pid)
    }
}

impl SimFamily {
    fn shared(&self) -> &Arc<Shared> {
        &self.handle.shared
    }

    fn kill(&self) {
        let number = self.handle.number;
        self.shared().change(|state| {
            state.end(number, Exit::Signal(KILLED), Cause::Asked);
            state.kill_grandchildren(number);
        });
    }

    /// Waits for its end. Whoever started it kills the rest of its group then.
    pub fn exit(&self, is_child: bool) -> ExitFuture {
        let (family, number) = (self.clone(), self.handle.number);
        Box::pin(async move {
            let ended = async {
                let exit = family.handle.exit().await;
                family.shared().pause(100, 2_000).await;
                if !is_child {
                    return Exit::Unknown;
                }
                let shared = family.shared();
                shared.change(|state| state.kill_grandchildren(number));
                exit
            };
            family.life.call(ended).await
        })
    }
}

impl Family for SimFamily {
    fn pid(&self) -> u32 {
        self.pid
    }

    fn has_ended(&self) -> bool {
        self.handle.has_ended()
    }

    fn signal(&self, signal: Signal) -> BoxFuture<'_, ()> {
        let number = self.handle.number;
        Box::pin(self.life.call(async move {
            self.shared().pause(50, 500).await;
            match signal {
                Signal::Kill => self.kill(),
                Signal::Term => {
                    shutdown::term(&self.handle);
                    let shared = self.shared();
                    shared.change(|state| state.kill_grandchildren(number));
                }
                // Who hangs here does not go on for that.
                Signal::Cont => {}
            }
        }))
    }

    fn end(&self, _limit: Duration) -> BoxFuture<'_, bool> {
        Box::pin(self.life.call(async move {
            self.shared().pause(50, 500).await;
            self.kill();
            self.shared().pause(100, 3_000).await;
            true
        }))
    }
}

impl Handle {
    /// True when the process has ended.
    pub fn has_ended(&self) -> bool {
        matches!(self.now(), Run::Ended(_))
    }

    /// Waits for its end, and gives how it was.
    async fn exit(&self) -> Exit {
        self.ended().await;
        match self.now() {
            Run::Ended(exit) => exit,
            Run::Runs | Run::Hangs => Exit::Unknown,
        }
    }
}
