//! One run of a schedule: the real programs in a simulated world, watched by every invariant.

mod coverage;
mod end;
mod ground;
mod log;
mod look;
mod stage;
mod trouble;
mod user;
mod wish;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use tokio::time::{Instant, sleep, sleep_until, timeout};

use self::stage::Stage;
use self::user::Users;
use self::wish::Wish;
use crate::check::Violation;
use crate::event_loop::event_loop;
use crate::faults::Fault;
use crate::schedule::Schedule;
use crate::seed::Seed;
use crate::trace::Trace;
use crate::words::CONTROLLER;
use crate::world::programs;

pub use self::coverage::Coverage;
pub use self::end::BOUND;

/// No run takes longer, in simulated time.
const LONGEST: Duration = Duration::from_secs(3 * 3600);
/// No run tells more.
const MOST: u64 = 400_000;
/// How often it is looked whether everything is as desired.
const LOOK: Duration = Duration::from_millis(500);

/// What is wanted of a run besides its verdict.
#[derive(Debug, Clone, Copy, Default)]
pub struct Options {
    /// Keep the text of all that happened.
    pub trace: bool,
    /// With what the programs log.
    pub log: bool,
}

/// What came of a run.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The first invariant that did not hold.
    pub violation: Option<Violation>,
    /// What it came by.
    pub coverage: BTreeMap<String, u64>,
    /// Simulated time.
    pub time: Duration,
    /// Number of things that happened.
    pub happened: u64,
    /// Names all that happened.
    pub hash: u64,
    /// All that happened, where it was kept.
    pub text: Vec<String>,
}

/// Runs a schedule in this thread.
pub fn run(schedule: &Schedule, options: Options) -> std::io::Result<Outcome> {
    let runtime = event_loop(Seed(schedule.seed))?;
    Ok(runtime.block_on(async {
        let trace = if options.trace {
            Trace::kept()
        } else {
            Trace::default()
        };
        let _log = options.log.then(|| log::begin(&trace));
        play(schedule, trace).await
    }))
}

async fn play(schedule: &Schedule, trace: Trace) -> Outcome {
    let world = Stage::new(Seed(schedule.seed), schedule.nodes, trace.clone());
    let violation = tokio::select! {
        biased;
        violation = world.verdicts.broken() => Some(violation),
        violation = timeout(LONGEST, course(&world, schedule)) => match violation {
            Ok(violation) => violation,
            Err(_) => Some(endless(&world, "it does not end")),
        },
        () = flood(&world) => Some(endless(&world, "too much happens")),
    };
    let counts = world.net.counts();
    world.coverage.add("messages", counts.sent);
    world.coverage.add("messages lost", counts.lost);
    world.coverage.add("messages doubled", counts.doubled);
    world
        .coverage
        .add("writes of the store that failed", world.store().counts().1);
    world.hosts.close();
    Outcome {
        violation,
        coverage: world.coverage.counts(),
        time: world.truth.now(),
        happened: trace.lines(),
        hash: trace.hash(),
        text: trace.text(),
    }
}

/// From the first start to the end.
async fn course(world: &Arc<Stage>, schedule: &Schedule) -> Option<Violation> {
    let quiet = Instant::now() + schedule.quiet;
    programs::start_all(&world.world);
    for fault in &schedule.faults {
        tokio::spawn(trouble::happen(Arc::clone(world), fault.clone(), quiet));
    }
    let users = Arc::new(Users::new(world, schedule));
    let (them, deeds) = (Arc::clone(&users), schedule.deeds.clone());
    let follows = tokio::spawn(async move { them.follow(&deeds).await });
    tokio::select! {
        biased;
        () = sleep_until(quiet) => {}
        () = notice(world, &users) => {}
    }
    // What ends with the quiet has ended.
    sleep(Duration::from_millis(1)).await;
    world.note("everything is quiet");
    for host in world.nodes.keys() {
        world.lives().let_start(host);
    }
    world.lives().let_start(CONTROLLER);
    // Nobody waits for ever.
    let _ = follows.await;
    let restored = schedule
        .faults
        .iter()
        .any(|f| f.fault.fault == Fault::Usurper);
    end::end(world, &users, restored).await.err()
}

/// Tells whenever everything is as desired: from then on nothing of before counts.
async fn notice(world: &Stage, users: &Users) {
    loop {
        sleep(LOOK).await;
        let wishes = users.wishes();
        let settled = !users.are_busy() && wishes.values().all(Wish::is_said);
        if settled && look::wrongs(world, &wishes).is_empty() {
            world.desired.converged();
        }
    }
}

async fn flood(world: &Stage) {
    while world.trace.lines() < MOST {
        sleep(Duration::from_secs(1)).await;
    }
}

fn endless(world: &Stage, what: &str) -> Violation {
    Violation {
        at: world.truth.now(),
        invariant: "an-end",
        subject: "the run".to_owned(),
        what: format!("{what}: {} things happened", world.trace.lines()),
    }
}
