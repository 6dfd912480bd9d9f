//! Orders of a profile as stories in text: one for each rule.

// A failure here is a failed test.
#![allow(clippy::unwrap_used)]

mod conditions;
mod elsewhere;
mod going_down;
mod initialising;
mod optional;
mod preferences;
mod tell;
#[path = "../world/mod.rs"]
mod world;
