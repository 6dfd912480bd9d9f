//! The machine of a node: run folders, manager processes and what is in them, modules. It survives the lives of the agents
//! that use it. Managers speak the real control protocol and do what a real one does, in their own time.

mod callback;
mod component;
mod configuration;
mod connection;
mod connectors;
mod count;
mod create;
mod end;
mod family;
mod far;
mod fault;
mod grip;
mod handle;
mod inventory;
mod left;
mod links;
mod loss;
mod process;
mod request;
mod shutdown;
mod state;
#[cfg(test)]
mod tests;
mod wire;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use rts_agent::machine::Machine;
use rts_host::clock::{Chance, Clock};
use tokio::sync::watch;
use tokio::time::Instant;

use self::far::Neighbours;
use self::handle::Handle;
pub use self::left::{LeftOver, Really};
use self::state::State;
use crate::clock::SimClock;
use crate::life::Life;
use crate::modules::Modules;
use crate::seed::{Seed, Stream};
use crate::truth::Truth;

/// Probability that a process starts one of its own, unless it is said otherwise.
const GRANDCHILDREN: f64 = 0.25;

/// The machine of one node. Clones are the same machine.
#[derive(Debug, Clone)]
pub struct SimMachine(Arc<Shared>);

struct Shared {
    clock: SimClock,
    truth: Truth,
    streams: Streams,
    state: Mutex<State>,
    /// All machines; none for one by itself.
    neighbours: OnceLock<Arc<Neighbours>>,
    /// Counts changes of what misbehaves.
    misbehaviour: watch::Sender<u64>,
}

impl std::fmt::Debug for Shared {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.state.fmt(f)
    }
}

/// Chance, by purpose.
struct Streams {
    ids: Stream,
    times: Stream,
    faults: Stream,
}

impl SimMachine {
    /// The machine of a node, on which nothing runs.
    pub fn new(node: &str, seed: Seed, clock: SimClock, truth: Truth) -> Self {
        let stream = |purpose: &str| seed.stream(&format!("machine/{node}/{purpose}"));
        let streams = Streams {
            ids: stream("ids"),
            times: stream("times"),
            faults: stream("faults"),
        };
        let state = State {
            node: node.to_owned(),
            boot_id: streams.ids.uuid(),
            pid: state::FIRST_PID,
            numbers: 0,
            folders: BTreeMap::new(),
            processes: BTreeMap::new(),
            logs: BTreeMap::new(),
            modules: Modules::default(),
            misbehaviours: BTreeMap::new(),
            fails_to_start: false,
            grandchildren: GRANDCHILDREN,
            news: Vec::new(),
            losses: Vec::new(),
            parted: Vec::new(),
            counted: Instant::now(),
        };
        Self(Arc::new(Shared {
            clock,
            truth,
            streams,
            state: Mutex::new(state),
            neighbours: OnceLock::new(),
            misbehaviour: watch::Sender::new(0),
        }))
    }

    /// The machine as one life of an agent has it.
    pub fn grip(&self, life: Life) -> Arc<dyn Machine> {
        Arc::new(grip::Grip {
            shared: self.0.clone(),
            life,
        })
    }
}

impl Shared {
    /// Looks at everything, or changes it, and tells what has happened thereby.
    fn change<T>(self: &Arc<Self>, change: impl FnOnce(&mut State) -> T) -> T {
        let (done, news, losses, parted) = {
            let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
            state.count();
            let done = change(&mut state);
            let losses = std::mem::take(&mut state.losses);
            let losses = losses.into_iter().filter_map(|loss| {
                let process = state.processes.get(&loss.at.process)?;
                Some((Handle::new(self.clone(), process), loss))
            });
            let losses: Vec<_> = losses.collect();
            let parted = std::mem::take(&mut state.parted);
            (done, std::mem::take(&mut state.news), losses, parted)
        };
        // Without the lock: a witness may look at the machine.
        for happened in &news {
            self.truth.tell(happened);
        }
        for (handle, loss) in losses {
            handle.spawn(handle.clone().attend(loss));
        }
        self.tell(parted);
        done
    }

    /// Some time, in microseconds from and to.
    async fn pause(&self, low: u64, high: u64) {
        let time = self.streams.times.between(low, high);
        tokio::time::sleep(Duration::from_micros(time)).await;
    }

    /// Now, for people.
    fn now(&self) -> String {
        format!("{:.3}", self.clock.now())
    }
}
