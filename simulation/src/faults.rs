//! What can go wrong in a run, and when.

use std::time::Duration;

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

/// When something is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum When {
    /// At this time of the run.
    At(Duration),
    /// As soon as the step with this number of the plan that is looked at has begun; 0 before the first.
    Step(u32),
}

/// How a component misbehaves. The names are those of the parameter `fault` of the component `Misbehaving`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Misbehaviour {
    /// Its process ends while it is created.
    CrashAtOnce,
    /// Its process ends some time after it was activated.
    CrashLater,
    /// `on_initialize` does not return.
    HangInitialize,
    /// `on_activated` does not return.
    HangActivate,
    /// `on_execute` does not return.
    HangExecute,
    /// `on_deactivated` does not return.
    HangDeactivate,
    /// `on_finalize` does not return.
    HangFinalize,
    /// `on_initialize` returns ERROR.
    ErrorInitialize,
    /// `on_activated` returns ERROR.
    ErrorActivate,
    /// `on_execute` returns ERROR some time after it was activated.
    ErrorExecute,
    /// It panics in `on_execute`.
    Panic,
    /// `on_deactivated` returns ERROR.
    IgnoreDeactivate,
    /// It needs 2 s to activate.
    SlowActivate,
}

/// Something that goes wrong.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", rename_all_fields = "camelCase")]
pub enum Fault {
    /// The program crashes (`controller`, or the agent of a node) and starts again after a while; none for never.
    Crash {
        /// Host.
        host: String,
        /// Passages to the outside until the crash; 0 for at once.
        calls: u64,
        /// Time until it starts again.
        down: Option<Duration>,
    },
    /// The machine of a node loses power, and comes back.
    Reboot {
        /// Node.
        node: String,
        /// Time until its agent starts again.
        down: Duration,
    },
    /// Nothing that `from` says reaches `to`.
    Cut {
        /// Host.
        from: String,
        /// Host.
        to: String,
        /// How long; none for ever.
        lasts: Option<Duration>,
    },
    /// Messages between controller and agents are lost, held up, doubled or come in another order.
    Weather {
        /// Parts of a thousand that are lost.
        lost: u32,
        /// Parts of a thousand that come twice.
        doubled: u32,
        /// Longest delay of a message.
        delay: Duration,
        /// How long.
        lasts: Duration,
    },
    /// Writes of a host fail.
    DiskFails {
        /// Host.
        host: String,
        /// How long.
        lasts: Duration,
    },
    /// Writes of a host take long.
    DiskSlow {
        /// Host.
        host: String,
        /// Longest time of one write.
        delay: Duration,
        /// How long.
        lasts: Duration,
    },
    /// The wall clock of a host jumps.
    ClockJumps {
        /// Host.
        host: String,
        /// By how much.
        by: SignedDuration,
    },
    /// A manager's process dies. By its display name (`hello.main`), or any of the node's.
    ManagerDies {
        /// Node.
        node: String,
        /// Display name; none for any.
        manager: Option<String>,
    },
    /// A manager's process stops answering, and does not die of SIGTERM.
    ManagerHangs {
        /// Node.
        node: String,
        /// Display name; none for any.
        manager: Option<String>,
    },
    /// The next processes on a node end before they say Hello.
    ManagersFailToStart {
        /// Node.
        node: String,
        /// How long.
        lasts: Duration,
    },
    /// The module of a type cannot be loaded.
    ModuleFails {
        /// Node.
        node: String,
        /// Type name.
        type_name: String,
        /// How long; none for ever.
        lasts: Option<Duration>,
    },
    /// A component misbehaves from now on, also after it was made anew.
    Misbehaves {
        /// Instance name.
        instance: String,
        /// How.
        how: Misbehaviour,
        /// How long; none for ever.
        lasts: Option<Duration>,
    },
    /// A controller that was started from a backup takes over, while the one before goes on and knows nothing of it.
    Usurper,
}

/// A fault and its time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Timed {
    /// When.
    pub when: When,
    /// What.
    pub fault: Fault,
}
