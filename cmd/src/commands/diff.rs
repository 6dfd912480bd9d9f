//! `rtsctl diff`.

use std::time::{Duration, Instant};

use rts_controller_api::client::Controller;
use rts_controller_api::requests::PlanResult;

use crate::error::CliError;
use crate::exit::Exit;
use crate::input::{Input, InputArgs};
use crate::session::Session;
use crate::show::plan::{self, PlanFormatArgs, View};

/// How long questions under way are waited for before they count as differences.
const PATIENCE: Duration = Duration::from_secs(2);
/// Time between two looks.
const PAUSE: Duration = Duration::from_millis(200);

/// Show how what runs differs from a profile, and what would restart; nothing changes
///
/// Exits 1 if anything differs, or cannot be done now. What a person changed by hand and may keep (`rtsctl.drift`: `ignore`)
/// is shown and is no difference.
#[derive(Debug, clap::Args)]
#[command(
    override_usage = "rtsctl diff [OPTIONS] FILE [-f OVERLAY]...\n       rtsctl diff [OPTIONS] -f FILE [-f OVERLAY]..."
)]
pub struct Args {
    /// The system.
    #[command(flatten)]
    input: InputArgs,
    /// How to print.
    #[command(flatten)]
    format: PlanFormatArgs,
    /// List the steps too, with their reasons
    #[arg(long)]
    steps: bool,
}

/// Prints the differences.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let input = args.input.load(&session.out)?;
    let controller = session.connect().await?;
    let result = compare(&input, &controller).await?;
    let view = match args.steps {
        true => View::Steps { all: true },
        false => View::Lines,
    };
    let spec = &input.request.spec;
    plan::print(&result, spec, args.format.output, view, &session.out)?;
    Ok(if plan::concerns(&result.plan, spec) {
        Exit::Different
    } else {
        Exit::Ok
    })
}

/// The plan, once nothing of it only waits for an answer that is under way.
async fn compare(input: &Input, controller: &Controller) -> Result<PlanResult, CliError> {
    let end = Instant::now() + PATIENCE;
    loop {
        let what = format!("compare system/{}", input.request.spec.name);
        let result = controller.plan(&input.request).await;
        let result = result.map_err(input.failed(what))?;
        let asked = result.plan.waiting_on.iter().any(|waits| waits.transient);
        if !asked || Instant::now() >= end {
            return Ok(result);
        }
        tokio::time::sleep(PAUSE).await;
    }
}
