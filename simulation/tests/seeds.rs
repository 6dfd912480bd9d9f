//! Some seeds, run whole: all invariants hold, and a seed is the same run each time, in this process and in another.

#![allow(clippy::unwrap_used)]

use std::process::Command;

use rts_simulation::Seed;
use rts_simulation::run::{Options, Outcome, run};
use rts_simulation::schedule::Schedule;

fn play(seed: u64, trace: bool) -> Outcome {
    let options = Options { trace, log: trace };
    run(&Schedule::of(Seed(seed)), options).unwrap()
}

#[test]
fn invariants_hold() {
    for seed in 0..24 {
        let outcome = play(seed, false);
        if let Some(violation) = outcome.violation {
            panic!("seed {seed}: {violation}\n{}", Schedule::of(Seed(seed)));
        }
    }
}

#[test]
fn a_seed_is_the_same_run_each_time() {
    let mut lengths = Vec::new();
    for seed in 100..120 {
        let (first, second) = (play(seed, true), play(seed, true));
        assert!(first.text.len() > 50, "{:#?}", first.text);
        for (first, second) in first.text.iter().zip(&second.text) {
            assert_eq!(first, second, "seed {seed}");
        }
        assert_eq!(first.hash, second.hash, "seed {seed}");
        lengths.push(first.text.len());
    }
    // They are not the same run.
    lengths.sort_unstable();
    lengths.dedup();
    assert!(lengths.len() > 10);
}

#[test]
fn a_seed_is_the_same_run_in_another_process() {
    for seed in ["4", "7", "21", "57", "90"] {
        let output = || {
            let mut command = Command::new(env!("CARGO_BIN_EXE_simulate"));
            let output = command.args(["--seed", seed, "--log"]).output().unwrap();
            String::from_utf8(output.stdout).unwrap()
        };
        let first = output();
        assert!(first.lines().count() > 50, "{first}");
        assert_eq!(first, output());
    }
}
