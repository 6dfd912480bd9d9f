//! `rtsctl node`: machines that components run on.

mod add;
mod bootstrap;
mod list;
mod reach;
mod remove;
mod unbootstrap;

use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Machines that components run on: reached by SSH, or with an agent that is installed there over SSH
#[derive(Debug, clap::Subcommand)]
#[allow(missing_docs, reason = "the help of a verb is on its arguments")]
pub enum Command {
    Add(Box<add::Args>),
    List(list::Args),
    Remove(remove::Args),
    Bootstrap(bootstrap::Args),
    Unbootstrap(unbootstrap::Args),
}

/// Runs one of the verbs.
pub async fn run(command: Command, session: &Session) -> Result<Exit, CliError> {
    match command {
        Command::Add(args) => add::run(&args, session).await,
        Command::List(args) => list::run(args, session).await,
        Command::Remove(args) => remove::run(&args, session).await,
        Command::Bootstrap(args) => bootstrap::run(args, session).await,
        Command::Unbootstrap(args) => unbootstrap::run(args, session).await,
    }
}
