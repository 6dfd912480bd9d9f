//! Seconds that one plan takes: `plan_time COMPONENTS first|no-op|one-change RUNS`, one line for each run.

#![allow(
    clippy::disallowed_methods,
    reason = "it measures; the planner does not"
)]

mod fleet;

use std::hint::black_box;
use std::process::ExitCode;
use std::time::Instant;

use fleet::{Case, fleet};
use rts_plan::plan::Blocked;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [components, case, runs] = words.as_slice() else {
        return usage();
    };
    let (Ok(components), Some(case), Ok(runs)) =
        (components.parse(), Case::named(case), runs.parse::<u32>())
    else {
        return usage();
    };
    let (desired, observed) = fleet(components, case);
    let blocked = Blocked::new();
    for _ in 0..runs {
        let start = Instant::now();
        let plan = rts_plan::plan(black_box(&desired), black_box(&observed), &blocked);
        let seconds = start.elapsed().as_secs_f64();
        println!("{seconds:.9} {}", plan.steps.len());
    }
    ExitCode::SUCCESS
}

fn usage() -> ExitCode {
    eprintln!("usage: plan_time COMPONENTS first|no-op|one-change RUNS");
    ExitCode::from(2)
}
