//! Turns at the configurations of components, and at connectors.
//!
//! A mark is read, added to and sent back: by a person, by a plan, and when it is stale. Whoever does so is alone with
//! that component meanwhile, so that nothing of a mark is lost. In the same way, an in-port end is not unbound while a
//! person connects it.

use tokio::sync::{Mutex, MutexGuard};

/// So many at most at the same time: some components, or connectors, share a turn.
const TURNS: usize = 16;

/// Who may change a configuration and its mark. Nobody holds more than one.
#[derive(Debug, Default)]
pub struct Turns {
    all: [Mutex<()>; TURNS],
}

impl Turns {
    /// Waits for the turn at a component or connector.
    pub async fn at(&self, name: &str) -> MutexGuard<'_, ()> {
        let bytes = name.bytes();
        let sum = bytes.fold(0_usize, |sum, byte| {
            sum.wrapping_mul(31).wrapping_add(usize::from(byte))
        });
        self.all[sum % TURNS].lock().await
    }
}
