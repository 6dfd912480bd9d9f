//! The controller program. Everything it does is in `rts_controller`.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context;
use clap::Parser;

/// Keeps systems of RT-Components as they were applied
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    /// Folder of this stack's sockets, state and logs
    #[arg(long, env = "RTSCTL_HOME", value_name = "FOLDER")]
    home: PathBuf,
    /// Name of the node on this machine
    #[arg(long, default_value = "local", value_name = "NAME")]
    local_node: String,
}

fn main() -> ExitCode {
    let args = Args::parse();
    let filter = tracing_subscriber::EnvFilter::try_from_env("RTSCTL_LOG")
        .unwrap_or_else(|_| tracing_subscriber::EnvFilter::new("info"));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(false)
        .init();
    let config = rts_controller::Config {
        home: args.home,
        local_node: args.local_node,
    };
    match rts_controller::run(&config).context("rts-controller ends") {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tracing::error!("{error:#}");
            ExitCode::FAILURE
        }
    }
}
