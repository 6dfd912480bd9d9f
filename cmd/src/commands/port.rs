//! `rtsctl port`.

mod end;
mod inject;
mod log;
mod print;
mod record;
mod samples;
mod types;

use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Samples of ports: look at them, write them, record them and play them back
#[derive(Debug, clap::Subcommand)]
#[allow(missing_docs, reason = "the help of a verb is on its arguments")]
pub enum Command {
    Print(print::Args),
    Inject(inject::Args),
    Log(log::Args),
}

/// Runs one of them.
pub async fn run(command: Command, session: &Session) -> Result<Exit, CliError> {
    match command {
        Command::Print(args) => print::run(args, session).await,
        Command::Inject(args) => inject::run(args, session).await,
        Command::Log(args) => log::run(args, session).await,
    }
}
