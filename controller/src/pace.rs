//! How often everything is shown and planned anew. That takes time which grows with what there is, on the one thread that also
//! takes heartbeats and answers: it must never take all of it, or agents are lost and greet again, which is more to show.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::Notify;
use tokio::time::{Instant, sleep_until};

use crate::core::Core;

/// What takes less need not be spared.
const LITTLE: Duration = Duration::from_millis(10);
/// So many times as long as it took, others come first.
const REST: u32 = 2;
/// But no longer than this: who looks wants to see something.
const MOST: Duration = Duration::from_secs(1);

/// When it is time to show everything once more.
#[derive(Default)]
pub struct Pace {
    due: Mutex<Option<Instant>>,
    late: Notify,
}

impl Pace {
    /// It was done and took from then until now. In simulated time nothing takes any.
    pub fn took(&self, since: Instant) {
        let now = Instant::now();
        *self.due.lock().unwrap_or_else(PoisonError::into_inner) = next(since, now);
    }

    /// When it may be done again; none for now.
    pub fn due(&self) -> Option<Instant> {
        let due = *self.due.lock().unwrap_or_else(PoisonError::into_inner);
        due.filter(|due| *due > Instant::now())
    }

    /// Waits for that.
    pub async fn rest(&self) {
        if let Some(due) = self.due() {
            sleep_until(due).await;
        }
    }
}

fn next(since: Instant, now: Instant) -> Option<Instant> {
    let took = now.duration_since(since);
    (took > LITTLE).then(|| now + (took * REST).min(MOST))
}

impl Core {
    /// Shows everything: now when it takes little, else once others had their turn, for all that ask meanwhile together.
    pub fn publish_soon(&self) {
        match self.pace.due() {
            None => self.publish(),
            Some(_) => self.pace.late.notify_one(),
        }
    }
}

/// Shows what [`Core::publish_soon`] has put off, for ever.
pub async fn publish_late(core: Arc<Core>) {
    loop {
        core.pace.late.notified().await;
        core.pace.rest().await;
        core.publish();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn what_takes_long_gives_others_their_turn() {
        let now = Instant::now();
        let after = |ms| next(now, now + Duration::from_millis(ms)).map(|due| due - now);
        assert_eq!(after(0), None);
        assert_eq!(after(10), None);
        assert_eq!(after(100), Some(Duration::from_millis(300)));
        assert_eq!(after(4000), Some(Duration::from_millis(5000)));
        let pace = Pace::default();
        assert_eq!(pace.due(), None);
        tokio::time::advance(Duration::from_millis(100)).await;
        pace.took(now);
        let due = pace.due().unwrap();
        pace.rest().await;
        assert_eq!((Instant::now() >= due, pace.due()), (true, None));
    }
}
