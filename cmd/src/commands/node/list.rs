//! `rtsctl node list`.

use rts_controller_api::objects::Kind;

use crate::commands::get::{FormatArgs, Selection, show};
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Show the nodes; the same as `rtsctl get nodes`
#[derive(Debug, clap::Args)]
pub struct Args {
    /// How to print.
    #[command(flatten)]
    format: FormatArgs,
}

/// Prints them.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let controller = session.connect().await?;
    show(
        &controller,
        &Selection::of(Kind::Node, None),
        &args.format,
        session,
    )
    .await
}
