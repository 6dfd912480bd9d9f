//! Memory and processor time of the processes of a stack at rest.

use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant};

use anyhow::Result;
use serde::Serialize;

use crate::bench::launch::Profile;
use crate::bench::process;
use crate::bench::stack::Stack;

/// Name of controller and agent together.
pub const BOTH: &str = "controller + agent";
/// Time for what a start leaves behind to calm down: pools are filled, caches freed.
const CALM: Duration = Duration::from_millis(1500);

/// What processes cost, all of a kind together.
#[derive(Debug, Clone, Serialize)]
pub struct Cost {
    /// Components that run in the stack.
    pub components: u32,
    /// Which processes.
    pub process: &'static str,
    /// How many.
    pub processes: usize,
    /// Their threads.
    pub threads: usize,
    /// Proportional set size of all, median of the runs.
    pub pss_bytes: u64,
    /// Resident set size of all, median of the runs.
    pub rss_bytes: u64,
    /// Processor time over the time that was looked at, in percent of one processor, in the last run.
    pub cpu_percent: f64,
    /// Runs.
    pub n: u32,
}

/// Stacks with so many components, one after the other. Processor time is taken in the last of them.
pub fn measure(
    programs: &Path,
    components: u32,
    runs: u32,
    seconds: Duration,
) -> Result<Vec<Cost>> {
    let mut all: Vec<Vec<Cost>> = Vec::new();
    for run in 1..=runs {
        let length = if run == runs { seconds } else { Duration::ZERO };
        all.push(one(programs, components, length)?);
    }
    let Some(last) = all.last().cloned() else {
        return Ok(Vec::new());
    };
    let median = |process: &str, of: fn(&Cost) -> u64| {
        let found = all.iter().flatten().filter(|cost| cost.process == process);
        let mut found: Vec<u64> = found.map(of).collect();
        found.sort_unstable();
        found.get(found.len() / 2).copied().unwrap_or_default()
    };
    let rows = last.into_iter().map(|cost| Cost {
        pss_bytes: median(cost.process, |cost| cost.pss_bytes),
        rss_bytes: median(cost.process, |cost| cost.rss_bytes),
        n: runs,
        ..cost
    });
    Ok(rows.collect())
}

fn one(programs: &Path, components: u32, length: Duration) -> Result<Vec<Cost>> {
    let stack = Stack::start(programs)?;
    if components > 0 {
        let profile = Profile::new("idle", components, false).write(stack.folder.path())?;
        stack.rtsctl(&["apply", &profile.to_string_lossy()])?;
    }
    sleep(CALM);
    let kinds = kinds(&stack)?;
    let cpu = |kinds: &[(&str, Vec<u32>)]| -> Vec<Duration> {
        kinds
            .iter()
            .map(|(_, pids)| process::cpu_of(pids))
            .collect()
    };
    let (before, begin) = (cpu(&kinds), Instant::now());
    sleep(length);
    let (after, took) = (cpu(&kinds), begin.elapsed());
    let spent = after.iter().zip(before).map(|(a, b)| a.saturating_sub(b));
    let rows = kinds.iter().zip(spent).map(|((process, pids), spent)| {
        let memory = process::memory_of(pids);
        Cost {
            components,
            process,
            processes: pids.len(),
            threads: process::threads_of(pids),
            pss_bytes: memory.pss,
            rss_bytes: memory.rss,
            cpu_percent: match length {
                Duration::ZERO => 0.0,
                _ => 100.0 * spent.as_secs_f64() / took.as_secs_f64(),
            },
            n: 1,
        }
    });
    let rows = rows.collect();
    stack.stop()?;
    Ok(rows)
}

/// The processes of a stack by what they are. Managers that hold nothing wait for their first component below the agent.
fn kinds(stack: &Stack) -> Result<Vec<(&'static str, Vec<u32>)>> {
    let home = stack.home();
    let controller = process::named_in(&home.join("run/controller.json"))?;
    let agent = process::named_in(&home.join("run/local/agent.json"))?;
    let managers = process::managers(&home, "local");
    let mut waiting = process::below(agent);
    waiting.retain(|pid| !managers.contains(pid));
    let mut all = [vec![controller, agent], waiting.clone(), managers.clone()].concat();
    all.sort_unstable();
    let mut kinds = vec![
        ("controller", vec![controller]),
        ("agent", vec![agent]),
        (BOTH, vec![controller, agent]),
        ("zygote, idle managers", waiting),
        ("managers", managers),
        ("all", all),
    ];
    kinds.retain(|(_, pids)| !pids.is_empty());
    Ok(kinds)
}

/// Prints costs as a table.
pub fn print(costs: &[Cost]) {
    println!(
        "{:>10} {:<22} {:>5} {:>9} {:>8} {:>8} {:>8} {:>7}",
        "COMPONENTS", "PROCESSES", "RUNS", "PROCESSES", "THREADS", "PSS MB", "RSS MB", "CPU %"
    );
    for cost in costs {
        println!(
            "{:>10} {:<22} {:>5} {:>9} {:>8} {:>8.2} {:>8.2} {:>7.2}",
            cost.components,
            cost.process,
            cost.n,
            cost.processes,
            cost.threads,
            cost.pss_bytes as f64 / 1e6,
            cost.rss_bytes as f64 / 1e6,
            cost.cpu_percent
        );
    }
}
