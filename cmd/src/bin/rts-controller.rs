//! The controller program. Everything it does is in `rts_controller`.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::Context;
use clap::{Parser, Subcommand};
use rts_controller::restore::{check, restore};
use rts_controller::simulator::ProgramSimulator;
use rts_host::error::chain;

/// Keeps systems of RT-Components as they were applied
#[derive(Debug, Parser)]
#[command(
    version,
    subcommand_negates_reqs = true,
    args_conflicts_with_subcommands = true
)]
struct Args {
    /// Folder of this stack's sockets, state and logs
    #[arg(long, env = "RTSCTL_HOME", value_name = "FOLDER", required = true)]
    home: Option<PathBuf>,
    /// Name of the node on this machine
    #[arg(long, default_value = "local", value_name = "NAME")]
    local_node: String,
    /// What else it can do.
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Put a backup in the place of the store, while no controller runs; says what it did as one line of JSON
    Restore {
        /// Folder of the stack
        #[arg(long, env = "RTSCTL_HOME", value_name = "FOLDER")]
        home: PathBuf,
        /// The backup wins over what nodes were told since
        #[arg(long, conflicts_with = "check")]
        take_over: bool,
        /// Only say what is in the backup
        #[arg(long)]
        check: bool,
        /// The backup
        file: PathBuf,
    },
}

fn main() -> ExitCode {
    let args = Args::parse();
    rtsctl::daemon::observe();
    let result = match args.command {
        Some(command) => restored(command),
        None => run(args.home.unwrap_or_default(), args.local_node),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tracing::error!("{error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(home: PathBuf, local_node: String) -> anyhow::Result<()> {
    let config = rts_controller::Config { home, local_node };
    let program = std::env::current_exe().context("cannot find the folder of this program")?;
    let simulator = ProgramSimulator::new(program.with_file_name("rts-simulator"));
    rts_controller::run(&config, Arc::new(simulator)).context("rts-controller ends")
}

fn restored(command: Command) -> anyhow::Result<()> {
    let Command::Restore {
        home,
        take_over,
        check: only,
        file,
    } = command;
    let result = if only {
        check(&file)
    } else {
        restore(&home, &file, take_over)
    };
    let line = match &result {
        Ok(report) => serde_json::to_string(report)?,
        Err(error) => serde_json::json!({"error": chain(error)}).to_string(),
    };
    writeln!(std::io::stdout(), "{line}")?;
    result.map(drop).map_err(|e| anyhow::anyhow!(chain(&e)))
}
