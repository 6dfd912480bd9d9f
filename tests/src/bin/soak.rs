//! `soak`: a large system that is changed all the time. `cargo xtask soak` builds what it starts, and runs it.

use std::process::ExitCode;
use std::time::Duration;

use clap::Parser;
use rts_tests::soak::{Options, run};

/// A large system is changed all the time, and nothing may grow
#[derive(Debug, Parser)]
struct Args {
    /// How long.
    #[arg(long, default_value_t = 10.0)]
    minutes: f64,
    /// What is done follows from it.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of components; there are twice as many connectors.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u16).range(10..=2000))]
    components: u16,
}

fn main() -> ExitCode {
    let args = Args::parse();
    let options = Options {
        time: Duration::try_from_secs_f64(args.minutes * 60.0).unwrap_or_default(),
        seed: args.seed,
        components: args.components.into(),
        leak: false,
    };
    match run(&options) {
        Ok(report) => {
            println!("{report}");
            ExitCode::SUCCESS
        }
        Err(problem) => {
            eprintln!("soak: {problem}");
            ExitCode::FAILURE
        }
    }
}
