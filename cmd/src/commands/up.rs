//! `rtsctl up`.

use std::ffi::OsString;

use crate::error::CliError;
use crate::exit::Exit;
use crate::local::up::{Started, ensure};
use crate::session::Session;

/// Start the local controller and agent
///
/// They live in one folder, the home (`--home`, RTSCTL_HOME, else $XDG_STATE_HOME/rtsctl), and go on until `rtsctl down`.
/// What already runs is left alone.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folders in which the agent searches modules, separated by colons [env: RTSCTL_MODULE_PATH] [default: that of the
    /// programs]
    #[arg(long, value_name = "DIRS", env = "RTSCTL_MODULE_PATH", hide_env = true)]
    module_path: Option<OsString>,
}

/// Starts what does not run and says where it is.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    if let Some(socket) = &session.controller {
        return Err(CliError::usage_help(
            format!("the controller is {}, not a local one", socket.display()),
            "leave out --controller and unset RTSCTL_CONTROLLER to start a local one",
        ));
    }
    let started = ensure(session, args.module_path).await?;
    let home = session.home.path().display();
    session.out.result(&match started {
        Started::Nothing => format!("already running in {home}"),
        _ => format!("running in {home}"),
    })?;
    Ok(Exit::Ok)
}
