//! Deterministic simulation: the real controller and the real agents over a simulated clock, network, disk and machines.
//!
//! One thread and one event loop whose clock is paused: time passes only when nobody has anything to do, and then jumps to
//! the next timer. All chance comes from one [`Seed`], so that a seed replays exactly. A program that crashes is one whose
//! [`Life`] has ended: its calls to the outside never return.

pub mod clock;
pub mod faults;
pub mod life;
pub mod seed;
pub mod truth;

pub use clock::SimClock;
pub use life::Life;
pub use seed::{Seed, Stream};
pub use truth::{Cause, Happened, Truth};
