//! Faults that other tools had. Each story is a schedule that leads right into one of them; all invariants are watched in
//! it from its begin to the last thing that is taken down, and each story looks at what it is about besides.

// A failure here is a failed test.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod away;
mod between;
mod cable;
mod comes_back;
mod interrupted;
mod orders;
mod play;
mod reconnect;
mod replaced;
mod stores;
mod teardown;
