//! `cargo xtask soak`: a large system is changed all the time, and no process may grow. The tests run 20 s of it.

use anyhow::Result;

use crate::project::{self, Build};

/// Arguments of `cargo xtask soak`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// How long.
    #[arg(long, default_value_t = 10.0)]
    minutes: f64,
    /// What is done follows from it.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of components; there are twice as many connectors.
    #[arg(long, default_value_t = 100)]
    components: u16,
}

/// Builds everything, and runs the soak.
pub fn run(args: &Args) -> Result<()> {
    let mut command = project::program("soak", Build::Programs)?;
    command.args(["--minutes", &args.minutes.to_string()]);
    command.args(["--seed", &args.seed.to_string()]);
    command.args(["--components", &args.components.to_string()]);
    project::run(&mut command)
}
