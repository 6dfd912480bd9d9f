//! The one event loop of a run.

use tokio::runtime::{Builder, Runtime};

use crate::seed::Seed;

/// An event loop whose clock is paused. Which of several waiters is woken first is chance too, and follows from the seed:
/// built without `--cfg tokio_unstable`, two runs may differ in that.
///
/// # Errors
/// The system has no thread-local storage or no memory left.
pub fn event_loop(seed: Seed) -> std::io::Result<Runtime> {
    let mut builder = Builder::new_current_thread();
    builder.enable_time().start_paused(true);
    #[cfg(tokio_unstable)]
    builder.rng_seed(tokio::runtime::RngSeed::from_bytes(&seed.0.to_le_bytes()));
    #[cfg(not(tokio_unstable))]
    let _ = seed;
    builder.build()
}
