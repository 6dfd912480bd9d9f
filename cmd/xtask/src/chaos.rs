//! `cargo xtask chaos`: random kills, stops, deletions and full disks against real processes.

use anyhow::Result;

use crate::project::{self, Build};

/// Seconds in the tests.
const SHORT: u64 = 60;

/// Arguments of `cargo xtask chaos`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// How long.
    #[arg(long, default_value_t = 10.0)]
    minutes: f64,
    /// What is done follows from it; another one each time when it is not given.
    #[arg(long)]
    seed: Option<u64>,
}

/// Builds everything, and runs the chaos.
pub fn run(args: &Args) -> Result<()> {
    run_built(args, Build::Programs)
}

fn run_built(args: &Args, build: Build) -> Result<()> {
    let mut command = project::program("chaos", build)?;
    command.arg("--minutes");
    command.arg(args.minutes.to_string());
    if let Some(seed) = args.seed {
        command.args(["--seed", &seed.to_string()]);
    }
    project::run(&mut command)
}

/// The part that the tests run.
pub fn short() -> Result<()> {
    let minutes = SHORT as f64 / 60.0;
    // The same actions each time.
    let seed = Some(1);
    run_built(&Args { minutes, seed }, Build::Everything)
}
