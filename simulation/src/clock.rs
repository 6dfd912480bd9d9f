//! Wall time: the time of the simulation on top of a day long ago, and jumps.

use std::sync::{Arc, Mutex, PoisonError};

use jiff::{SignedDuration, Timestamp};
use rts_host::clock::Clock;
use tokio::time::Instant;

/// When every run begins, in seconds since 1970: 2026-01-01T00:00:00Z.
const BEGIN: i64 = 1_767_225_600;

/// The wall clock of one host. Clones are the same clock.
#[derive(Debug, Clone)]
pub struct SimClock {
    begin: Instant,
    jumped: Arc<Mutex<SignedDuration>>,
}

impl SimClock {
    /// A clock of a run that began then.
    pub fn new(begin: Instant) -> Self {
        Self {
            begin,
            jumped: Arc::default(),
        }
    }

    /// Sets it forward, or back.
    pub fn jump(&self, by: SignedDuration) {
        let mut jumped = self.jumped.lock().unwrap_or_else(PoisonError::into_inner);
        *jumped = jumped.saturating_add(by);
    }
}

impl Clock for SimClock {
    fn now(&self) -> Timestamp {
        let begin = Timestamp::from_second(BEGIN).unwrap_or(Timestamp::UNIX_EPOCH);
        let elapsed = SignedDuration::try_from(self.begin.elapsed()).unwrap_or_default();
        let jumped = *self.jumped.lock().unwrap_or_else(PoisonError::into_inner);
        begin
            .saturating_add(elapsed.saturating_add(jumped))
            .unwrap_or(begin)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[tokio::test(start_paused = true)]
    async fn it_goes_with_the_run_and_jumps() {
        let clock = SimClock::new(Instant::now());
        tokio::time::advance(Duration::from_secs(2)).await;
        assert_eq!(clock.now().to_string(), "2026-01-01T00:00:02Z");
        clock.jump(SignedDuration::from_secs(-3600));
        assert_eq!(clock.now().to_string(), "2025-12-31T23:00:02Z");
    }
}
