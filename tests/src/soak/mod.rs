//! Soak with real processes: one large system that is changed all the time, and must not grow.
//!
//! Acts follow from a seed ([`act`]). Every few seconds the system is brought back to what it was ([`system`]), and what
//! each process that has lived through it all holds is measured ([`held`]).

mod act;
mod held;
mod system;

use std::time::{Duration, Instant};

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::Stack;
use act::Act;
use held::Growth;
use system::System;

/// Between two acts.
const PAUSE: Duration = Duration::from_millis(20);
/// The first part of the time, in which pools and caches are filled.
const WARM_UP: f64 = 0.4;
/// Most that passes between two measurements.
const STRETCH: Duration = Duration::from_secs(60);
/// What is not needed any more is let go within this time.
const IDLE: Duration = Duration::from_secs(15);

/// What is to be done.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// How long it is changed.
    pub time: Duration,
    /// Everything that is done follows from it.
    pub seed: u64,
    /// Number of components; there are twice as many connectors.
    pub components: usize,
    /// The test of the soak itself: holds on to descriptors of a manager, which must be noticed.
    pub leak: bool,
}

/// Runs it. The error names every process that has grown, or what went wrong.
pub fn run(options: &Options) -> Result<String, String> {
    let stack = Stack::new();
    let mut draw = ChaCha8Rng::seed_from_u64(options.seed);
    let base = System::draw(options.components, &mut draw);
    let mut soak = Soak {
        stack: &stack,
        now: base.clone(),
        base,
        draw,
        counts: act::Counts::default(),
    };
    soak.settle()?;
    let mut growth = Growth::of(held::all(&stack));
    let begun = Instant::now();
    let measured_from = options.time.mul_f64(WARM_UP);
    soak.act_until(begun + measured_from)?;
    soak.calm_down()?;
    growth.set_first(held::all(&stack));
    let leak = options.leak.then(|| held::leak_into(&stack));
    while begun.elapsed() < options.time {
        let end = (begun.elapsed() + STRETCH).min(options.time);
        soak.act_until(begun + end)?;
        soak.measure(&mut growth)?;
    }
    drop(leak);
    let report = format!("{}\n{}", soak.counts, growth.table());
    let grown = growth.grown();
    stack.leaves_nothing();
    match grown.is_empty() {
        true => Ok(report),
        false => Err(format!("{report}\nGREW: {}", grown.join("; "))),
    }
}

/// A soak that runs.
struct Soak<'a> {
    stack: &'a Stack,
    base: System,
    now: System,
    draw: ChaCha8Rng,
    counts: act::Counts,
}

impl Soak<'_> {
    /// Changes things until that time.
    fn act_until(&mut self, end: Instant) -> Result<(), String> {
        while Instant::now() < end {
            let act = Act::draw(&mut self.draw);
            self.counts.count(act);
            self.carry_out(act)?;
            std::thread::sleep(PAUSE);
        }
        Ok(())
    }

    /// Brings all back to the first system, and waits until it runs.
    fn calm_down(&mut self) -> Result<(), String> {
        self.now = self.base.clone();
        self.settle()
    }

    /// Looks at what is held when it is calm. Threads of pools may still be about to end.
    fn measure(&mut self, growth: &mut Growth) -> Result<(), String> {
        self.calm_down()?;
        let deadline = Instant::now() + IDLE;
        loop {
            growth.set_last(held::all(self.stack));
            if growth.grown().is_empty() || Instant::now() > deadline {
                return Ok(());
            }
            std::thread::sleep(Duration::from_millis(200));
        }
    }

    /// Applies what is wished for now, until all of it runs and samples go over every connector.
    fn settle(&self) -> Result<(), String> {
        let file = self.stack.write("soak.xml", self.now.xml());
        let file = file.to_string_lossy();
        let deadline = Instant::now() + Duration::from_secs(120);
        loop {
            let said = self.stack.rtsctl(&["apply", &file, "--timeout", "60s"]);
            match said.code {
                0 if self.flows() => return Ok(()),
                // A process that was killed a moment ago may still be on its way back.
                0 | 5 if Instant::now() < deadline => {
                    std::thread::sleep(Duration::from_millis(100));
                }
                _ => return Err(format!("the system does not settle: {said:#?}")),
            }
        }
    }

    /// True when every connector carries samples.
    fn flows(&self) -> bool {
        let all = self.stack.get("connectors");
        let carries = |c: &serde_json::Value| {
            c["status"]["state"] == "Connected" && c["status"]["samplesReceived"].as_u64() > Some(0)
        };
        all.len() == self.now.connectors() && all.iter().all(carries)
    }

    fn below(&mut self, end: usize) -> usize {
        self.draw.random_range(0..end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_held_on_to_is_noticed() {
        let options = Options {
            time: Duration::from_secs(2),
            seed: 1,
            components: 10,
            leak: true,
        };
        let said = run(&options).unwrap_err();
        assert!(
            said.contains("GREW: ") && said.contains("descriptors"),
            "{said}"
        );
    }
}
