//! The agent as its controller and people see it: over HTTP, with real processes that speak the control protocol.
// A failure in a test's own helper is a failed test.
#![allow(clippy::unwrap_used)]

mod acts;
mod adopt;
mod agent_process;
mod batches;
mod by_hand;
mod cgroups;
mod fake_controller;
mod fake_machine;
mod fake_manager;
mod hanging;
mod heal;
mod in_process;
mod leaks;
mod life;
mod node_spec;
mod peers;
mod policies;
mod real_manager;
mod run_folder;
mod session;
mod setup;
mod versions;
mod zygote;
