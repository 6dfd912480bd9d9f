//! What really happens, whatever the programs believe. Machines, disks and the network write it; invariants read it.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use rts_agent_api::messages::LedgerFence;
use rts_plan::desired::{ManagerKey, SystemRef};
use tokio::time::Instant;

/// Why something ended or changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// A program asked for it.
    Asked,
    /// A fault of the schedule, or the misbehaviour of the component itself.
    Fault,
    /// Its process ended.
    Died,
}

/// One component, for as long as it lives.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Subject {
    /// Node.
    pub node: String,
    /// Manager.
    pub manager: ManagerKey,
    /// Incarnation of the manager's process.
    pub process: String,
    /// System; none when made by hand.
    pub system: Option<SystemRef>,
    /// Instance name.
    pub instance: String,
    /// Unique id of its creation.
    pub incarnation: String,
    /// As given at creation.
    pub recreate_hash: String,
}

/// Something that happened.
#[derive(Debug, Clone, PartialEq)]
pub enum Happened {
    /// A manager's process began.
    ProcessStarted {
        /// Node.
        node: String,
        /// Manager.
        manager: ManagerKey,
        /// Incarnation.
        process: String,
    },
    /// A manager's process and all that it started are gone.
    ProcessEnded {
        /// Node.
        node: String,
        /// Manager.
        manager: ManagerKey,
        /// Incarnation.
        process: String,
        /// Why: asked for (a shutdown, or a kill of a process that did not hang), or not.
        cause: Cause,
    },
    /// A component was created and is Inactive.
    Created(Subject),
    /// A component is gone.
    Deleted(Subject, Cause),
    /// A component's state changed (`Inactive`, `Active`, `Error`).
    State {
        /// Which.
        of: Subject,
        /// Before.
        from: String,
        /// After.
        to: String,
        /// Why.
        cause: Cause,
    },
    /// A connector was made at its out-port end.
    Connected {
        /// Owner of the out-port.
        of: Subject,
        /// Name.
        connector: String,
    },
    /// A connector is gone at its out-port end.
    Disconnected {
        /// Owner of the out-port.
        of: Subject,
        /// Name.
        connector: String,
        /// Why.
        cause: Cause,
    },
    /// A manager or component was hit by a fault: what is done about it is no disturbance.
    Blemished {
        /// Node.
        node: String,
        /// Incarnation of the process.
        process: String,
        /// Instance; none for the whole process.
        instance: Option<String>,
        /// In words.
        what: String,
    },
    /// An agent acknowledged a set: it must be on its disk by now, and is obeyed from now on.
    LedgerAcked {
        /// Node.
        node: String,
        /// What was stored.
        fence: LedgerFence,
        /// Systems of the set, by uid.
        systems: Vec<String>,
    },
    /// An agent started (its life's number) and read this from its disk.
    LedgerRead {
        /// Node.
        node: String,
        /// None when there was none.
        fence: Option<LedgerFence>,
    },
    /// An agent began a step for this set.
    StepBegan {
        /// Node.
        node: String,
        /// Cluster uid, epoch and generation that the batch was made for.
        cluster: String,
        /// Epoch.
        epoch: u64,
        /// Generation.
        generation: u64,
        /// Kind and target in words.
        step: String,
    },
    /// The controller acknowledged a change of what is desired.
    DesiredAcked {
        /// System name.
        system: String,
        /// Its generation; none once its deletion was asked for.
        generation: Option<u64>,
    },
    /// A controller started and read from its store: system name → generation; none where it is being deleted.
    StoreRead {
        /// Epoch.
        epoch: u64,
        /// What is stored.
        systems: Vec<(String, Option<u64>)>,
    },
    /// A program crashed.
    Crashed {
        /// `controller`, or the agent's node.
        host: String,
        /// Its life.
        life: u32,
    },
    /// A program that was started did not come up.
    DidNotStart {
        /// `controller`, or the agent's node.
        host: String,
        /// Why.
        why: String,
    },
    /// A program started.
    Started {
        /// `controller`, or the agent's node.
        host: String,
        /// Its life.
        life: u32,
    },
    /// A machine lost its power: all its processes are gone, and what its disk had not made durable.
    Rebooted {
        /// Node.
        node: String,
    },
    /// A fault of the schedule, or something that a user did, in words.
    Note(String),
}

/// Sees everything that happens, as it happens.
pub trait Witness: Send {
    /// Something happened at this time of the run.
    fn see(&mut self, at: Duration, what: &Happened);
}

/// Tells what happens to whoever wants to know. Clones are the same.
#[derive(Clone)]
pub struct Truth {
    begin: Instant,
    witnesses: Arc<Mutex<Vec<Box<dyn Witness>>>>,
}

impl Truth {
    /// Of a run that begins now.
    pub fn new() -> Self {
        Self {
            begin: Instant::now(),
            witnesses: Arc::default(),
        }
    }

    /// Time of the run.
    pub fn now(&self) -> Duration {
        self.begin.elapsed()
    }

    /// Adds a witness.
    pub fn show(&self, witness: impl Witness + 'static) {
        self.lock().push(Box::new(witness));
    }

    /// Something happened. Not to be called by a witness.
    pub fn tell(&self, what: &Happened) {
        let at = self.now();
        for witness in self.lock().iter_mut() {
            witness.see(at, what);
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Box<dyn Witness>>> {
        self.witnesses
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

impl Default for Truth {
    fn default() -> Self {
        Self::new()
    }
}
