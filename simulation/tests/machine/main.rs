//! A real agent on a simulated machine and disk.
// A failure in a test's own helper is a failed test.
#![allow(clippy::unwrap_used)]

mod setup;
mod single;
mod turmoil;
