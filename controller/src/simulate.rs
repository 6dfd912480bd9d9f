//! Plays a change through in a simulation: gathers what there is, and lets the simulator work on a thread of its own.

mod scenario;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;

use rts_controller_api::Problem;
use rts_controller_api::simulate::{MAX_LIMIT, SimulateRequest, Simulated};
use tokio::sync::oneshot;

use crate::admit;
use crate::core::Core;
use crate::simulator::{Scenario, Simulator, Stop};

/// Longest time that a simulation may take.
const WALL: Duration = Duration::from_secs(20);
/// After that, time for it to tell what it has.
const LAST_WORD: Duration = Duration::from_secs(5);
/// Stack of its thread in bytes: debug builds nest deep.
pub const STACK: usize = 16 * 1024 * 1024;
/// Most faults.
const MAX_FAULTS: usize = 100;
/// Longest text of a fault.
const MAX_FAULT: usize = 500;

/// What would happen if this were applied and these faults came. Nothing changes.
pub async fn simulate(
    core: &Arc<Core>,
    name: &str,
    request: SimulateRequest,
) -> Result<Simulated, Problem> {
    within_bounds(&request)?;
    let permit = Arc::clone(&core.simulation).try_acquire_owned();
    let permit = permit.map_err(|_| busy())?;
    let admitted = admit::admit(core, name, &request.apply()).await?;
    let scenario = scenario::gather(core, &admitted.record, &request).await;
    let told = Told(scenario.stop.clone());
    let (answer, answered) = oneshot::channel();
    let simulator = Arc::clone(&core.simulator);
    let work = move || {
        let result = quietly(simulator.as_ref(), &scenario);
        // Who has the answer may ask for the next at once.
        drop(permit);
        // Whoever asked may have gone.
        let _ = answer.send(result);
    };
    let thread = std::thread::Builder::new().name("simulation".to_owned());
    thread.stack_size(STACK).spawn(work).map_err(|e| {
        Problem::unavailable("no-thread", format!("cannot start a thread for it: {e}"))
    })?;
    tokio::pin!(answered);
    let mut result = tokio::time::timeout(WALL, &mut answered).await;
    if result.is_err() {
        // What it has by now is better than nothing.
        told.0.hurry();
        result = tokio::time::timeout(LAST_WORD, answered).await;
    }
    drop(told);
    match result {
        Ok(Ok(result)) => result,
        Ok(Err(_)) => Err(Problem::internal("the simulation gave no answer")),
        Err(_) => Err(late()),
    }
}

/// Stops the simulation when nobody waits for it any more.
struct Told(Stop);

impl Drop for Told {
    fn drop(&mut self) {
        self.0.stop();
    }
}

/// Plays a scenario through without a word in the log: what happens in a simulation happens to nobody.
pub fn quietly(simulator: &dyn Simulator, scenario: &Scenario) -> Result<Simulated, Problem> {
    let nobody = tracing::subscriber::NoSubscriber::new();
    let work = || catch_unwind(AssertUnwindSafe(|| simulator.simulate(scenario)));
    tracing::subscriber::with_default(nobody, work).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or(panic.downcast_ref::<&str>().copied());
        let text = text.unwrap_or("no word of it");
        let detail = format!(
            "the simulation panicked with seed {}: {text}",
            scenario.seed
        );
        Err(Problem::internal(detail))
    })
}

fn within_bounds(request: &SimulateRequest) -> Result<(), Problem> {
    let refused = |detail| Err(Problem::invalid("bad-fault", detail));
    if request.faults.len() > MAX_FAULTS {
        let count = request.faults.len();
        return refused(format!("{count} faults; at most {MAX_FAULTS} are taken"));
    }
    if let Some(long) = request.faults.iter().find(|f| f.len() > MAX_FAULT) {
        let length = long.len();
        return refused(format!(
            "a fault of {length} bytes; at most {MAX_FAULT} are taken"
        ));
    }
    match request.limit_seconds {
        Some(limit) if limit == 0 || limit > MAX_LIMIT => Err(Problem::invalid(
            "bad-limit",
            format!("{limit} s cannot be simulated: 1 to {MAX_LIMIT} can"),
        )),
        _ => Ok(()),
    }
}

fn busy() -> Problem {
    let detail = "another simulation runs; one at a time is played through";
    Problem::unavailable("simulation-busy", detail)
}

fn late() -> Problem {
    let detail = format!(
        "the simulation did not end within {} s; simulate less time, or fewer faults",
        WALL.as_secs()
    );
    Problem::new(504, "deadline", "too slow", detail)
}
