//! `rtsctl idl`.

mod check;
mod files;
mod generate;

pub use self::files::Folders;
use crate::error::CliError;
use crate::exit::Exit;
use crate::output::Output;

/// Data types in IDL files: find mistakes, generate Rust
#[derive(Debug, clap::Subcommand)]
#[allow(missing_docs, reason = "the help of a verb is on its arguments")]
pub enum Command {
    Check(check::Args),
    Generate(generate::Args),
}

/// Runs one of them. Needs no home.
pub fn run(command: &Command, out: &Output) -> Result<Exit, CliError> {
    match command {
        Command::Check(args) => check::run(args, out),
        Command::Generate(args) => generate::run(args, out),
    }
}
