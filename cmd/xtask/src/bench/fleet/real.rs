//! Many components in few real processes of this machine: what one costs.

use std::fmt::Write;
use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use serde::Serialize;
use serde_json::Value;

use super::system::{NAME, System};
use crate::bench::process;
use crate::bench::stack::Stack;

/// Cycles of each component a second.
pub const RATE: f64 = 10.0;
/// After the start, until what it needed has calmed down.
const CALM: Duration = Duration::from_secs(2);
/// Longest time of one command.
const DEADLINE: &str = "600s";

/// What is to run.
#[derive(Debug, Clone, Copy)]
pub struct What {
    /// Components.
    pub components: u32,
    /// Processes that they share.
    pub managers: u32,
    /// Half of the components of a process share an execution context; else each has a thread of its own, which is the default.
    pub shared: bool,
    /// Seconds for which they are watched.
    pub seconds: u64,
}

/// What it cost.
#[derive(Debug, Serialize)]
pub struct Real {
    /// `real-COMPONENTS-own` or `real-COMPONENTS-shared`.
    row: String,
    components: u32,
    managers: usize,
    /// Threads of all managers.
    threads: usize,
    apply_ms: f64,
    teardown_ms: f64,
    /// Of all managers, percent of one processor.
    cpu_percent: f64,
    /// Of controller and agent.
    daemons_cpu_percent: f64,
    /// Of all managers with all components, bytes.
    pss_bytes: u64,
    pss_bytes_per_component: f64,
    /// Cycles that began in the time that was watched.
    cycles: u64,
    /// Cycles that were missed.
    overruns: u64,
    /// How late cycles began: medians and 99th percentiles of the components, the median and the worst of these, microseconds.
    jitter_median_us: f64,
    jitter_p99_us: f64,
    jitter_max_us: f64,
}

/// Cycles of all components, as they say themselves.
#[derive(Debug, Default)]
struct Timing {
    active: usize,
    cycles: u64,
    overruns: u64,
    median: Vec<u64>,
    p99: Vec<u64>,
    max: u64,
}

/// Deploys it, watches it, takes it down.
pub fn measure(programs: &Path, what: &What) -> Result<Real> {
    let stack = Stack::start(programs)?;
    let system = System {
        nodes: what.managers,
        components: what.components,
        type_name: "LowPassFilter",
        parameter: "gain",
        value: 1.0,
    };
    let profile = system.write(&stack.folder.path().join("fleet.xml"))?;
    let overlay = stack.folder.path().join("overlay.yaml");
    std::fs::write(&overlay, self::overlay(what)).context("cannot write the overlay")?;
    let (profile, overlay) = (profile.to_string_lossy(), overlay.to_string_lossy());
    let apply = stack.timed(&[
        "apply",
        "-f",
        &profile,
        "-f",
        &overlay,
        "--timeout",
        DEADLINE,
    ])?;
    sleep(CALM);
    let home = stack.home();
    let managers = process::managers(&home, "local");
    let daemons = [
        process::named_in(&home.join("run/controller.json"))?,
        process::named_in(&home.join("run/local/agent.json"))?,
    ];
    let cpu = || (process::cpu_of(&managers), process::cpu_of(&daemons));
    let (before, begin) = (timing(&stack)?, Instant::now());
    let used = cpu();
    sleep(Duration::from_secs(what.seconds));
    let (now, took) = (cpu(), begin.elapsed().as_secs_f64());
    let percent = |a: Duration, b: Duration| 100.0 * a.saturating_sub(b).as_secs_f64() / took;
    let (cpu_percent, daemons_cpu_percent) = (percent(now.0, used.0), percent(now.1, used.1));
    let after = timing(&stack)?;
    ensure!(
        after.active == what.components as usize,
        "{} of {} components are Active",
        after.active,
        what.components
    );
    let (memory, threads) = (
        process::memory_of(&managers),
        process::threads_of(&managers),
    );
    let teardown = stack.timed(&["teardown", NAME, "--yes", "--timeout", DEADLINE])?;
    stack.stop()?;
    let middle = |mut all: Vec<u64>| {
        all.sort_unstable();
        all.get(all.len() / 2).copied().unwrap_or_default() as f64 / 1e3
    };
    let worst = after.p99.iter().max().copied().unwrap_or_default();
    let kind = if what.shared { "shared" } else { "own" };
    Ok(Real {
        row: format!("real-{}-{kind}", what.components),
        components: what.components,
        managers: managers.len(),
        threads,
        apply_ms: apply.as_secs_f64() * 1e3,
        teardown_ms: teardown.as_secs_f64() * 1e3,
        cpu_percent,
        daemons_cpu_percent,
        pss_bytes: memory.pss,
        pss_bytes_per_component: memory.pss as f64 / f64::from(what.components),
        cycles: after.cycles.saturating_sub(before.cycles),
        overruns: after.overruns.saturating_sub(before.overruns),
        jitter_median_us: middle(after.median),
        jitter_p99_us: worst as f64 / 1e3,
        jitter_max_us: after.max as f64 / 1e3,
    })
}

