//! `cargo xtask bench plan`: what one plan takes, from 100 to 100,000 components with five connectors each.
//!
//! Time and memory are taken by two programs, since counting bytes costs time.

use std::process::Command;

use anyhow::{Context, Result, bail};
use serde::Serialize;

use crate::project;

/// Numbers of components.
const SIZES: [u32; 4] = [100, 1_000, 10_000, 100_000];
/// What is planned: the first start, nothing to do, one configuration value changed.
const CASES: [&str; 3] = ["first", "no-op", "one-change"];

/// Arguments of `cargo xtask bench plan`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Counted plans of each row, after one that is not counted; the median is shown.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    runs: u32,
    /// Only up to so many components.
    #[arg(long, default_value_t = 100_000)]
    up_to: u32,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// One row.
#[derive(Debug, Serialize)]
struct Row {
    components: u32,
    case: &'static str,
    /// Median of all runs.
    seconds: f64,
    /// Most bytes at a time beside what goes in, and the plan itself, for each component.
    bytes_per_component: u64,
    #[serde(skip)]
    steps: u64,
}

/// Measures all rows and prints them.
pub fn run(args: &Args) -> Result<()> {
    let build = [
        "build",
        "--release",
        "--quiet",
        "-p",
        "rts-plan",
        "--examples",
    ];
    project::run(project::cargo().args(build))?;
    let mut rows = Vec::new();
    for case in CASES {
        for components in SIZES.into_iter().filter(|size| *size <= args.up_to) {
            rows.push(row(components, case, args.runs)?);
        }
    }
    if args.json {
        println!(
            "{}",
            serde_json::to_string_pretty(&serde_json::json!({ "rows": rows }))?
        );
        return Ok(());
    }
    print(&rows);
    Ok(())
}

fn row(components: u32, case: &'static str, runs: u32) -> Result<Row> {
    let count = components.to_string();
    let times = measure("plan_time", &[&count, case, &(runs + 1).to_string()])?;
    let mut seconds: Vec<f64> = times.iter().skip(1).map(|(seconds, _)| *seconds).collect();
    seconds.sort_by(f64::total_cmp);
    let (Some(median), Some((_, steps))) = (seconds.get(seconds.len() / 2), times.first()) else {
        bail!("plan_time printed nothing");
    };
    let memory = measure("plan_memory", &[&count, case])?;
    let (bytes, _) = memory.first().context("plan_memory printed nothing")?;
    Ok(Row {
        components,
        case,
        seconds: *median,
        bytes_per_component: (bytes / f64::from(components)) as u64,
        steps: *steps,
    })
}

/// The lines of one of the programs: a figure, and the number of steps.
fn measure(program: &str, words: &[&str]) -> Result<Vec<(f64, u64)>> {
    let path = project::programs("release").join("examples").join(program);
    let mut command = Command::new(path);
    command.args(words);
    let shown = project::shown(&command);
    let output = command
        .output()
        .with_context(|| format!("cannot start {shown}"))?;
    if !output.status.success() {
        bail!("{shown} ended with {}", output.status);
    }
    let text = String::from_utf8(output.stdout).context("not text")?;
    let line = |line: &str| -> Option<(f64, u64)> {
        let (figure, steps) = line.split_once(' ')?;
        Some((figure.parse().ok()?, steps.parse().ok()?))
    };
    let lines: Option<Vec<_>> = text.lines().map(line).collect();
    lines.with_context(|| format!("{shown} printed {text:?}"))
}

/// A table; the last column shows the growth: it stays level for n log n.
fn print(rows: &[Row]) {
    println!(
        "{:<12} {:>10} {:>8} {:>12} {:>16} {:>16}",
        "CASE", "COMPONENTS", "STEPS", "MS", "BYTES/COMPONENT", "NS/(N LOG2 N)"
    );
    for row in rows {
        let n = f64::from(row.components);
        println!(
            "{:<12} {:>10} {:>8} {:>12.3} {:>16} {:>16.1}",
            row.case,
            row.components,
            row.steps,
            row.seconds * 1e3,
            row.bytes_per_component,
            row.seconds * 1e9 / (n * n.log2()),
        );
    }
}
