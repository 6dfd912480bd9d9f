//! `rtsctl tick`.

use rts_agent_api::messages::{Act, MAX_TICKS};

use super::by_hand;
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Run cycles of components that are driven from outside
///
/// Those are Active components whose execution context is neither periodic nor event-driven (kind OTHER). Ends when the last
/// cycle is over.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Which.
    #[command(flatten)]
    which: by_hand::Targets,
    /// How many cycles of each
    #[arg(
        short = 'n',
        long,
        value_name = "N",
        default_value_t = 1,
        value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_TICKS))
    )]
    cycles: u32,
}

/// Ticks them.
pub async fn run(args: &Args, session: &Session) -> Result<Exit, CliError> {
    let cycles = args.cycles;
    let act = move |instance| Act::Tick { instance, cycles };
    by_hand::each(&args.which, act, session).await
}
