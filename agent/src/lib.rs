//! The agent of a node: keeps what its controller told it, starts and watches manager processes, carries out batches of
//! steps, and says what really runs.
//!
//! It owns no component: managers live on when it ends, and are adopted again when it starts.

mod agent;
mod api;
mod batches;
mod by_hand;
mod config;
mod events;
mod execute;
mod folders;
mod heal;
mod inputs;
mod inventory;
pub mod launch;
mod ledger;
mod log_mark;
mod log_name;
mod log_tail;
pub mod machine;
mod manager_link;
mod managers;
mod modules;
mod node_lock;
mod pidfd;
mod policies;
mod process;
mod restarts;
mod run;
mod session;

pub use agent::StartError;
pub use config::Config;
pub use inputs::Inputs;
pub use run::{RunError, Running, openapi, run, start};
