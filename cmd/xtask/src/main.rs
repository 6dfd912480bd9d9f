//! Chores of the project: `cargo xtask demo`, `test`, `bench`, `simulate`, `chaos`, `soak`, `fuzz`, `mutants`.

mod bench;
mod chaos;
mod demo;
mod fuzz;
mod mutants;
mod project;
mod simulate;
mod soak;
mod suites;
mod tools;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

#[derive(Debug, Parser)]
#[command(name = "cargo xtask", about = "Chores of the rtsctl project")]
struct Cli {
    #[command(subcommand)]
    chore: Chore,
}

#[derive(Debug, Subcommand)]
enum Chore {
    /// Builds everything and shows the main job on a real local stack.
    Demo(demo::Args),
    /// Runs all tests, installing the system packages they need when it may.
    Test(suites::Args),
    /// Measures; nothing is asserted.
    Bench(bench::Args),
    /// Runs controller and agents in simulated time against random faults; a seed replays exactly.
    Simulate(simulate::Args),
    /// Breaks real processes at random, and checks from outside that nothing else suffers.
    Chaos(chaos::Args),
    /// Changes a large system all the time, and measures that nothing grows.
    Soak(soak::Args),
    /// Fuzzes every parser and decoder.
    Fuzz(fuzz::Args),
    /// Breaks one rule after the other in a copy of the sources, and requires that a test notices.
    Mutants(mutants::Args),
}

fn main() -> ExitCode {
    let outcome = match Cli::parse().chore {
        Chore::Demo(args) => demo::run(&args),
        Chore::Test(args) => suites::run(&args),
        Chore::Bench(args) => bench::run(&args),
        Chore::Simulate(args) => simulate::run(&args),
        Chore::Chaos(args) => chaos::run(&args),
        Chore::Soak(args) => soak::run(&args),
        Chore::Fuzz(args) => fuzz::run(&args),
        Chore::Mutants(args) => mutants::run(&args),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
