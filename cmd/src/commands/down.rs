//! `rtsctl down`.

use std::collections::BTreeSet;

use crate::commands::{ask, can_ask};
use crate::error::CliError;
use crate::exit::Exit;
use crate::local::lock::HomeLock;
use crate::local::{LocalError, down, plural, relays, remove};
use crate::session::Session;

/// Stop the local stack: controller, agent, and every manager process
///
/// What runs on nodes that are reached by SSH is not stopped: `rtsctl teardown` does. While systems run there, it needs
/// `--yes` to end all else, and does not purge.
///
/// Works also when the controller and the agent are dead. Asks before it stops systems that run; where nobody can be
/// asked, `--yes` is needed.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Remove state and logs too
    #[arg(long)]
    purge: bool,
    /// Do not ask
    #[arg(short, long)]
    yes: bool,
}

/// Stops everything, removes the run folder, and says what was stopped.
pub async fn run(args: &Args, session: &Session) -> Result<Exit, CliError> {
    let home = &session.home;
    let far = relays::systems(session).await;
    if !far.is_empty() && (args.purge || !args.yes) {
        return Err(LocalError::SystemsRun { systems: far }.into());
    }
    // Asked without the lock, so that nobody waits for a person; then looked at again.
    let asked = confirm(args, down::systems(home)?)?;
    let lock = HomeLock::take_existing(home)?;
    let news: Vec<_> = down::systems(home)?.difference(&asked).cloned().collect();
    if !args.yes && !news.is_empty() {
        return Err(LocalError::SystemsRun { systems: news }.into());
    }
    let stopped = down::stop(home)?;
    if let Some(force) = stopped.force() {
        session.out.say(&format!("rtsctl: {force}"));
    }
    if !stopped.left.is_empty() {
        session.out.say(&format!("rtsctl: {}", stopped.words()));
        return Err(LocalError::Left { left: stopped.left }.into());
    }
    if lock.is_none() {
        let text = format!("{}: there is no {}", stopped.words(), home.path().display());
        session.out.result(&text)?;
        return Ok(Exit::Ok);
    }
    let alone = remove::remove(home, args.purge)?;
    session.out.result(&stopped.words())?;
    if !far.is_empty() {
        let text = format!(
            "rtsctl: left running, `rtsctl up` and `rtsctl teardown` end it: {}",
            far.join(", ")
        );
        session.out.say(&text);
    }
    for path in alone {
        let text = format!(
            "left alone, as it holds what is not of rtsctl: {}",
            path.display()
        );
        session.out.say(&format!("rtsctl: {text}"));
    }
    Ok(Exit::Ok)
}

/// The systems that may be stopped.
fn confirm(args: &Args, systems: BTreeSet<String>) -> Result<BTreeSet<String>, CliError> {
    if args.yes || systems.is_empty() {
        return Ok(systems);
    }
    let names: Vec<_> = systems.iter().cloned().collect();
    if !can_ask() {
        return Err(LocalError::SystemsRun { systems: names }.into());
    }
    let (count, names) = (plural("system", names.len()), names.join(", "));
    if ask(&format!("{count} still running: {names}. Stop everything?")) {
        Ok(systems)
    } else {
        Err(LocalError::Declined.into())
    }
}
