//! `cargo xtask bench idle`: what a stack costs that does nothing, and how long it takes until it answers.

mod cost;
mod start;

use std::path::Path;
use std::time::Duration;

use anyhow::Result;
use serde_json::json;

use self::cost::Cost;
use super::scene::Scene;
use super::{Common, goals, stats};

/// Most memory that controller and agent may have with nothing deployed, bytes (PSS).
const MEMORY: f64 = 11e6;
/// Longest time until the API of controller and agent is ready, milliseconds.
const READY: f64 = 50.0;

/// Arguments of `cargo xtask bench idle`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Seconds over which processor time is taken.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=3600))]
    seconds: u64,
    /// Components of the stack that is not empty.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=1000))]
    components: u32,
    #[command(flatten)]
    common: Common,
}

/// Measures the starts in turns, then the costs, and prints both.
pub fn run(args: &Args) -> Result<()> {
    let (build, programs) = args.common.programs()?;
    let scene = Scene::begin(build);
    let folder = tempfile::Builder::new().prefix("rtsb").tempdir_in("/tmp")?;
    let mut turns = start::turns(&programs, folder.path());
    let starts = stats::take_turns(&mut turns, args.common.runs)?;
    drop(turns);
    let costs = measure(args, &programs)?;
    let scene = scene.end();
    let goals = goals(&starts, &costs);
    if args.common.json {
        let all = json!({"rows": starts, "costs": costs, "goals": goals, "scene": scene});
        println!("{}", serde_json::to_string_pretty(&all)?);
        return Ok(());
    }
    println!("{scene}");
    println!("start to the first `200` of /readyz, from exec");
    stats::print(&starts, false)?;
    println!("\nat rest, processor time over {} s", args.seconds);
    cost::print(&costs);
    println!();
    goals::print(&goals);
    Ok(())
}

fn measure(args: &Args, programs: &Path) -> Result<Vec<Cost>> {
    let seconds = Duration::from_secs(args.seconds);
    let mut costs = cost::measure(programs, 0, args.common.runs, seconds)?;
    // One component more or less in a process does not depend on chance as a start does.
    costs.extend(cost::measure(programs, args.components, 1, seconds)?);
    Ok(costs)
}

fn goals(starts: &[stats::Row], costs: &[Cost]) -> Vec<goals::Goal> {
    let both = |cost: &&Cost| cost.process == cost::BOTH && cost.components == 0;
    let memory = costs.iter().find(both);
    let ready = |row: &str| starts.iter().find(|found| found.row == row);
    let mut goals = Vec::new();
    if let Some(cost) = memory {
        let said = "PSS of controller and agent with nothing deployed, MB";
        let (reached, limit) = (cost.pss_bytes as f64 / 1e6, MEMORY / 1e6);
        goals.push(goals::Goal::at_most(said, reached, limit));
    }
    for row in [start::CONTROLLER, start::AGENT, start::BOTH] {
        if let Some(found) = ready(row) {
            let said = format!("{row}: API ready, median ms");
            goals.push(goals::Goal::at_most(&said, found.median_ms, READY));
        }
    }
    goals
}
