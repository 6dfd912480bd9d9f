//! `rtsctl plan --simulate`.

use std::time::Duration;

use rts_controller_api::client::Controller;
use rts_controller_api::simulate::SimulateRequest;
use rts_controller_api::{ClientError, Problem};
use rts_simulation::words::GRAMMAR;

use crate::error::CliError;
use crate::exit::Exit;
use crate::input::Input;
use crate::local::plural;
use crate::session::Session;
use crate::show::plan::PlanFormat;
use crate::show::simulated;

/// A little longer than the controller gives a simulation, so that its own answer comes first.
const PATIENCE: Duration = Duration::from_secs(60);

/// Options of a simulation.
#[derive(Debug, Clone, clap::Args)]
pub struct SimulateArgs {
    /// Play it through in a simulation of the cluster, and show what would happen
    #[arg(long, conflicts_with_all = ["out", "steps", "check_index", "no_restart"])]
    pub simulate: bool,
    /// Something that goes wrong: 'agent node2 crashes at step 5 for 3s' (may be repeated)
    #[arg(long = "fault", value_name = "TEXT", requires = "simulate")]
    faults: Vec<String>,
    /// All chance follows from it: the same one shows the same again [default: 1]
    #[arg(long, value_name = "N", requires = "simulate")]
    seed: Option<u64>,
    /// Simulated time after which it ends, in seconds [default: 300]
    #[arg(long = "limit", value_name = "SECONDS", requires = "simulate")]
    limit_seconds: Option<u64>,
}

impl SimulateArgs {
    /// Fails where a format cannot show it.
    pub fn check(&self, format: PlanFormat) -> Result<(), CliError> {
        match self.simulate {
            true => simulated::Format::of(format).map(drop),
            false => Ok(()),
        }
    }
}

/// Asks the controller, and prints what it says.
pub async fn run(
    args: &SimulateArgs,
    input: &Input,
    format: PlanFormat,
    controller: &Controller,
    session: &Session,
) -> Result<Exit, CliError> {
    let format = simulated::Format::of(format)?;
    let request = SimulateRequest {
        faults: args.faults.clone(),
        seed: args.seed,
        limit_seconds: args.limit_seconds,
        ..SimulateRequest::of(input.planned())
    };
    let what = format!("simulate system/{}", input.request.spec.name);
    let result = controller.simulate(&request, PATIENCE).await;
    let result = match result {
        Err(ClientError::Problem(problem)) if problem.code == "bad-fault" => {
            return Err(misunderstood(&what, &problem, session));
        }
        result => result.map_err(input.failed(what))?,
    };
    simulated::print(&result, format, &session.out)?;
    // A fault that never came has shown nothing.
    Ok(match result.end.converged && result.never_came.is_empty() {
        true => Exit::Ok,
        false => Exit::Different,
    })
}

/// Faults that are not understood: what is wrong with each, and then what can be said.
fn misunderstood(what: &str, problem: &Problem, session: &Session) -> CliError {
    for error in &problem.errors {
        session.out.fault(&error.code, &error.detail, None);
    }
    let why = match problem.errors.len() {
        0 => problem.detail.clone(),
        count => plural("error", count),
    };
    CliError::usage_help(format!("cannot {what}: {why}"), GRAMMAR)
}
