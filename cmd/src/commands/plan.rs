//! `rtsctl plan`.

use crate::error::CliError;
use crate::exit::Exit;
use crate::input::InputArgs;
use crate::session::Session;
use crate::show::plan::{self, PlanFormatArgs};

/// Show what apply would do, step by step; nothing changes
///
/// Exits 0 whether there is anything to do or not.
#[derive(Debug, clap::Args)]
#[command(
    override_usage = "rtsctl plan [OPTIONS] FILE [-f OVERLAY]...\n       rtsctl plan [OPTIONS] -f FILE [-f OVERLAY]..."
)]
pub struct Args {
    /// The system.
    #[command(flatten)]
    input: InputArgs,
    /// How to print.
    #[command(flatten)]
    format: PlanFormatArgs,
}

/// Prints the plan.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let input = args.input.load(&session.out)?;
    let controller = session.connect().await?;
    let name = &input.request.spec.name;
    let result = controller.plan(&input.request).await;
    let result = result.map_err(input.failed(format!("plan system/{name}")))?;
    plan::print_with_steps(&result, args.format.output, &session.out)?;
    Ok(Exit::Ok)
}
