//! What is planned, as stories in text; one program for all of them.

// A failure here is a failed test; only the tests read files, the crate does not.
#![allow(clippy::unwrap_used, clippy::disallowed_methods)]

mod between;
mod corpus;
mod drift;
mod export;
mod heals;
mod mends;
mod orders;
mod script;
mod stand_ins;
mod story;
mod transcripts;
#[path = "../world/mod.rs"]
mod world;
