//! Wall time and chance as inputs, so that a simulation can pass its own. Deadlines use tokio's clock, which can be paused.

use jiff::Timestamp;
use rand::Rng as _;

/// Wall-clock time; for display, and for what must be told across a restart.
pub trait Clock: Send + Sync + 'static {
    /// Now.
    fn now(&self) -> Timestamp;
}

/// Chance.
pub trait Chance: Send + Sync + 'static {
    /// A number in 0.0..1.0.
    fn unit(&self) -> f64;
    /// A new UUID.
    fn uuid(&self) -> String;
}

/// The machine's clock.
#[derive(Debug, Clone, Copy, Default)]
pub struct SystemClock;

impl Clock for SystemClock {
    fn now(&self) -> Timestamp {
        Timestamp::now()
    }
}

/// The operating system's chance.
#[derive(Debug, Clone, Copy, Default)]
pub struct SystemChance;

impl Chance for SystemChance {
    fn unit(&self) -> f64 {
        rand::rng().random()
    }

    fn uuid(&self) -> String {
        uuid::Uuid::new_v4().to_string()
    }
}
