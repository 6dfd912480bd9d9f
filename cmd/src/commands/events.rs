//! `rtsctl events`.

use rts_controller_api::objects::Kind;

use super::get::{FormatArgs, show};
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Show what happened, oldest first
///
/// The same as `rtsctl get events`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// How to print.
    #[command(flatten)]
    format: FormatArgs,
}

/// Prints the events.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let controller = session.connect().await?;
    show(&controller, Kind::Event, None, &args.format, session).await
}
