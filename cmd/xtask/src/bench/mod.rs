//! `cargo xtask bench`: measurements that compare in one run. Machines are noisy: quote ratios within a run.

mod dataport;
mod floors;
mod heal;
mod jitter;
mod launch;
mod plan;
mod read;
mod stack;
mod stats;

use std::path::PathBuf;

use anyhow::Result;
use clap::Subcommand;

use crate::project;

/// Arguments of `cargo xtask bench`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    bench: Bench,
}

/// Arguments of every benchmark.
#[derive(Debug, clap::Args)]
struct Common {
    /// Counted runs of each row, after one that is not counted.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1000))]
    runs: u32,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Measure what is built already with this cargo profile; by default a release build is made first.
    #[arg(long, value_name = "PROFILE")]
    built: Option<String>,
}

impl Common {
    /// The cargo profile that is measured, and the folder of its programs, built when need be.
    fn programs(&self) -> Result<(&str, PathBuf)> {
        let profile = self.built.as_deref().unwrap_or("release");
        if self.built.is_none() {
            project::run(project::cargo().args(["build", "--release", "--workspace"]))?;
        }
        Ok((profile, project::programs(profile)))
    }
}

#[derive(Debug, Subcommand)]
enum Bench {
    /// Time to launch components, by our agent and by SSH, beside its floors.
    Launch(launch::Args),
    /// Time from the death of a process until its component is Active and connected again.
    Heal(heal::Args),
    /// Time and memory of one plan, from 100 to 100,000 components.
    Plan(plan::Args),
    /// Speed of reading profiles of 10 MB and 100 MB, beside the reference library.
    Read(read::Args),
    /// Latency, throughput and allocations of the transports of data ports, beside their floors.
    Dataport(dataport::Args),
    /// How late the cycles of a 1 kHz component begin, with and without SCHED_FIFO and load.
    Jitter(jitter::Args),
}

/// Runs one benchmark.
pub fn run(args: &Args) -> Result<()> {
    match &args.bench {
        Bench::Launch(args) => launch::run(args),
        Bench::Heal(args) => heal::run(args),
        Bench::Plan(args) => plan::run(args),
        Bench::Read(args) => read::run(args),
        Bench::Dataport(args) => dataport::run(args),
        Bench::Jitter(args) => jitter::run(args),
    }
}
