//! Work that grows with the size of systems, off the event loop where that is large: heartbeats, health and watches are
//! answered meanwhile. What is small is done at once: a thread would take longer to wake.

use std::future::pending;
use std::panic::resume_unwind;

use tokio::sync::Semaphore;
use tokio::task::spawn_blocking;

/// Components from which on work is given to a thread: a first plan of them takes about ten milliseconds (`cargo xtask bench plan`).
const LARGE: usize = 500;
/// So much of it is done at a time: each holds a picture of all systems.
static TURNS: Semaphore = Semaphore::const_new(4);

/// Does work on so many components. Its order among other work is that of its caller, who awaits it.
pub async fn off_loop<T: Send + 'static>(
    components: usize,
    work: impl FnOnce() -> T + Send + 'static,
) -> T {
    if components < LARGE {
        return work();
    }
    // It is never closed.
    let _turn = TURNS.acquire().await;
    match spawn_blocking(work).await {
        Ok(done) => done,
        Err(error) => match error.try_into_panic() {
            Ok(panic) => resume_unwind(panic),
            // The program ends, and its tasks with it.
            Err(_) => pending().await,
        },
    }
}

#[cfg(test)]
mod tests {
    use std::thread::current;

    use super::*;

    #[tokio::test]
    async fn only_what_is_large_leaves_the_loop() {
        let here = current().id();
        assert_eq!(off_loop(LARGE - 1, || current().id()).await, here);
        assert_ne!(off_loop(LARGE, || current().id()).await, here);
    }
}
