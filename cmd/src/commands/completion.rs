//! `rtsctl completion`.

use clap::CommandFactory;
use clap_complete::Shell;

use crate::cli::Cli;
use crate::error::CliError;
use crate::exit::Exit;
use crate::output::Output;

/// Print the completion script of a shell
///
/// For bash: `source <(rtsctl completion bash)`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The shell
    shell: Shell,
}

/// Prints the script.
pub fn run(args: &Args, out: &Output) -> Result<Exit, CliError> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "rtsctl", &mut script);
    out.result(&String::from_utf8_lossy(&script))?;
    Ok(Exit::Ok)
}
