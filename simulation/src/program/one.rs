//! One seed, to be looked at.

use std::io;

use serde_json::json;

use super::args::Args;
use super::seeds::shrink;
use super::show::{self, Failure};
use crate::run::{self, Options};
use crate::schedule::Schedule;
use crate::seed::Seed;

/// Runs it, or prints its schedule. False when an invariant did not hold.
pub(super) fn run(args: &Args, seed: u64) -> io::Result<bool> {
    let whole = Schedule::of(Seed(seed));
    let unknown = show::unknown(&whole, &args.without);
    if !unknown.is_empty() {
        let names = unknown.join(", ");
        return Err(io::Error::other(format!(
            "the schedule of seed {seed} has no {names}"
        )));
    }
    let schedule = whole.without(&args.without);
    if args.schedule {
        print!("{schedule}");
        return Ok(true);
    }
    let options = Options {
        trace: args.trace,
        log: args.log,
    };
    let outcome = run::run(&schedule, options)?;
    for line in &outcome.text {
        println!("{line}");
    }
    let (time, happened) = (outcome.time.as_secs_f64(), outcome.happened);
    let Some(violation) = outcome.violation else {
        if args.json {
            let hash = format!("{:016x}", outcome.hash);
            let ok = json!({"seed": seed, "time": time, "happened": happened, "hash": hash,
                "coverage": outcome.coverage});
            println!("{ok}");
        } else {
            println!(
                "seed {seed} held: {time:.1} s of simulated time, {happened} things happened, trace {:016x}",
                outcome.hash
            );
            show::coverage(&outcome.coverage);
        }
        return Ok(true);
    };
    let minimised = if args.minimise {
        shrink(&schedule, violation.invariant)?
    } else {
        None
    };
    let failure = Failure {
        seed,
        violation,
        schedule,
        minimised,
    };
    if args.json {
        println!("{}", failure.json());
    } else {
        failure.print();
    }
    Ok(false)
}
