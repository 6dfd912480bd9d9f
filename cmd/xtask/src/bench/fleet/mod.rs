//! `cargo xtask bench fleet`: what grows with the number of nodes and components, and how.

mod real;
mod row;
mod simulated;
mod system;

use std::time::Duration;

use anyhow::Result;
use serde_json::json;

use super::scene::Scene;
use super::{Common, goals};

/// Nodes and components of each fleet: what grows tenfold from one to the next is to cost ten times as much.
const SIZES: [(u32, u32); 5] = [
    (10, 100),
    (100, 1_000),
    (100, 10_000),
    (1_000, 1_000),
    (1_000, 10_000),
];

/// Arguments of `cargo xtask bench fleet`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Only fleets of up to so many nodes.
    #[arg(long, default_value_t = 1_000, value_name = "NUMBER")]
    nodes: u32,
    /// Only fleets of up to so many components.
    #[arg(long, default_value_t = 10_000, value_name = "NUMBER")]
    components: u32,
    /// Only the fleets of simulated agents, or only the real processes.
    #[arg(long, value_enum)]
    only: Option<Part>,
    /// A fleet of 20 nodes with 200 components, and 20 components in 2 real processes: whether it works, not how fast.
    #[arg(long)]
    short: bool,
    /// Counted runs of each action, after one that is not counted.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    runs: u32,
    /// Seconds for which real components are watched; a fleet that rests, at most 5 of them.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=3600))]
    seconds: u64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Measure what is built already with this cargo profile; by default a release build is made first.
    #[arg(long, value_name = "PROFILE")]
    built: Option<String>,
}

/// A part of the benchmark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Part {
    Simulated,
    Real,
}

/// Measures the fleets from small to large, then real processes, and prints all.
pub fn run(args: &Args) -> Result<()> {
    let common = Common {
        runs: args.runs,
        json: args.json,
        built: args.built.clone(),
    };
    let (build, programs) = common.programs()?;
    let scene = Scene::begin(build);
    // Of a fleet at rest there is less to see than of components that run.
    let watched = Duration::from_secs(args.seconds.min(5));
    let (mut rows, mut reals) = (Vec::new(), Vec::new());
    if args.only != Some(Part::Real) {
        for (nodes, components) in sizes(args) {
            eprintln!("{components} components on {nodes} nodes");
            let found = simulated::measure(&programs, nodes, components, args.runs, watched)?;
            rows.extend(found);
        }
    }
    if args.only != Some(Part::Simulated) {
        let components = if args.short { 20 } else { 1_000 };
        let managers = if args.short { 2 } else { 10 };
        for shared in [false, true] {
            eprintln!("{components} components in {managers} processes");
            let what = real::What {
                components,
                managers,
                shared,
                seconds: args.seconds,
            };
            reals.push(real::measure(&programs, &what)?);
        }
    }
    let scene = scene.end();
    let goals = growth(&rows);
    if args.json {
        let all = json!({"rows": rows, "real": reals, "goals": goals, "scene": scene});
        println!("{}", serde_json::to_string_pretty(&all)?);
        return Ok(());
    }
    println!("{scene}");
    if !rows.is_empty() {
        println!(
            "real controller and agents, simulated managers; CPU and PSS are the controller's"
        );
        row::print(&rows);
    }
    if !reals.is_empty() {
        println!("\nreal processes, each component at {} Hz", real::RATE);
        real::print(&reals);
    }
    if !goals.is_empty() {
        println!();
        goals::print(&goals);
    }
    Ok(())
}

fn sizes(args: &Args) -> Vec<(u32, u32)> {
    if args.short {
        return vec![(20, 200)];
    }
    let fits =
        |(nodes, components): &(u32, u32)| *nodes <= args.nodes && *components <= args.components;
    SIZES.into_iter().filter(fits).collect()
}

/// Ten times the nodes and components are to take about ten times the processor time of the controller.
fn growth(rows: &[row::Row]) -> Vec<goals::Goal> {
    const MOST: f64 = 15.0;
    let cpu = |nodes: u32, components: u32, action: &str| {
        let of = |row: &&row::Row| {
            row.nodes == nodes && row.components == components && row.action == action
        };
        rows.iter().find(of).map(|row| row.controller_cpu_s)
    };
    let grown = ["apply", "no-op", "one-change", "teardown"].map(|action| {
        let ratio = cpu(1_000, 10_000, action)? / cpu(100, 1_000, action)?;
        let said = format!("{action}: CPU of 10,000 components on 1,000 nodes / 1,000 on 100");
        Some(goals::Goal::at_most(&said, ratio, MOST))
    });
    grown.into_iter().flatten().collect()
}
