//! Deterministic simulation: the real controller and the real agents over a simulated clock, network, disk and machines.
//!
//! One thread and one event loop whose clock is paused: time passes only when nobody has anything to do, and then jumps to
//! the next timer. All chance comes from one [`Seed`], so that a seed replays exactly. A program that crashes is one whose
//! [`Life`] has ended: its calls to the outside never return.

pub mod check;
pub mod clock;
pub mod disk;
pub mod event_loop;
pub mod faults;
pub mod fleet;
pub mod life;
pub mod machine;
pub mod minimise;
pub mod modules;
pub mod net;
pub mod program;
pub mod run;
pub mod schedule;
pub mod seed;
pub mod served;
pub mod store;
pub mod trace;
pub mod truth;
pub mod user;
pub mod words;
pub mod workload;
pub mod world;

pub use clock::SimClock;
pub use disk::SimDisk;
pub use life::Life;
pub use machine::SimMachine;
pub use modules::SimModule;
pub use seed::{Seed, Stream};
pub use truth::{Cause, Happened, Truth};
