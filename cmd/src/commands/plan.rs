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
    let request = args.input.load(&session.out)?;
    let controller = session.connect_or_start().await?;
    let name = &request.spec.name;
    let result = controller.plan(&request).await;
    let result = result.map_err(CliError::request(format!("plan system/{name}")))?;
    plan::print_with_steps(&result, args.format.output, &session.out)?;
    Ok(Exit::Ok)
}
