//! `rtsctl reset`.

use rts_agent_api::messages::Act;

use super::by_hand;
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Reset components in Error by hand (rtreset)
///
/// Ends when they are Inactive. The controller then activates those of a system.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Which.
    #[command(flatten)]
    which: by_hand::Targets,
}

/// Resets them.
pub async fn run(args: &Args, session: &Session) -> Result<Exit, CliError> {
    by_hand::each(&args.which, |instance| Act::Reset { instance }, session).await
}
