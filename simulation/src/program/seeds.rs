//! Many seeds, each in a thread of its own, as many at a time as there are cores.

use std::collections::BTreeMap;
use std::io;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::json;

use super::args::Args;
use super::show::{self, Failure};
use crate::check::Violation;
use crate::minimise::{Minimised, minimise};
use crate::run::{self, Options};
use crate::schedule::Schedule;
use crate::seed::Seed;

/// A seed that takes longer, in real time, goes round in a circle.
const STUCK: Duration = Duration::from_secs(120);
/// Time between two lines of progress.
const PROGRESS: Duration = Duration::from_secs(10);
/// How often it is looked whether all is done.
const LOOK: Duration = Duration::from_millis(100);
/// Runs that are made to make a schedule smaller.
const TRIES: u32 = 400;

/// What the threads share.
struct Work {
    next: AtomicU64,
    done: AtomicU64,
    stop: AtomicBool,
    threads: AtomicU64,
    found: Mutex<Found>,
    /// Seeds that run, and since when.
    running: Mutex<BTreeMap<u64, Instant>>,
}

#[derive(Default)]
struct Found {
    failures: Vec<(Schedule, Violation)>,
    coverage: BTreeMap<String, u64>,
    time: Duration,
    trouble: Option<io::Error>,
}

/// Runs them. False when an invariant did not hold.
pub(super) fn run(args: &Args) -> io::Result<bool> {
    let end = args.start.saturating_add(args.seeds);
    let work = Work {
        next: AtomicU64::new(args.start),
        done: AtomicU64::new(0),
        stop: AtomicBool::new(false),
        threads: AtomicU64::new(args.jobs as u64),
        found: Mutex::default(),
        running: Mutex::default(),
    };
    let began = Instant::now();
    thread::scope(|scope| {
        for _ in 0..args.jobs {
            scope.spawn(|| {
                work.run(end, args.keep_going);
                work.threads.fetch_sub(1, Ordering::SeqCst);
            });
        }
        work.watch(args, began);
    });
    let found = work
        .found
        .into_inner()
        .unwrap_or_else(PoisonError::into_inner);
    if let Some(trouble) = found.trouble {
        return Err(trouble);
    }
    let seeds = work.done.into_inner();
    finish(args, found, seeds, began.elapsed())
}

impl Work {
    fn run(&self, end: u64, keep_going: bool) {
        while !self.stop.load(Ordering::SeqCst) {
            let seed = self.next.fetch_add(1, Ordering::SeqCst);
            if seed >= end {
                return;
            }
            lock(&self.running).insert(seed, Instant::now());
            let schedule = Schedule::of(Seed(seed));
            let outcome = run::run(&schedule, Options::default());
            lock(&self.running).remove(&seed);
            self.done.fetch_add(1, Ordering::SeqCst);
            let mut found = lock(&self.found);
            match outcome {
                Ok(outcome) => {
                    for (what, count) in outcome.coverage {
                        *found.coverage.entry(what).or_default() += count;
                    }
                    found.time += outcome.time;
                    if let Some(violation) = outcome.violation {
                        // The rest comes at the end, which may be hours away.
                        eprintln!("seed {seed} fails: {}", violation.invariant);
                        found.failures.push((schedule, violation));
                        self.stop.fetch_or(!keep_going, Ordering::SeqCst);
                    }
                }
                Err(e) => {
                    found.trouble = Some(e);
                    self.stop.store(true, Ordering::SeqCst);
                }
            }
        }
    }

    /// Tells how it goes. Ends the process where a seed goes round in a circle: nothing else ends its thread.
    fn watch(&self, args: &Args, began: Instant) {
        let mut told = Instant::now();
        while self.threads.load(Ordering::SeqCst) > 0 {
            thread::sleep(LOOK);
            let running = lock(&self.running);
            let mut stuck = running.iter().filter(|(_, since)| since.elapsed() > STUCK);
            if let Some((seed, _)) = stuck.next() {
                let seconds = STUCK.as_secs();
                println!("seed {seed} FAILED: it does not end within {seconds} s of real time");
                println!("replay: cargo xtask simulate --seed {seed}");
                std::process::exit(1);
            }
            drop(running);
            if told.elapsed() >= PROGRESS {
                told = Instant::now();
                let failed = lock(&self.found).failures.len();
                let done = self.done.load(Ordering::SeqCst);
                let seconds = began.elapsed().as_secs();
                eprintln!(
                    "{done} of {} seeds in {seconds} s, {failed} failed",
                    args.seeds
                );
            }
        }
    }
}

fn finish(args: &Args, mut found: Found, seeds: u64, took: Duration) -> io::Result<bool> {
    let held = found.failures.is_empty();
    found.failures.sort_by_key(|(schedule, _)| schedule.seed);
    let mut failures = Vec::new();
    for (nth, (schedule, violation)) in found.failures.into_iter().enumerate() {
        // The first one is enough to begin with.
        let small = args.minimise && nth == 0;
        let minimised = if small {
            shrink(&schedule, violation.invariant)?
        } else {
            None
        };
        failures.push(Failure {
            seed: schedule.seed,
            violation,
            schedule,
            minimised,
        });
    }
    if args.json {
        let all: Vec<_> = failures.iter().map(Failure::json).collect();
        println!(
            "{}",
            json!({"seeds": seeds, "start": args.start, "failed": all.len(), "failures": all,
                "seconds": took.as_secs_f64(), "simulatedSeconds": found.time.as_secs_f64(),
                "coverage": found.coverage})
        );
        return Ok(held);
    }
    for (nth, failure) in failures.iter().enumerate() {
        if nth == 0 {
            failure.print();
        } else {
            println!("seed {} FAILED {}", failure.seed, failure.violation);
        }
    }
    let each = took.as_secs_f64() * 1000.0 / (seeds.max(1) as f64);
    println!(
        "{seeds} seeds, {} failed: {:.0} h of simulated time in {:.1} s, {each:.1} ms a seed",
        failures.len(),
        found.time.as_secs_f64() / 3600.0,
        took.as_secs_f64(),
    );
    show::coverage(&found.coverage);
    Ok(held)
}

/// Makes a schedule smaller in which the same invariant fails.
pub(super) fn shrink(
    schedule: &Schedule,
    invariant: &str,
) -> io::Result<Option<(Minimised, Violation)>> {
    let fails = |schedule: &Schedule| {
        let outcome = run::run(schedule, Options::default());
        let violation = outcome.ok().and_then(|outcome| outcome.violation);
        violation.is_some_and(|violation| violation.invariant == invariant)
    };
    let minimised = minimise(schedule, TRIES, fails);
    let last = run::run(&minimised.schedule, Options::default())?;
    Ok(last.violation.map(|violation| (minimised, violation)))
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
