//! `cargo xtask fuzz`: every fuzz target for some time; the tests run a short part.

use anyhow::{Context, Result};

use crate::{project, tools};

/// Seconds per target in the tests.
const SHORT: u32 = 5;

/// Arguments of `cargo xtask fuzz`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Seconds for each target.
    #[arg(long, default_value_t = 300)]
    seconds: u32,
    /// Only these targets.
    #[arg(value_name = "TARGET")]
    only: Vec<String>,
}

/// Runs the targets one after the other.
pub fn run(args: &Args) -> Result<()> {
    let targets = targets()?;
    for target in targets
        .iter()
        .filter(|t| args.only.is_empty() || args.only.contains(t))
    {
        fuzz(target, args.seconds)?;
    }
    Ok(())
}

/// The part that the tests run.
pub fn short() -> Result<()> {
    run(&Args {
        seconds: SHORT,
        only: Vec::new(),
    })
}

fn targets() -> Result<Vec<String>> {
    let folder = project::root().join("fuzz/fuzz_targets");
    let mut targets = Vec::new();
    for entry in
        std::fs::read_dir(&folder).with_context(|| format!("cannot read {}", folder.display()))?
    {
        let path = entry?.path();
        if path.extension().is_some_and(|e| e == "rs")
            && let Some(name) = path.file_stem().and_then(|n| n.to_str())
        {
            targets.push(name.to_owned());
        }
    }
    targets.sort();
    Ok(targets)
}

fn fuzz(target: &str, seconds: u32) -> Result<()> {
    println!("fuzzing {target} for {seconds} s");
    let corpus = project::root().join("fuzz/corpus").join(target);
    std::fs::create_dir_all(&corpus)
        .with_context(|| format!("cannot make {}", corpus.display()))?;
    let seeds = project::root().join("fuzz/seeds").join(target);
    // Stable compilers have no sanitizers; the targets look for panics, hangs and memory, which need none.
    let mut command = project::command(tools::cargo_tool("fuzz")?);
    command.args(["run", "-s", "none", target]).arg(&corpus);
    if seeds.is_dir() {
        command.arg(&seeds);
    }
    command.args([
        "--",
        "-rss_limit_mb=2048",
        "-timeout=10",
        "-verbosity=0",
        "-print_final_stats=1",
    ]);
    command.arg(format!("-max_total_time={seconds}"));
    project::run(&mut command)
}
