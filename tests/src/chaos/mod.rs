//! Chaos with real processes: random faults during random applies, changes and teardowns of real systems.
//!
//! Rounds follow from a seed ([`script`]). In each, a user acts and things go wrong ([`faults`]) at the same time; then
//! it is quiet, and all must heal ([`quiet`]). All the while a [`watcher`] looks from outside: at `/proc`, and at what
//! managers say on their own sockets. Whoever acts says first what may change by it ([`excuses`]); whatever else
//! changes is a violation.

mod disk;
mod draw;
mod excuses;
mod faults;
mod journal;
mod judge;
mod known;
mod left;
mod logs;
mod quiet;
mod sabotage;
mod script;
mod stage;
mod table;
mod watcher;
mod wish;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::time::{Duration, Instant};

use faults::Later;
use jiff::Timestamp;
use script::{Act, Fault, Round, Script};
use stage::{Stage, Stop};
use wish::Wish;

pub use disk::{INSIDE, may_mount};
pub use sabotage::Sabotage;

/// Between two lines of progress.
const PROGRESS: Duration = Duration::from_secs(3);

/// What is to be done.
#[derive(Debug, Clone)]
pub struct Options {
    /// No round begins after this time.
    pub time: Duration,
    /// Everything that is done follows from it; how long things take does not.
    pub seed: u64,
    /// Break an invariant after the second round.
    pub sabotage: Option<Sabotage>,
    /// Where the number of a signal is found that came.
    pub signal: Arc<AtomicUsize>,
}

/// Runs it. Gives the exit code: 0, 1 after a violation, or 128 and the number of the signal that came.
pub fn run(options: &Options) -> u8 {
    let disk = may_mount();
    let mut stage = Stage::new(Arc::clone(&options.signal), disk);
    let seed = options.seed;
    let home = stage.stack.home();
    println!("chaos: seed {seed}, home {}", home.display());
    if !stage.disk.is_there() {
        println!("chaos: full disks are skipped: they need the right to mount (unshare -m)");
    }
    let mut script = Script::new(seed, stage.disk.is_there());
    let mut round = 0;
    let outcome = rounds(&mut stage, options, &mut script, &mut round);
    let outcome = outcome.and_then(|()| stage.farewell(&mut script));
    let code = match outcome {
        Ok(()) => {
            println!("{}", stage.journal.table(0));
            return 0;
        }
        Err(Stop::Signal(signal)) => {
            println!("chaos: signal {signal}: ends");
            return u8::try_from(128 + signal).unwrap_or(u8::MAX);
        }
        Err(Stop::Violated(violations)) => {
            println!("{}", stage.journal.table(violations.len()));
            println!("VIOLATED in round {round} of seed {seed}:");
            violations.iter().for_each(|text| println!("  {text}"));
            println!(
                "what was done (seconds since the begin):\n{}",
                stage.journal.last_lines()
            );
            1
        }
    };
    let kept = stage.keep();
    println!("kept with its logs: {}", kept.display());
    println!(
        "again: `cargo xtask chaos --seed {seed}`; the same is done, but time makes it only similar"
    );
    code
}

fn rounds(
    stage: &mut Stage,
    options: &Options,
    script: &mut Script,
    number: &mut u64,
) -> Result<(), Stop> {
    let mut said = Instant::now();
    while stage.journal.elapsed() < options.time {
        let round = script.next();
        *number = round.number;
        stage.play(&round)?;
        if said.elapsed() > PROGRESS {
            said = Instant::now();
            println!("chaos: {}", stage.journal.progress());
        }
        if let Some(sabotage) = options.sabotage.filter(|_| round.number == 2) {
            stage.sabotage(sabotage)?;
        }
    }
    Ok(())
}

/// What happens at a moment of a round.
#[derive(Debug)]
enum Event {
    Act(Act),
    Fault(Fault),
    Later(Later),
}

impl Stage {
    /// One round, and the quiet after it.
    fn play(&mut self, round: &Round) -> Result<(), Stop> {
        let (begin, since) = (Instant::now(), Timestamp::now());
        self.journal.note(&format!("round {}", round.number));
        self.faulty = !round.faults.is_empty();
        let before = self.stored.clone();
        let acts = round
            .acts
            .iter()
            .map(|(at, act)| (*at, Event::Act(act.clone())));
        let faults = round
            .faults
            .iter()
            .map(|(at, fault)| (*at, Event::Fault(fault.clone())));
        let mut events: Vec<_> = acts.chain(faults).collect();
        loop {
            events.sort_by_key(|(at, _)| *at);
            let now = begin.elapsed();
            if events.first().is_some_and(|(at, _)| *at <= now) {
                match events.remove(0).1 {
                    Event::Act(act) => self.begin(&act),
                    Event::Later(later) => self.later(&later),
                    Event::Fault(fault) => {
                        let later = self.fault(&fault);
                        events.extend(later.map(|(time, what)| (now + time, Event::Later(what))));
                    }
                }
                continue;
            }
            self.reap()?;
            if events.is_empty() && self.running.is_empty() {
                break;
            }
            self.sleep(Duration::from_millis(3))?;
        }
        self.quiet(round)?;
        self.look_at_logs(&before, round, since)?;
        self.nothing_is_left_of_the_gone()?;
        self.watcher.forgive_no_more();
        self.go_on()
    }

    /// No panic; and the orders that all wishes of the round have in common were kept.
    fn look_at_logs(
        &mut self,
        before: &std::collections::BTreeMap<String, Vec<Option<Wish>>>,
        round: &Round,
        since: Timestamp,
    ) -> Result<(), Stop> {
        let mut found = self.logs.read();
        let deaths = self.excuses.now().deaths;
        for (name, wish) in &round.wished {
            let acts = round.acts.iter().filter_map(|(_, act)| match act {
                Act::Apply(wish, _) if wish.name == *name => Some(wish),
                _ => None,
            });
            let old = before.get(name).into_iter().flatten().flatten();
            let mut pairs = wish.order();
            for other in acts.chain(old) {
                let order = other.order();
                pairs.retain(|pair| order.contains(pair));
            }
            let own = |(first, then): &(&str, &str)| ((*first).to_owned(), (*then).to_owned());
            let pairs: Vec<_> = pairs.iter().map(own).collect();
            found.extend(self.logs.out_of_order(&pairs, since, &deaths));
        }
        match found.is_empty() {
            true => Ok(()),
            false => Err(Stop::Violated(found)),
        }
    }

    /// Takes down what there is; then nothing may be left.
    fn farewell(&mut self, script: &mut Script) -> Result<(), Stop> {
        let round = script.last();
        self.play(&round)?;
        self.nothing_is_left()
    }

    /// Ends everything but the files.
    fn keep(mut self) -> PathBuf {
        self.end_everything();
        let folder = self.stack.home();
        let beside = folder.with_file_name("state");
        self.disk.keep(&beside);
        self.disk.unmount();
        let _ = self.journal.save(&folder.with_file_name("chaos.log"));
        // Its drop would remove the files.
        std::mem::forget(self);
        folder
    }
}
