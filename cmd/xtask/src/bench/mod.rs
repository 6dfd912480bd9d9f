//! `cargo xtask bench`: measurements that compare in one run. Machines are noisy: quote ratios within a run.

mod floors;
mod launch;
mod stats;

use anyhow::Result;
use clap::Subcommand;

/// Arguments of `cargo xtask bench`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    bench: Bench,
}

#[derive(Debug, Subcommand)]
enum Bench {
    /// Time to launch components, beside its floors.
    Launch(launch::Args),
}

/// Runs one benchmark.
pub fn run(args: &Args) -> Result<()> {
    match &args.bench {
        Bench::Launch(args) => launch::run(args),
    }
}
