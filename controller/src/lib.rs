//! The controller: keeps what is desired, asks what is there, and works on the difference until there is none.
//!
//! [`run`] is the program. [`Core`], [`Reconciler`] and [`router`] are its parts, for tests and simulations that
//! pass their own clock, chance, fleet and store.

mod admit;
mod api;
mod apply;
mod change;
mod core;
mod execute;
mod export;
mod fault;
pub mod fleet;
mod forget;
mod greet;
mod hearing;
mod home;
mod json_size;
mod ledger;
mod look;
mod metrics;
mod moved;
mod node_numbers;
mod numbers;
mod observe;
mod off_loop;
mod pace;
mod placement;
mod publish;
mod pulse;
mod reconcile;
pub mod restore;
mod run;
mod sessions;
mod silence;
pub mod simulate;
pub mod simulator;
pub mod store;
mod view;

pub use rts_host::clock;

pub use self::api::{openapi, router};
pub use self::apply::{apply, delete, delete_but};
pub use self::core::{Core, Inputs};
pub use self::greet::{greet, heartbeat};
pub use self::ledger::claim::{adopt, take_over};
pub use self::reconcile::Reconciler;
pub use self::run::{Config, RunError, expire_sessions, run};
