//! `cargo xtask bench dataport`: the transports of data ports beside their floors, in interleaved rounds of one run.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};

use crate::project;

/// Arguments of `cargo xtask bench dataport`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Counted rounds, after one that is not counted.
    #[arg(long, default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Only three rounds.
    #[arg(long)]
    quick: bool,
    /// Also write rows and goals to this file.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// What is known of a transport and a size.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Row {
    row: String,
    bytes: u64,
    median_ns: f64,
    p99_ns: f64,
    /// The lowest of the rounds' medians.
    quietest_ns: f64,
    per_second: f64,
    megabytes_per_second: f64,
    allocations_per_sample: f64,
}

/// How long the death of the other process was not noticed.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Death {
    row: String,
    median_ms: f64,
    most_ms: f64,
}

/// What the measuring program prints.
#[derive(Debug, Deserialize)]
struct Measured {
    rows: Vec<Row>,
    deaths: Vec<Death>,
}

/// A ratio that is to be reached.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Goal {
    row: &'static str,
    beside: &'static str,
    bytes: u64,
    /// At most, of the medians.
    goal: f64,
    ratio: f64,
    /// Of the quietest rounds, which other work on the machine has spoiled least.
    quietest_ratio: f64,
    reached: bool,
}

const MIB: u64 = 1 << 20;
const ALL: [u64; 3] = [8, 1024, MIB];

/// Row, the one beside it, at which sizes, and at most so many times as long.
const GOALS: [(&str, &str, &[u64], f64); 5] = [
    ("inproc", "floor-call", &ALL, 3.0),
    ("shm", "floor-ring", &ALL, 1.5),
    ("shm", "floor-memcpy", &[MIB], 1.5),
    ("shm", "uds", &[MIB], 0.5),
    ("tcp", "floor-tcp", &ALL, 1.3),
];

/// Measures all rows and prints them.
pub fn run(args: &Args) -> Result<()> {
    let example = [
        "build",
        "--release",
        "--quiet",
        "-p",
        "rts-transport",
        "--example",
        "dataport",
    ];
    project::run(project::cargo().args(example))?;
    let program = project::programs("release").join("examples/dataport");
    let rounds = if args.quick { 3 } else { args.rounds };
    let mut command = project::command(&program);
    command.args(["measure", &rounds.to_string()]);
    let Measured { rows, deaths } =
        serde_json::from_str(&output(&mut command)?).context("its rows")?;
    let goals = goals(&rows)?;
    print(&rows, &goals, &deaths);
    if let Some(file) = &args.json {
        let all =
            serde_json::json!({ "rounds": rounds, "rows": rows, "goals": goals, "deaths": deaths });
        std::fs::write(file, serde_json::to_string_pretty(&all)? + "\n")
            .with_context(|| format!("cannot write {}", file.display()))?;
    }
    Ok(())
}

fn output(command: &mut std::process::Command) -> Result<String> {
    let shown = project::shown(command);
    let output = command
        .stderr(std::process::Stdio::inherit())
        .output()
        .with_context(|| format!("cannot start {shown}"))?;
    if !output.status.success() {
        bail!("{shown} ended with {}", output.status);
    }
    String::from_utf8(output.stdout).context("its output")
}

fn goals(rows: &[Row]) -> Result<Vec<Goal>> {
    let find = |name: &str, bytes: u64| {
        let row = rows.iter().find(|r| r.row == name && r.bytes == bytes);
        row.with_context(|| format!("no row {name} of {bytes} bytes"))
    };
    let mut goals = Vec::new();
    for (row, beside, sizes, goal) in GOALS {
        for bytes in sizes.iter().copied() {
            let (this, other) = (find(row, bytes)?, find(beside, bytes)?);
            let ratio = this.median_ns / other.median_ns;
            goals.push(Goal {
                row,
                beside,
                bytes,
                goal,
                ratio,
                quietest_ratio: this.quietest_ns / other.quietest_ns,
                reached: ratio <= goal,
            });
        }
    }
    Ok(goals)
}

fn print(rows: &[Row], goals: &[Goal], deaths: &[Death]) {
    println!(
        "{:<13} {:>8} {:>10} {:>10} {:>10} {:>10} {:>9} {:>7}   (latency one way in microseconds)",
        "ROW", "BYTES", "MEDIAN", "P99", "QUIETEST", "SAMPLES/S", "MB/S", "ALLOCS"
    );
    for row in rows {
        println!(
            "{:<13} {:>8} {:>10.3} {:>10.3} {:>10.3} {:>10.0} {:>9.1} {:>7.3}",
            row.row,
            row.bytes,
            row.median_ns / 1e3,
            row.p99_ns / 1e3,
            row.quietest_ns / 1e3,
            row.per_second,
            row.megabytes_per_second,
            row.allocations_per_sample
        );
    }
    println!();
    println!(
        "{:<13} {:<13} {:>8} {:>8} {:>8} {:>8}",
        "ROW", "BESIDE", "BYTES", "RATIO", "QUIETEST", "AT MOST"
    );
    for goal in goals {
        let mark = if goal.reached { "" } else { "   not reached" };
        println!(
            "{:<13} {:<13} {:>8} {:>8.2} {:>8.2} {:>8.2}{mark}",
            goal.row, goal.beside, goal.bytes, goal.ratio, goal.quietest_ratio, goal.goal
        );
    }
    println!();
    println!(
        "{:<13} {:>10} {:>10}   (milliseconds until a killed process is noticed at both ends)",
        "DEATH", "MEDIAN", "MOST"
    );
    for death in deaths {
        println!(
            "{:<13} {:>10.2} {:>10.2}",
            death.row, death.median_ms, death.most_ms
        );
    }
}
