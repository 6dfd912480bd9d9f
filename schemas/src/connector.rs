//! What the properties of a data connector say: how samples travel, where they wait, and what happens when there is no
//! room or nothing to read. The names are those of OpenRTM-aist; docs/connectors.md has them as a table.

mod names;
mod reach;
mod read;

use std::time::Duration;

use crate::cdr::Endian;

pub use names::meant;
pub use reach::{Distance, OutOfReach};
pub use read::{Fault, read};

/// Samples that a buffer keeps when nothing is said of it.
pub const DEFAULT_LENGTH: usize = 64;
/// Most samples that a buffer may be told to keep.
pub const LONGEST_BUFFER: usize = 65_536;
/// How long a write or read waits when nothing is said of it.
pub const DEFAULT_TIMEOUT: Duration = Duration::from_secs(1);
/// The longest that a write or read may be told to wait; also what `0`, OpenRTM's word for no time-out, stands for.
pub const LONGEST_TIMEOUT: Duration = Duration::from_secs(60);
/// The highest rate of a periodic connector in hertz.
pub const HIGHEST_RATE: f64 = 100_000.0;
/// The lowest: one sample in an hour, and a bit less.
pub const LOWEST_RATE: f64 = 0.000_25;

/// A data connector's properties, read.
#[derive(Debug, Clone, PartialEq)]
pub struct ConnectorSettings {
    /// Who moves a sample: its writer or its reader.
    pub dataflow: Dataflow,
    /// When a sample is sent, of a connector that pushes.
    pub subscription: Subscription,
    /// What reaches the other end.
    pub interface: Interface,
    /// Order of the bytes of samples between two processes.
    pub endian: Endian,
    /// At the out-port end.
    pub out_buffer: BufferSettings,
    /// At the in-port end.
    pub in_buffer: BufferSettings,
}

/// Who moves a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dataflow {
    /// The out-port end sends.
    Push,
    /// The in-port end fetches when its component reads.
    Pull,
}

/// When a connector that pushes sends a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Subscription {
    /// In the writer's own call (`flush`, and `block` of OpenRTM 2), also when nothing is said.
    Flush,
    /// From a buffer, soon after each write (`new`, and `nonblock` of OpenRTM 2).
    New(PushPolicy),
    /// From a buffer, at a rate of its own.
    Periodic {
        /// Between two pushes.
        period: Duration,
        /// What is sent then.
        policy: PushPolicy,
    },
}

/// Which of the samples in its buffer a publisher sends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PushPolicy {
    /// All that wait.
    All,
    /// The oldest one.
    Fifo,
    /// One after each so many that are passed over.
    Skip(u32),
    /// The newest one; older ones are passed over.
    New,
}

/// What a connector travels by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interface {
    /// The best that reaches the other end.
    Best,
    /// A function call inside one process.
    Direct,
    /// Memory that two processes of a machine share.
    SharedMemory,
    /// A Unix socket.
    Unix,
    /// TCP.
    Tcp,
}

/// A buffer's properties, read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BufferSettings {
    /// Samples that it keeps.
    pub length: usize,
    /// What a write into a full one does.
    pub full: FullPolicy,
    /// What a read from an empty one does.
    pub empty: EmptyPolicy,
    /// Of a read, whatever the policy: a reader that fetches waits as long for the other end.
    pub read_timeout: Duration,
}

/// What a write into a full buffer does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FullPolicy {
    /// The oldest sample goes.
    Overwrite,
    /// The new sample goes.
    DoNothing,
    /// Waits for room; then the new sample goes.
    Block(Duration),
}

/// What a read from an empty buffer does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EmptyPolicy {
    /// Gives the sample that was read last.
    Readback,
    /// Gives nothing.
    DoNothing,
    /// Waits for a sample; then gives nothing.
    Block(Duration),
}

impl Default for BufferSettings {
    fn default() -> Self {
        Self {
            length: DEFAULT_LENGTH,
            full: FullPolicy::Overwrite,
            empty: EmptyPolicy::DoNothing,
            read_timeout: DEFAULT_TIMEOUT,
        }
    }
}

impl Default for ConnectorSettings {
    /// What holds when nothing is said.
    fn default() -> Self {
        Self {
            dataflow: Dataflow::Push,
            subscription: Subscription::Flush,
            interface: Interface::Best,
            endian: Endian::Little,
            out_buffer: BufferSettings::default(),
            in_buffer: BufferSettings::default(),
        }
    }
}
