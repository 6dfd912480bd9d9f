//! The relay of a node that is reached by SSH alone: one process on this machine that holds the session, the agent on the other
//! side, and the node's socket here.
//!
//! The controller finds the node's agent at `run/<node>/agent.sock`, as it finds a local one. Commands hold the relay awake by
//! a connection to `run/<node>/relay.sock`; some time after the last of them it ends, and with it the agent over there.
//! Managers go on. Nothing that the other side says is trusted: of the controller it reaches its own session alone.

mod awake;
mod config;
mod life;
mod link;
mod log;
mod modules;
mod reach;
mod run;
mod session_api;

pub use awake::State;
pub use config::{Config, lease};
pub use reach::ReachError;
pub use run::run;
