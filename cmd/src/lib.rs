//! The command line of the project: it reads files, asks the controller, and shows the answers. It decides nothing.

pub mod cli;
pub mod commands;
pub mod daemon;
pub mod error;
pub mod exit;
pub mod follow;
pub mod input;
mod library;
pub mod local;
pub mod output;
pub mod save;
pub mod saved;
pub mod session;
pub mod show;
pub mod timings;

use std::process::ExitCode;

/// Parses the arguments, runs the verb, prints the error if there is one, and gives the exit status.
pub fn main() -> ExitCode {
    // The clock of `--timings` begins.
    let _ = rts_host::timing::now();
    let cli = match cli::Cli::read() {
        Ok(cli) => cli,
        Err(e) => {
            // A closed stdout is no reason to fail: the reader has what it wanted.
            let _ = e.print();
            let failed = e.use_stderr();
            return ExitCode::from(if failed { exit::Exit::Usage.code() } else { 0 });
        }
    };
    let out = output::Output::new(&cli.globals);
    ExitCode::from(cli::run(cli, &out).code())
}
