//! `rtsctl node`: machines that components run on.

mod bootstrap;
mod reach;
mod unbootstrap;

use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Machines that components run on: install an agent there over SSH
#[derive(Debug, clap::Subcommand)]
#[allow(missing_docs, reason = "the help of a verb is on its arguments")]
pub enum Command {
    Bootstrap(bootstrap::Args),
    Unbootstrap(unbootstrap::Args),
}

/// Runs one of the verbs.
pub async fn run(command: Command, session: &Session) -> Result<Exit, CliError> {
    match command {
        Command::Bootstrap(args) => bootstrap::run(args, session).await,
        Command::Unbootstrap(args) => unbootstrap::run(args, session).await,
    }
}
