//! Carries a plan out: one batch per node, results as they come, gates between nodes. It chooses nothing.

mod cut;
mod deadline;
mod follow;
mod run;

pub use self::deadline::StartTimeouts;
pub use self::run::{Accepted, Executor, Peer, SharedProgress, step};
