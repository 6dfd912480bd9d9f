//! Laws that hold for every plan; one program for all of them.

// A failure here is a failed test.
#![allow(clippy::unwrap_used)]

mod drift_laws;
mod lab;
mod order_laws;
mod plans;
#[path = "../world/mod.rs"]
mod world;
