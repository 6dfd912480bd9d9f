//! How a machine is reached by SSH, and what it is called.

use std::path::PathBuf;

use rts_ssh::{Destination, HostKeys, Survey};

use crate::error::CliError;
use crate::local::LocalError;
use crate::local::home::Home;

/// The machine. What is not said is as the user's ssh settings have it.
#[derive(Debug, Clone, clap::Args)]
pub struct ReachArgs {
    /// Account and machine; the machine may be a name in your ssh settings
    #[arg(value_name = "[USER@]HOST[:PORT]")]
    pub destination: Destination,
    /// TCP port of the SSH server
    #[arg(long, value_name = "PORT", value_parser = clap::value_parser!(u16).range(1..))]
    port: Option<u16>,
    /// Private key to log in with; no other one is offered then
    #[arg(long, value_name = "FILE")]
    identity: Option<PathBuf>,
    /// Take a host key that is not known, and remember it; one that has changed is refused all the same
    #[arg(long)]
    accept_new: bool,
    /// Settings to read instead of ~/.ssh/config
    #[arg(long, value_name = "FILE")]
    ssh_config: Option<PathBuf>,
}

impl ReachArgs {
    /// Whom to reach, and how.
    pub fn settle(self) -> Result<Destination, CliError> {
        let mut destination = self.destination;
        if let (Some(before), Some(port)) = (destination.port, self.port)
            && before != port
        {
            return Err(CliError::usage(format!(
                "the port is said to be {before} and {port}"
            )));
        }
        destination.port = self.port.or(destination.port);
        destination.identity = self.identity;
        destination.config = self.ssh_config;
        if self.accept_new {
            destination.host_keys = HostKeys::AcceptNew;
        }
        Ok(destination)
    }
}

/// Where the socket of a session lies: in the run folder of the home, if it is that of a stack of this machine. What is there of an agent
/// alone may be what is to be removed, by a session with this very machine.
pub fn control_folder(home: &Home) -> PathBuf {
    match home.controller_lock().exists() {
        true => home.run(),
        false => std::env::temp_dir(),
    }
}

/// The name of the node: what the user said, else the name that the machine has for itself.
pub fn node_name(said: Option<String>, survey: &Survey) -> Result<String, CliError> {
    let own = || survey.node.split('.').next().unwrap_or_default().to_owned();
    let name = said.unwrap_or_else(own);
    if !rts_agent::is_node_name(&name) {
        return Err(CliError::usage_help(
            format!("{name:?} is no name of a node"),
            "name it with --name: 1 to 63 of a-z, A-Z, 0-9, '-', '_' and '.', not starting with '.'",
        ));
    }
    let home = Home::settle(Some(survey.rtsctl_home().into()))?;
    match home.check_length(&name) {
        Err(LocalError::HomeTooLong { home, bytes, limit }) => Err(CliError::usage_help(
            format!(
                "{} on that machine is too long: a Unix socket in it would have a path of {bytes} bytes, and {limit} is the limit",
                home.display()
            ),
            "set XDG_STATE_HOME of that account to a shorter folder, or choose a shorter --name",
        )),
        other => other.map(|()| name).map_err(CliError::from),
    }
}
