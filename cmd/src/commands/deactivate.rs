//! `rtsctl deactivate`.

use rts_agent_api::messages::Act;

use super::by_hand;
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Deactivate components by hand (rtdeact)
///
/// Ends when they are Inactive. What becomes of it in a system is for `rtsctl.drift` to say: by default the controller
/// activates them again.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Which.
    #[command(flatten)]
    which: by_hand::Targets,
}

/// Deactivates them.
pub async fn run(args: &Args, session: &Session) -> Result<Exit, CliError> {
    by_hand::each(
        &args.which,
        |instance| Act::Deactivate { instance },
        session,
    )
    .await
}
