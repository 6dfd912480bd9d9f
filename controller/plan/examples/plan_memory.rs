//! Bytes that one plan takes at its peak, beside what goes into it: `plan_memory COMPONENTS first|no-op|one-change`.
//! Apart from `plan_time`, since counting costs time.

#![allow(
    clippy::disallowed_methods,
    reason = "it measures; the planner does not"
)]

mod fleet;

use std::hint::black_box;
use std::process::ExitCode;

use fleet::{Case, fleet};
use peak_alloc::PeakAlloc;
use rts_plan::plan::Blocked;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [components, case] = words.as_slice() else {
        return usage();
    };
    let (Ok(components), Some(case)) = (components.parse::<usize>(), Case::named(case)) else {
        return usage();
    };
    let (desired, observed) = fleet(components, case);
    let blocked = Blocked::new();
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let plan = rts_plan::plan(black_box(&desired), black_box(&observed), &blocked);
    let peak = MEMORY.peak_usage().saturating_sub(before);
    println!("{peak} {}", plan.steps.len());
    ExitCode::SUCCESS
}

fn usage() -> ExitCode {
    eprintln!("usage: plan_memory COMPONENTS first|no-op|one-change");
    ExitCode::from(2)
}
