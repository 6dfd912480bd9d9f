//! How long the controller could not hear anybody, since its one thread was busy. Heartbeats that nobody read meanwhile are no
//! sign that their nodes are lost: a controller that blames others for its own delay makes all of them greet again, which
//! delays it more.

use std::time::Duration;

use tokio::time::Instant;

/// It is looked this often; what takes no longer than two of them is no deafness.
const TICK: Duration = Duration::from_millis(500);

/// When it was last looked.
#[derive(Debug)]
pub struct Hearing(Instant);

impl Hearing {
    /// It is looked now.
    pub fn new() -> Self {
        Self(Instant::now())
    }

    /// How long nobody could be heard since the last look.
    pub fn deaf(&mut self) -> Duration {
        let now = Instant::now();
        let since = std::mem::replace(&mut self.0, now);
        now.duration_since(since).saturating_sub(2 * TICK)
    }

    /// When it is to be looked again.
    pub fn next(&self) -> Instant {
        self.0 + TICK
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn only_what_comes_much_too_late_is_deafness() {
        let mut hearing = Hearing::new();
        tokio::time::sleep_until(hearing.next()).await;
        assert_eq!(hearing.deaf(), Duration::ZERO);
        tokio::time::advance(2 * TICK).await;
        assert_eq!(hearing.deaf(), Duration::ZERO);
        tokio::time::advance(Duration::from_secs(5)).await;
        assert_eq!(hearing.deaf(), Duration::from_secs(4));
        assert_eq!(hearing.deaf(), Duration::ZERO, "it is told once");
    }
}
