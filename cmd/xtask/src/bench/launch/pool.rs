//! Managers that wait for their first component: what a launch takes with and without them, and what they cost.

use std::path::Path;
use std::process::Command;
use std::thread::sleep;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use serde::Serialize;

use super::{Case, MANY, Profile, case};
use crate::bench::process;
use crate::bench::stack::Stack;

/// The variable that says how many wait, and the option that shows that an agent knows of it.
const VARIABLE: &str = "RTSCTL_IDLE_MANAGERS";
const OPTION: &str = "--idle-managers";
/// Sizes that are compared.
const SIZES: [usize; 2] = [0, 2];
/// Name of a manager that waits.
const NAME: &str = "rts-idle";
/// Longest wait until the pool is full.
const LIMIT: Duration = Duration::from_secs(10);
/// Between two looks.
const LOOK: Duration = Duration::from_millis(1);

/// A stack whose agent keeps so many managers.
pub struct Pool {
    size: usize,
    stack: Stack,
}

/// What waiting managers cost.
#[derive(Debug, Serialize)]
pub struct Cost {
    /// How many wait, and the process that forks them if there is one.
    pool: usize,
    processes: usize,
    /// Of all of them together, bytes.
    pss_bytes: u64,
    /// From the end of an apply that took one until all wait again, milliseconds.
    refill_ms: f64,
    /// Processor time of a manager from its start until it waits, milliseconds.
    cpu_ms_each: f64,
}

/// Stacks of both sizes; none when the agent knows nothing of it, which is told.
pub fn stacks(programs: &Path) -> Result<Vec<Pool>> {
    let help = Command::new(programs.join("rts-agent"))
        .arg("--help")
        .output()?;
    if !String::from_utf8_lossy(&help.stdout).contains(OPTION) {
        eprintln!("rts-agent has no {OPTION}: the rows of its pool are left out");
        return Ok(Vec::new());
    }
    let start = |size: usize| {
        let size_text = size.to_string();
        let stack = Stack::start_with(programs, &[(VARIABLE, &size_text)])?;
        Ok(Pool { size, stack })
    };
    SIZES.into_iter().map(start).collect()
}

/// The rows of a pool.
pub fn cases(pool: &Pool) -> Result<Vec<Case<'_>>> {
    let (folder, size) = (pool.stack.folder.path(), pool.size);
    let one = Profile::new("one", 1, true).write(folder)?;
    let separate = Profile::new("separate", MANY, true).write(folder)?;
    let row = |components| format!("agent-{components}-separate-pool-{size}");
    Ok(vec![
        case(&row(1), 1, &pool.stack, "one", one),
        case(&row(MANY), MANY, &pool.stack, "separate", separate),
    ])
}

impl Pool {
    /// What it costs, once all have had time to start.
    pub fn cost(&self) -> Result<Cost> {
        let waiting = self.full()?;
        let idle = waiting.iter().copied().filter(|pid| is_manager(*pid));
        let idle: Vec<u32> = idle.collect();
        let memory = process::memory_of(&waiting);
        let cpu = process::cpu_of(&idle).as_secs_f64() * 1e3;
        let one = Profile::new("one", 1, true).write(self.stack.folder.path())?;
        super::apply(&self.stack, &one)?;
        let begin = Instant::now();
        self.full()?;
        let refill = begin.elapsed();
        super::teardown(&self.stack, "one")?;
        Ok(Cost {
            pool: self.size,
            processes: waiting.len(),
            pss_bytes: memory.pss,
            refill_ms: refill.as_secs_f64() * 1e3,
            cpu_ms_each: cpu / idle.len().max(1) as f64,
        })
    }

    /// Waits until all wait: they and the process that forks them, below the agent and without a run folder.
    fn full(&self) -> Result<Vec<u32>> {
        let home = self.stack.home();
        let agent = process::named_in(&home.join("run/local/agent.json"))?;
        let begin = Instant::now();
        loop {
            let taken = process::managers(&home, "local");
            let mut waiting = process::below(agent);
            waiting.retain(|pid| !taken.contains(pid));
            let managers = waiting.iter().filter(|pid| is_manager(**pid)).count();
            if managers >= self.size {
                return Ok(waiting);
            }
            let late = begin.elapsed() > LIMIT;
            (!late).then_some(()).with_context(|| {
                format!("{managers} of {} managers wait after {LIMIT:?}", self.size)
            })?;
            sleep(LOOK);
        }
    }

    /// Ends it.
    pub fn stop(self) -> Result<()> {
        self.stack.stop()
    }
}

fn is_manager(pid: u32) -> bool {
    let name = std::fs::read_to_string(format!("/proc/{pid}/comm"));
    name.is_ok_and(|name| name.trim_end() == NAME)
}

/// Prints what pools cost as a table.
pub fn print(costs: &[Cost]) {
    println!(
        "{:>5} {:>9} {:>10} {:>10} {:>12}   (processes that hold no component)",
        "POOL", "PROCESSES", "PSS MB", "REFILL MS", "CPU MS EACH"
    );
    for cost in costs {
        println!(
            "{:>5} {:>9} {:>10.2} {:>10.1} {:>12.2}",
            cost.pool,
            cost.processes,
            cost.pss_bytes as f64 / 1e6,
            cost.refill_ms,
            cost.cpu_ms_each
        );
    }
}
