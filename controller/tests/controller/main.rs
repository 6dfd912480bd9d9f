//! The controller in one program: a test program of its own for each file would link everything each time.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod acts;
mod at_once;
mod by_hand;
mod durable;
mod expect;
mod fleet;
mod http;
mod killed;
mod lagging;
mod ledgers;
mod mends;
mod moves;
mod openapi;
mod optional;
mod orders;
mod reconcile;
mod refusals;
mod simulate;
mod stand_ins;
mod told;
mod tombstones;
mod two_ledgers;
