//! `rtsctl node`: machines that components run on.

mod add;
mod list;
mod remove;

use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Machines that components run on: those that are reached by SSH
#[derive(Debug, clap::Subcommand)]
#[allow(missing_docs, reason = "the help of a verb is on its arguments")]
pub enum Command {
    Add(Box<add::Args>),
    List(list::Args),
    Remove(remove::Args),
}

/// Runs one of the verbs.
pub async fn run(command: Command, session: &Session) -> Result<Exit, CliError> {
    match command {
        Command::Add(args) => add::run(&args, session).await,
        Command::List(args) => list::run(args, session).await,
        Command::Remove(args) => remove::run(&args, session).await,
    }
}
