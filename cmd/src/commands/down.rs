//! `rtsctl down`.

use std::collections::BTreeSet;

use crate::commands::{ask, can_ask};
use crate::error::CliError;
use crate::exit::Exit;
use crate::local::lock::HomeLock;
use crate::local::{LocalError, down, plural, remove};
use crate::session::Session;

/// Stop the local stack: controller, agent, and every manager process
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
pub fn run(args: &Args, session: &Session) -> Result<Exit, CliError> {
    let home = &session.home;
    let Some(_lock) = HomeLock::take_existing(home)? else {
        let text = format!("nothing was running: there is no {}", home.path().display());
        session.out.result(&text)?;
        return Ok(Exit::Ok);
    };
    confirm(args, session)?;
    let stopped = down::stop(home)?;
    if !stopped.left.is_empty() {
        session.out.say(&format!("rtsctl: {}", stopped.words()));
        return Err(LocalError::Left { left: stopped.left }.into());
    }
    let alone = remove::remove(home, args.purge)?;
    session.out.result(&stopped.words())?;
    for path in alone {
        let text = format!(
            "left alone, as it holds what is not of rtsctl: {}",
            path.display()
        );
        session.out.say(&format!("rtsctl: {text}"));
    }
    Ok(Exit::Ok)
}

fn confirm(args: &Args, session: &Session) -> Result<(), CliError> {
    let managers = down::live_managers(&session.home)?;
    let systems: BTreeSet<_> = managers.iter().filter_map(|m| m.system()).collect();
    if args.yes || systems.is_empty() {
        return Ok(());
    }
    let systems: Vec<_> = systems.into_iter().map(str::to_owned).collect();
    if !can_ask() {
        return Err(LocalError::SystemsRun { systems }.into());
    }
    let (count, names) = (plural("system", systems.len()), systems.join(", "));
    if ask(&format!("{count} still running: {names}. Stop everything?")) {
        Ok(())
    } else {
        Err(LocalError::Declined.into())
    }
}
