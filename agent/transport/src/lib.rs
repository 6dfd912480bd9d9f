//! How the samples of one connector travel: one [`Sender`], one [`Receiver`], whatever is between them.
//!
//! | transport | between | what it is |
//! |---|---|---|
//! | [`inproc`] | two threads of a process | a ring of payloads; nothing is copied, no lock is taken |
//! | [`shm`] | processes of a machine | frames in a ring of shared memory |
//! | [`unix`] | processes of a machine | frames on a Unix socket |
//! | [`tcp`] | machines | the same frames on TCP |
//!
//! A connector with several targets has a pair for each; a payload is shared by all of them. What all transports
//! promise is in the traits, and one suite of tests requires it of each (`tests/conformance`):
//!
//! - Samples arrive whole, in order, each once, or the connection has ended.
//! - [`Sender::push`] never waits. What there is no room for is refused, and given back: which sample has to go
//!   is decided by the buffer before the transport, not by it.
//! - Each end can tell a good-bye of the other end from its loss, and a [`Handle`] ends a connection whose end waits
//!   in another thread.
//! - A receiver can ask for a sample ([`Question`]); what it is given for that is the business of who uses this.
//! - What comes from another process is never believed: what does not make sense is a loss of the other end.
//!
//! Dialling, and agreeing on what a connection is for, is left to who uses this.

mod ended;
mod ends;
pub mod frame;
pub mod inproc;
mod kind;
mod sample;
pub mod shm;
mod signal;
mod socket;
mod spin;
mod stream;
pub mod tcp;
pub mod unix;

pub use ended::{Ended, Parting, Refused};
pub use ends::{Handle, Question, Receiver, Sender};
pub use kind::{Kind, UnknownKind};
pub use sample::{MAX_SAMPLE, Payload, Sample};
pub use spin::MOST as SPINS;

/// Takes a lock; what a panicked holder left is consistent after each step.
fn lock<T>(mutex: &std::sync::Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}
