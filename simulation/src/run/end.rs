//! The end of a run: everything becomes quiet, and what users want comes to be; then all is taken down, and nothing is
//! left.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::{Instant, sleep};

use super::look::{self, Wrongs};
use super::stage::Stage;
use super::user::Users;

use crate::check::Violation;

/// What users want is there after so long a quiet. The longest way there is that of a batch whose results stopped coming
/// over a connection that was cut: 60 s to spare, 25 s for each step that still waits, 5 s of grace; after that a target
/// that failed again and again waits for its back-off, 60 s and 20 % of it, and its steps take their time, 25 s. With a
/// chain of four such steps: 60 + 4 × 25 + 5 + 72 + 25.
pub const BOUND: Duration = Duration::from_secs(270);
/// A system that stays as it is by its policies is taken down and applied again by its user, not before so long.
const PATIENCE: Duration = Duration::from_secs(15);
/// Times that a user does so.
const REMEDIES: u32 = 4;
/// What was lost before the quiet is missed so long after it: until then a node may still be found to be silent.
const AFTERMATH: Duration = Duration::from_secs(10);
/// How long everything must stay as it is.
const STAYS: Duration = Duration::from_secs(8);
/// How often it is looked.
const LOOK: Duration = Duration::from_millis(250);
/// Calls of rtsctl for one thing, now that nothing goes wrong.
const CALLS: u32 = 240;

/// What did not come to be.
const CONVERGENCE: &str = "convergence";
/// What was left.
const NOTHING_LEFT: &str = "nothing-left";

/// Waits until what users want is there, and then until nothing is left. The violation where that does not come to be.
pub(super) async fn end(world: &Arc<Stage>, users: &Users, again: bool) -> Result<(), Violation> {
    let quiet = Instant::now();
    users.insist();
    for (system, wish) in users.wishes() {
        if wish.is_said() && !again {
            continue;
        }
        let done = match wish.wanted {
            true => users.apply(&system, CALLS).await,
            false => users.delete(&system, CALLS).await,
        };
        if !done {
            return Err(violation(
                world,
                CONVERGENCE,
                &system,
                "no answer to its user".to_owned(),
            ));
        }
    }
    world.note("all wishes are acknowledged");
    loop {
        come_to_be(world, users, again).await?;
        world.note("everything is as desired");
        whole(world)?;
        world.desired.converged();
        match stay(world, users).await {
            Ok(()) => break,
            Err(_) if quiet.elapsed() < AFTERMATH => {}
            Err(violation) => return Err(violation),
        }
    }
    world.note("everything is taken down");
    take_down(world, users).await
}

/// What is shown node by node is what is shown as a whole.
fn whole(world: &Arc<Stage>) -> Result<(), Violation> {
    match world.hosts.controller().map(|core| core.publish_anew()) {
        None | Some(0) => Ok(()),
        Some(count) => {
            let what = format!("{count} objects change when all are shown anew");
            Err(violation(world, "shown-as-it-is", "the controller", what))
        }
    }
}

async fn come_to_be(world: &Arc<Stage>, users: &Users, restored: bool) -> Result<(), Violation> {
    let mut began = Instant::now();
    let mut last = began;
    let mut remedies = 0;
    loop {
        let wrongs = look::wrongs(world, &users.wishes());
        if wrongs.is_empty() {
            return Ok(());
        }
        let now = Instant::now();
        if now.duration_since(last) >= PATIENCE && remedies < REMEDIES {
            last = now;
            if restored && let Some(system) = resurrected(users, &wrongs) {
                world.note(format!(
                    "user: {system} is taken down once more: a restored store took it in"
                ));
                world
                    .coverage
                    .count("systems that came back after a restore");
                remedies += 1;
                users.delete(&system, CALLS).await;
            } else if let Some((system, why)) = excused(world, users, &wrongs) {
                world.note(format!(
                    "user: {system} is taken down and applied again: {why}"
                ));
                world.coverage.count("systems that a user had to mend");
                remedies += 1;
                let done = users.delete(&system, CALLS).await && users.apply(&system, CALLS).await;
                if !done {
                    let what = "no answer to its user".to_owned();
                    return Err(violation(world, CONVERGENCE, &system, what));
                }
                began = Instant::now();
                last = began;
            }
        }
        if now.duration_since(began) > BOUND {
            return Err(broken(world, CONVERGENCE, wrongs));
        }
        sleep(LOOK).await;
    }
}

