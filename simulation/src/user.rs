//! A user's own system, played through: the cluster as it is known to the controller, a change of it, and faults in words.

mod apply;
mod asked;
mod end;
mod modules;
mod names;
mod play;
mod record;
mod strike;
#[cfg(test)]
mod tests;
mod world;

pub use self::asked::answer;
use rts_controller::simulator::{Scenario, Simulator};
use rts_controller_api::simulate::Simulated;
use rts_controller_api::{Problem, ProblemError};

use crate::event_loop::event_loop;
use crate::faults::{Fault, Timed};
use crate::seed::Seed;
use crate::words::{self, WordError};

/// Plays scenarios through with the real controller and the real agents.
#[derive(Debug, Clone, Copy, Default)]
pub struct UserSimulator;

impl Simulator for UserSimulator {
    fn simulate(&self, scenario: &Scenario) -> Result<Simulated, Problem> {
        let faults = read(scenario)?;
        let runtime = event_loop(Seed(scenario.seed));
        let runtime = runtime.map_err(|e| Problem::internal(e.to_string()))?;
        runtime.block_on(play::play(scenario, faults))
    }
}

/// All faults, or what is wrong with each that is not understood.
fn read(scenario: &Scenario) -> Result<Vec<Timed>, Problem> {
    let names = names::names(scenario);
    let mut faults = Vec::new();
    let mut wrong = Vec::new();
    for text in &scenario.faults {
        match words::parse(text).and_then(|read| words::settle(text, read, &names)) {
            Ok(read) if read.iter().any(|timed| timed.fault == Fault::Usurper) => {
                wrong.push(WordError {
                    text: text.clone(),
                    at: 0,
                    word: None,
                    expected: "another fault: one controller is simulated here".to_owned(),
                    nearest: None,
                });
            }
            Ok(read) => faults.extend(read),
            Err(error) => wrong.push(error),
        }
    }
    if wrong.is_empty() {
        return Ok(faults);
    }
    Err(refused(&wrong))
}

fn refused(wrong: &[WordError]) -> Problem {
    let errors = wrong.iter().map(|error| ProblemError {
        pointer: String::new(),
        code: "bad-fault".to_owned(),
        detail: error.to_string(),
        help: None,
    });
    let detail = wrong.first().map(ToString::to_string);
    Problem::invalid("bad-fault", detail.unwrap_or_default()).with_errors(errors.collect())
}
