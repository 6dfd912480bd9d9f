//! The agent of a node: keeps what its controller told it, starts and watches manager processes, carries out batches of
//! steps, and says what really runs.
//!
//! It owns no component: managers live on when it ends, and are adopted again when it starts.

mod agent;
mod api;
mod batches;
mod bind;
mod by_hand;
mod config;
mod events;
mod execute;
#[cfg(test)]
mod fixtures;
mod folders;
mod heal;
mod inputs;
mod inventory;
pub mod launch;
mod ledger;
mod local;
mod log_mark;
mod log_name;
mod log_tail;
pub mod machine;
mod manager_link;
mod managers;
mod modules;
pub mod peers;
mod policies;
mod restarts;
mod run;
mod serve;
mod session;
mod start;
mod stdio;
mod tap;

pub use agent::StartError;
pub use config::Config;
pub use folders::is_node_name;
pub use inputs::Inputs;
pub use ledger::newest as newest_ledger;
pub use local::LocalAgent;
pub use machine::ModuleFinder;
pub use run::{RunError, openapi, run};
pub use serve::{Serving, serve};
pub use start::{Running, start};
pub use stdio::{StdioError, run_stdio};
