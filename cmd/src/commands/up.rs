//! `rtsctl up`.

use std::ffi::OsString;

use crate::error::CliError;
use crate::exit::Exit;
use crate::local::nodes::NodeSetup;
use crate::local::up::{Wish, ensure};
use crate::session::Session;

/// Start the local controller and the agents of its nodes
///
/// They live in one folder, the home (`--home`, RTSCTL_HOME, else $XDG_STATE_HOME/rtsctl), and go on until `rtsctl down`.
/// What already runs is left alone. A home has one node, `local`, unless `--node` names others; it keeps those that it
/// was told of until `rtsctl down --purge`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folders in which the agent searches modules, separated by colons [env: RTSCTL_MODULE_PATH] [default: that of the
    /// programs]
    #[arg(long, value_name = "DIRS", env = "RTSCTL_MODULE_PATH", hide_env = true)]
    module_path: Option<OsString>,
    /// A node that the home is to have, with the hosts of profiles that mean it; may be repeated. The first one takes what
    /// no host means
    #[arg(long = "node", value_name = "NAME[=HOST,...]")]
    nodes: Vec<NodeSetup>,
}

/// Starts what does not run and says where it is.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    if let Some(socket) = &session.controller {
        return Err(CliError::usage_help(
            format!("the controller is {}, not a local one", socket.display()),
            "leave out --controller and unset RTSCTL_CONTROLLER to start a local one",
        ));
    }
    let wish = Wish {
        module_path: args.module_path,
        nodes: args.nodes,
    };
    let started = ensure(session, wish).await?;
    let home = session.home.path().display();
    session.out.result(&match started.nothing() {
        true => format!("already running in {home}"),
        false => format!("running in {home}"),
    })?;
    Ok(Exit::Ok)
}
