//! `cargo xtask bench`: measurements that compare in one run. Machines are noisy: quote ratios within a run.

mod floors;
mod heal;
mod launch;
mod stack;
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
    /// Time from the death of a process until its component is Active and connected again.
    Heal(heal::Args),
}

/// Runs one benchmark.
pub fn run(args: &Args) -> Result<()> {
    match &args.bench {
        Bench::Launch(args) => launch::run(args),
        Bench::Heal(args) => heal::run(args),
    }
}
