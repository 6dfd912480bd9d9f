//! `cargo xtask bench jitter`: how late the cycles of a 1 kHz component begin, through the whole stack: an overlay says how it
//! is scheduled, and the histogram is what `rtsctl get components -o json` shows.

mod floor;
mod load;
mod picture;
mod series;

use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use serde_json::json;

use self::series::{Measured, Row};
use super::stack::Stack;
use crate::project;

/// Cycles a second.
pub const RATE: u32 = 1000;
/// SCHED_FIFO priority of the component.
const PRIORITY: u8 = 80;

/// Arguments of `cargo xtask bench jitter`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Seconds of each series.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=86_400))]
    seconds: u64,
    /// The processor that the component is bound to; by default the last. The load is on all others.
    #[arg(long, value_name = "NUMBER")]
    cpu: Option<usize>,
    /// Where the picture is written to.
    #[arg(long, value_name = "FILE", default_value = "docs/jitter.svg")]
    svg: PathBuf,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Measure what is built already with this cargo profile; by default a release build is made first.
    #[arg(long, value_name = "PROFILE")]
    built: Option<String>,
}

/// Measures all series one after the other, prints them and draws them.
pub fn run(args: &Args) -> Result<()> {
    let profile = args.built.as_deref().unwrap_or("release");
    if args.built.is_none() {
        project::run(project::cargo().args(["build", "--release", "--workspace"]))?;
    }
    let programs = project::programs(profile);
    let all = load::processors()?;
    let cpu = args.cpu.or(all.last().copied()).context("no processor")?;
    ensure!(all.contains(&cpu), "there is no processor {cpu} to run on");
    let others: Vec<_> = all.into_iter().filter(|other| *other != cpu).collect();
    let length = Duration::from_secs(args.seconds);
    let mut rows = Vec::new();
    let mut refused = Vec::new();
    for priority in [Some(PRIORITY), None] {
        for loaded in [false, true] {
            let name = name(priority, loaded);
            if !args.json {
                eprintln!("{name}: {} s, then its floor", args.seconds);
            }
            let load = loaded.then(|| load::Load::start(&others)).transpose()?;
            match component(&programs, cpu, priority, length)? {
                Measured::Timing(timing) => rows.push(Row::of(&name, "component", timing)),
                Measured::Refused(why) => refused.push(why),
            }
            match floor::measure(cpu, priority, length)? {
                Measured::Timing(timing) => rows.push(Row::of(&name, "floor", timing)),
                Measured::Refused(why) => refused.push(why),
            }
            drop(load);
        }
    }
    refused.dedup();
    let svg = project::root().join(&args.svg);
    std::fs::write(&svg, picture::render(&rows, args.seconds))
        .with_context(|| format!("cannot write {}", svg.display()))?;
    if args.json {
        let all =
            json!({"rate": RATE, "cpu": cpu, "load": others, "rows": rows, "refused": refused});
        println!("{}", serde_json::to_string_pretty(&all)?);
        return Ok(());
    }
    println!(
        "one component of {RATE} Hz on processor {cpu}, load on {others:?}, {profile} build, {} s each",
        args.seconds
    );
    series::print(&rows);
    for why in refused {
        println!("not measured: {}", why.trim());
    }
    println!("picture: {}", args.svg.display());
    Ok(())
}

fn name(priority: Option<u8>, loaded: bool) -> String {
    let policy = priority.map_or("other", |_| "fifo");
    let load = if loaded { "load" } else { "idle" };
    format!("{policy}-{load}")
}

/// The component in a stack of its own, so that its counts begin with it.
fn component(
    programs: &std::path::Path,
    cpu: usize,
    priority: Option<u8>,
    length: Duration,
) -> Result<Measured> {
    let stack = Stack::start(programs)?;
    let measured = series::measure(&stack, cpu, priority, length);
    stack.stop()?;
    measured
}
