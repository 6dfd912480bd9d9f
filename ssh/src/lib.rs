//! Sessions with a machine that is reached by SSH: one multiplexed connection of the user's own `ssh`, files that are copied by
//! their digest, and programs that run there.
//!
//! The far side needs nothing but a POSIX shell. What it says is not trusted: every answer is bounded, and no path or text of it
//! becomes a part of a command unquoted. The user's own settings, agent and jump hosts are used; the host key is always checked.
//! What a session is for is left to others, but for one thing: an agent that is installed as a service ([`bootstrap`]).

#![cfg_attr(
    not(feature = "session"),
    allow(dead_code, reason = "some of it is for sessions alone")
)]

mod answer;
pub mod bootstrap;
#[cfg(feature = "session")]
mod child;
mod collected;
#[cfg(feature = "session")]
mod control;
#[cfg(feature = "session")]
mod copies;
mod destination;
#[cfg(feature = "session")]
mod diagnose;
mod error;
#[cfg(feature = "session")]
mod log;
mod machine;
#[cfg(feature = "session")]
mod master;
#[cfg(feature = "session")]
mod remote;
#[cfg(feature = "session")]
mod session;
#[cfg(feature = "session")]
mod store;
mod survey;

#[cfg(feature = "session")]
pub use child::Child;
pub use collected::Collected;
#[cfg(feature = "session")]
pub use copies::{Claim, lease_name};
pub use destination::{Destination, HostKeys};
pub use error::{Kind, SshError};
pub use machine::machine_of;
#[cfg(feature = "session")]
pub use remote::Ran;
#[cfg(feature = "session")]
pub use session::Session;
#[cfg(feature = "session")]
pub use store::{LocalFile, Stored, StoredFile, digest_of};
pub use survey::{MAX_SURVEY, Survey, Systemd};
