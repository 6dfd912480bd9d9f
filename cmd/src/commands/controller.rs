//! `rtsctl controller`: the controller's store, and whose a node is.

mod backup;
mod claim;
mod restore;

use super::{ask, can_ask};
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Keep and restore the controller's store; say whose a node is
#[derive(Debug, clap::Subcommand)]
#[allow(missing_docs, reason = "the help of a verb is on its arguments")]
pub enum Command {
    Backup(backup::Args),
    Restore(restore::Args),
    Adopt(claim::AdoptArgs),
    TakeOver(claim::TakeOverArgs),
}

/// Runs a verb.
pub async fn run(command: Command, session: &Session) -> Result<Exit, CliError> {
    match command {
        Command::Backup(args) => backup::run(&args, session).await,
        Command::Restore(args) => restore::run(&args, session).await,
        Command::Adopt(args) => claim::adopt(&args, session).await,
        Command::TakeOver(args) => claim::take_over(&args, session).await,
    }
}

/// Asks, or refuses where nobody can be asked.
fn confirm(yes: bool, question: &str, would: &str) -> Result<(), CliError> {
    if yes {
        return Ok(());
    }
    if !can_ask() {
        let help = "say --yes where nobody can be asked";
        return Err(CliError::usage_help(would.to_owned(), help));
    }
    if ask(question) {
        Ok(())
    } else {
        Err(CliError::usage("nothing was changed"))
    }
}
