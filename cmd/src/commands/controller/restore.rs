//! `rtsctl controller restore`.

use std::path::{Path, PathBuf};

use rts_controller_api::objects::{Kind, Node};

use super::confirm;
use crate::error::CliError;
use crate::exit::Exit;
use crate::local::lock::{HomeLock, make_folders};
use crate::local::nodes::Nodes;
use crate::local::restore::{Mode, Report, call, stop_controller};
use crate::local::{LOCAL_NODE, LocalError, plural, up};
use crate::session::Session;

/// Put a backup in the place of the local controller's store
///
/// The controller is stopped and started again; agents, managers and components run on. The old store is kept beside the
/// new one. Where a node was told newer things than the backup knows, those are taken in: what was applied since comes back,
/// and what was torn down since goes. Works also when the controller is dead, or its store damaged or gone.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// File that `rtsctl controller backup` wrote
    file: PathBuf,
    /// The backup wins: nodes are brought to what it says, also where they were told newer things
    #[arg(long)]
    take_over: bool,
    /// Do not ask
    #[arg(short, long)]
    yes: bool,
}

/// Checks the file first, then asks, stops, restores, and starts again.
pub async fn run(args: &Args, session: &Session) -> Result<Exit, CliError> {
    if let Some(socket) = &session.controller {
        return Err(CliError::usage_help(
            format!("the controller is {}, not a local one", socket.display()),
            "leave out --controller and unset RTSCTL_CONTROLLER to restore the local one",
        ));
    }
    let home = &session.home;
    home.check_length(LOCAL_NODE)?;
    let file = std::path::absolute(&args.file).map_err(LocalError::file("find", &args.file))?;
    let checked = call(home, &file, Mode::Check).await?;
    let held = checked.map_err(|reason| refused(&file, &reason))?;
    let what = words(&held);
    confirm(
        args.yes,
        &format!("Put the backup ({what}) in the place of the store?"),
        &format!("the store would be replaced by the backup ({what})"),
    )?;
    let done = {
        let _lock = HomeLock::take(home)?;
        make_folders(home, Nodes::of(home)?.first())?;
        if stop_controller(home)? {
            session.out.say("rtsctl: stopped the controller");
        }
        let mode = if args.take_over {
            Mode::TakeOver
        } else {
            Mode::Restore
        };
        call(home, &file, mode).await?
    };
    // Whatever came of it, a controller runs again.
    let started = up::ensure(session, up::Wish::default()).await;
    let done = done.map_err(|reason| LocalError::File {
        what: "restore",
        path: args.file.clone(),
        source: std::io::Error::other(reason),
    })?;
    if let Some(kept) = &done.kept {
        let text = format!("rtsctl: the old store is kept as {}", kept.display());
        session.out.say(&text);
    }
    let text = format!(
        "restored {}: {what}, epoch {}",
        args.file.display(),
        done.epoch
    );
    session.out.result(&text)?;
    match started {
        Err(_) if disagrees(session).await => Ok(Exit::Ok),
        started => started.map(|_| Exit::Ok),
    }
}

/// What the controller's program says of a file; the file is named once.
fn refused(file: &Path, reason: &str) -> CliError {
    let file = file.display().to_string();
    let why = reason.strip_prefix("the backup cannot be restored: ");
    CliError::Backup(if reason.contains(&file) {
        reason.to_owned()
    } else {
        format!("cannot restore {file}: {}", why.unwrap_or(reason))
    })
}

/// True when the controller runs, and a node only waits for a word of the user; that is said.
async fn disagrees(session: &Session) -> bool {
    let Ok(controller) = session.connect().await else {
        return false;
    };
    let nodes = controller.list::<Node>(Kind::Node).await;
    let nodes = nodes.map(|list| list.items).unwrap_or_default();
    let waits = nodes.iter().filter(|node| node.status.ledger.is_some());
    let messages = waits.filter_map(|node| node.status.message.as_deref());
    let said = messages.map(|message| session.out.warn(message)).count();
    said > 0
}

/// `2 systems of 2026-01-01T00:00:00Z: hello, second`.
fn words(report: &Report) -> String {
    let count = plural("system", report.systems.len());
    let names = match report.systems.as_slice() {
        [] => String::new(),
        names => format!(": {}", names.join(", ")),
    };
    format!("{count} of {:.0}{names}", report.created)
}
