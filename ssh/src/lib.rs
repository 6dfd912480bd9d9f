//! Sessions with a machine that is reached by SSH: one multiplexed connection of the user's own `ssh`, files that are copied by
//! their digest, and programs that run there.
//!
//! The far side needs nothing but a POSIX shell. What it says is not trusted: every answer is bounded, and no path or text of it
//! becomes a part of a command unquoted. The user's own settings, agent and jump hosts are used; the host key is always checked.
//! What a session is for is left to others.

mod answer;
mod child;
mod destination;
mod diagnose;
mod error;
mod log;
mod machine;
mod master;
mod remote;
mod session;
mod store;
mod survey;

pub use child::Child;
pub use destination::{Destination, HostKeys};
pub use error::{Kind, SshError};
pub use machine::machine_of;
pub use remote::Ran;
pub use session::Session;
pub use store::{LocalFile, Stored, StoredFile, digest_of};
pub use survey::{MAX_SURVEY, Survey, Systemd};
