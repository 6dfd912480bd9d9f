//! Carries a plan out: one batch per node, results as they come, gates between nodes. It chooses nothing.

mod cut;
mod run;

pub use self::run::{Executor, Peer};