/// A system that was taken down before all nodes had told a restored store that they run it.
fn resurrected(users: &Users, wrongs: &Wrongs) -> Option<String> {
    let wishes = users.wishes();
    let gone = |system: &&String| wishes.get(*system).is_some_and(|wish| !wish.wanted);
    wrongs.keys().find(gone).cloned()
}

fn excused(world: &Stage, users: &Users, wrongs: &Wrongs) -> Option<(String, String)> {
    let wishes = users.wishes();
    wrongs.keys().find_map(|system| {
        let wish = wishes.get(system).filter(|wish| wish.wanted)?;
        Some((system.clone(), look::excuse(world, wish)?))
    })
}

/// What is as desired stays so.
async fn stay(world: &Arc<Stage>, users: &Users) -> Result<(), Violation> {
    let until = Instant::now() + STAYS;
    while Instant::now() < until {
        let wrongs = look::wrongs(world, &users.wishes());
        if !wrongs.is_empty() {
            return Err(broken(world, CONVERGENCE, wrongs));
        }
        sleep(LOOK * 4).await;
    }
    Ok(())
}

async fn take_down(world: &Arc<Stage>, users: &Users) -> Result<(), Violation> {
    for (system, wish) in users.wishes() {
        if wish.wanted && !users.delete(&system, CALLS).await {
            let what = "no answer to its user".to_owned();
            return Err(violation(world, NOTHING_LEFT, &system, what));
        }
    }
    let began = Instant::now();
    loop {
        let left = left(world, users);
        if left.is_empty() {
            return Ok(());
        }
        if began.elapsed() > BOUND {
            return Err(violation(world, NOTHING_LEFT, "the end", left.join("; ")));
        }
        sleep(LOOK).await;
    }
}

/// What is left on machines, in the store, in ledgers.
fn left(world: &Stage, users: &Users) -> Vec<String> {
    let mut left = Vec::new();
    for (system, words) in look::wrongs(world, &users.wishes()) {
        left.extend(words.iter().map(|word| format!("{system}: {word}")));
    }
    for (name, node) in &world.nodes {
        let over = node.machine.left_over();
        if !over.is_empty() {
            left.push(format!("on {name}: {over:?}"));
        }
        let text = world.ledger_text(name).unwrap_or_default();
        let ledger: serde_json::Value = serde_json::from_slice(&text).unwrap_or_default();
        let systems = &ledger["spec"]["systems"];
        if systems
            .as_array()
            .is_some_and(|systems| !systems.is_empty())
        {
            left.push(format!("in the ledger of {name}: {systems}"));
        }
    }
    let store = world.store().state();
    let systems: Vec<&String> = store.systems.keys().collect();
    if !systems.is_empty() {
        left.push(format!("in the store: {systems:?}"));
    }
    if world.ground.processes() > 0 {
        left.push(format!("{} processes live", world.ground.processes()));
    }
    left
}

fn broken(world: &Stage, invariant: &'static str, wrongs: Wrongs) -> Violation {
    let words = |(system, words): (String, Vec<String>)| format!("{system}: {}", words.join("; "));
    let all: Vec<String> = wrongs.into_iter().map(words).collect();
    violation(world, invariant, "what users want", all.join(" | "))
}

fn violation(world: &Stage, invariant: &'static str, subject: &str, what: String) -> Violation {
    Violation {
        at: world.truth.now(),
        invariant,
        subject: subject.to_owned(),
        what,
    }
}
