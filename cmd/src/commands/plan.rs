//! `rtsctl plan`.

mod simulate;

use std::path::PathBuf;

use rts_controller_api::client::Controller;
use rts_controller_api::requests::PlanResult;
use rts_simulation::words::GRAMMAR;

use crate::error::CliError;
use crate::exit::Exit;
use crate::input::{Input, InputArgs};
use crate::saved::SavedPlan;
use crate::session::Session;
use crate::show::plan::{self, PlanFormat, PlanFormatArgs, View};

use self::simulate::SimulateArgs;

/// Show what apply would do, step by step; nothing changes
///
/// `+` is added, `~` changed in place, `-` removed, `!` stopped and made again. Exits 0 whether there is anything to do or
/// not.
///
/// With --simulate it is played through: the controller and the agents of this version work on a simulation of the whole
/// cluster, whose network, disks, clocks and processes fail as --fault says. Exits 0 when the system came to be as it is
/// desired, 1 when not.
#[derive(Debug, clap::Args)]
#[command(
    after_long_help = GRAMMAR,
    override_usage = "rtsctl plan [OPTIONS] FILE [-f OVERLAY]...\n       rtsctl plan [OPTIONS] -f FILE [-f OVERLAY]..."
)]
pub struct Args {
    /// The system.
    #[command(flatten)]
    input: InputArgs,
    /// How to print.
    #[command(flatten)]
    format: PlanFormatArgs,
    /// List the steps however many they are (50 or fewer always are)
    #[arg(long)]
    steps: bool,
    /// Save the plan: `rtsctl apply PLAN` does just that, or nothing if something has changed
    #[arg(long, value_name = "PLAN")]
    out: Option<PathBuf>,
    /// What must be true.
    #[command(flatten)]
    expect: ExpectArgs,
    /// Playing it through.
    #[command(flatten)]
    simulate: SimulateArgs,
}

/// What must be true for a system to be applied.
#[derive(Debug, Clone, clap::Args)]
pub struct ExpectArgs {
    /// Refuse (exit 7) if the system was changed since: `plan` says the number
    #[arg(long, value_name = "N")]
    pub check_index: Option<u64>,
    /// Refuse (exit 9) if a process would restart or a component be made again
    #[arg(long)]
    pub no_restart: bool,
}

/// Prints the plan.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let input = args.input.load(&session.out)?;
    let format = args.format.output;
    args.simulate.check(format)?;
    let controller = session.connect().await?;
    if args.simulate.simulate {
        return simulate::run(&args.simulate, &input, format, &controller, session).await;
    }
    let result = show(&input, format, args.steps, &controller, session).await?;
    args.expect.check(&input, &result)?;
    if let Some(path) = &args.out {
        SavedPlan::of(&input.request, &result).write(path)?;
        let path = path.display();
        let text = format!("saved in {path}: `rtsctl apply {path}` carries it out");
        session.out.say(&text);
    }
    Ok(Exit::Ok)
}

/// Plans now, whatever is expected, and prints that. `all`: the steps however many they are.
pub(super) async fn show(
    input: &Input,
    format: PlanFormat,
    all: bool,
    controller: &Controller,
    session: &Session,
) -> Result<PlanResult, CliError> {
    let spec = &input.request.spec;
    let result = controller.plan(&input.planned()).await;
    let result = result.map_err(input.failed(format!("plan system/{}", spec.name)))?;
    plan::print(&result, spec, format, View::Steps { all }, &session.out)?;
    Ok(result)
}

impl ExpectArgs {
    /// Something is expected.
    pub fn is_any(&self) -> bool {
        self.check_index.is_some() || self.no_restart
    }

    /// Fails if a plan is not as expected.
    pub fn check(&self, input: &Input, result: &PlanResult) -> Result<(), CliError> {
        let spec = &input.request.spec;
        let wanted = self.check_index.or(input.request.expect.index);
        if let Some(then) = wanted.filter(|then| *then != result.index) {
            let now = result.index;
            return Err(CliError::Stale {
                system: spec.name.clone(),
                reason: format!("its check index is {now}, not {then}"),
            });
        }
        let digest = input.request.expect.digest.as_ref();
        if digest.is_some_and(|digest| *digest != result.digest) {
            return Err(CliError::Stale {
                system: spec.name.clone(),
                reason: "something that runs has changed, and another plan is made now".to_owned(),
            });
        }
        let restarts = plan::would_restart(&result.plan, spec);
        match restarts.filter(|_| self.no_restart) {
            None => Ok(()),
            Some(restarts) => Err(CliError::WouldRestart {
                system: spec.name.clone(),
                restarts,
            }),
        }
    }

    /// The same, for the controller to check when it decides.
    pub fn added(&self, mut input: Input) -> Input {
        let expect = &mut input.request.expect;
        expect.index = self.check_index.or(expect.index);
        expect.no_restart = self.no_restart;
        input
    }
}
