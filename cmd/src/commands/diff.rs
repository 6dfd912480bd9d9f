//! `rtsctl diff`.

use crate::error::CliError;
use crate::exit::Exit;
use crate::input::InputArgs;
use crate::session::Session;
use crate::show::plan::{self, PlanFormatArgs};

/// Show how what runs differs from a profile, and what would restart; nothing changes
///
/// Exits 1 if anything differs.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The system.
    #[command(flatten)]
    input: InputArgs,
    /// How to print.
    #[command(flatten)]
    format: PlanFormatArgs,
}

/// Prints the differences.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let request = args.input.load(&session.out)?;
    let controller = session.connect_or_start().await?;
    let name = &request.spec.name;
    let result = controller.plan(&request).await;
    let result = result.map_err(CliError::request(format!("compare system/{name}")))?;
    plan::print(&result, args.format.output, &session.out)?;
    Ok(if result.plan.is_empty() {
        Exit::Ok
    } else {
        Exit::Different
    })
}
