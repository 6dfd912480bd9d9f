//! `rtsctl activate`.

use rts_agent_api::messages::Act;

use super::by_hand;
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Activate components by hand (rtact)
///
/// Ends when they are Active.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Which.
    #[command(flatten)]
    which: by_hand::Targets,
}

/// Activates them.
pub async fn run(args: &Args, session: &Session) -> Result<Exit, CliError> {
    by_hand::each(&args.which, |instance| Act::Activate { instance }, session).await
}
