//! `cargo xtask simulate`: random schedules of faults against the real controller and agents, in simulated time.

use anyhow::Result;

use crate::project::{self, Build};

/// Seeds that the tests run.
const SHORT: u64 = 600;

/// Arguments of `cargo xtask simulate`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Number of seeds.
    #[arg(long, default_value_t = 10_000)]
    seeds: u64,
    /// The first of them.
    #[arg(long, default_value_t = 0)]
    start: u64,
    /// Only this one, with all that happens in it.
    #[arg(long, conflicts_with_all = ["seeds", "start"])]
    seed: Option<u64>,
    /// Built for speed: worth its build for tens of thousands of seeds.
    #[arg(long)]
    release: bool,
    /// Handed on to the simulation (`-- --help` shows what it takes).
    #[arg(last = true)]
    more: Vec<String>,
}

/// Runs the seeds.
pub fn run(args: &Args) -> Result<()> {
    let build = if args.release {
        Build::Release
    } else {
        Build::Programs
    };
    run_built(args, build)
}

fn run_built(args: &Args, build: Build) -> Result<()> {
    let mut command = project::program("simulate", build)?;
    match args.seed {
        Some(seed) => command.args(["--trace", "--seed"]).arg(seed.to_string()),
        None => command
            .args(["--seeds", &args.seeds.to_string()])
            .args(["--start", &args.start.to_string()]),
    };
    project::run(command.args(&args.more))
}

/// The part that the tests run.
pub fn short() -> Result<()> {
    let args = Args {
        seeds: SHORT,
        start: 0,
        seed: None,
        release: false,
        more: Vec::new(),
    };
    run_built(&args, Build::Everything)
}