/// Where the components run: those of a node of the system in a process of this machine.
fn overlay(what: &What) -> String {
    let mut text =
        String::from("apiVersion: rtsctl.dev/v1\nkind: Deployment\nspec:\n  components:\n");
    for manager in 0..what.managers {
        for half in ["a", "b"] {
            let context = match what.shared {
                true => format!(", executionContext: {{ name: m{manager}{half} }}"),
                false => String::new(),
            };
            // Writing into a text cannot fail.
            let _ = writeln!(
                text,
                "    \"N{manager}{half}*\": {{ node: local, manager: m{manager}{context} }}"
            );
        }
    }
    text
}

fn timing(stack: &Stack) -> Result<Timing> {
    let text = stack.output(&["get", "components", "-o", "json"])?;
    let list: Value = serde_json::from_str(&text)?;
    let mut all = Timing::default();
    for item in list["items"].as_array().context("no list of components")? {
        let status = &item["status"];
        all.active += usize::from(status["state"] == "Active");
        let number = |value: &Value| value.as_u64().unwrap_or_default();
        let (timing, jitter) = (&status["timing"], &status["timing"]["jitter"]);
        all.cycles += number(&jitter["count"]);
        all.overruns += number(&timing["overruns"]);
        all.median.push(number(&jitter["median"]));
        all.p99.push(number(&jitter["p99"]));
        all.max = all.max.max(number(&jitter["max"]));
    }
    Ok(all)
}

/// Prints what was measured as a table.
pub fn print(reals: &[Real]) {
    println!(
        "{:<18} {:>9} {:>8} {:>9} {:>12} {:>7} {:>8} {:>8} {:>8} {:>7} {:>11} {:>9} {:>9}",
        "ROW",
        "PROCESSES",
        "THREADS",
        "APPLY MS",
        "TEARDOWN MS",
        "CPU %",
        "DAEMONS",
        "PSS MB",
        "KB/COMP",
        "CYCLES",
        "OVERRUNS",
        "MEDIAN US",
        "P99 US"
    );
    for real in reals {
        println!(
            "{:<18} {:>9} {:>8} {:>9.1} {:>12.1} {:>7.1} {:>8.1} {:>8.1} {:>8.1} {:>7} {:>11} {:>9.0} {:>9.0}",
            real.row,
            real.managers,
            real.threads,
            real.apply_ms,
            real.teardown_ms,
            real.cpu_percent,
            real.daemons_cpu_percent,
            real.pss_bytes as f64 / 1e6,
            real.pss_bytes_per_component / 1e3,
            real.cycles,
            real.overruns,
            real.jitter_median_us,
            real.jitter_p99_us
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_overlay_puts_a_node_into_a_process() {
        let what = |shared| What {
            components: 4,
            managers: 1,
            shared,
            seconds: 1,
        };
        let own = overlay(&what(false));
        assert!(
            own.ends_with("    \"N0b*\": { node: local, manager: m0 }\n"),
            "{own}"
        );
        let shared = overlay(&what(true));
        assert!(
            shared.contains("manager: m0, executionContext: { name: m0a } }"),
            "{shared}"
        );
    }
}
