//! What a verb works with: the home, the controller's socket, and the output.

use std::path::PathBuf;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use rts_controller_api::client::Controller;
use rts_http::client::Client;

use crate::cli::Globals;
use crate::error::CliError;
use crate::local::home::Home;
use crate::local::lock::is_held;
use crate::local::nodes::Nodes;
use crate::local::{LOCAL_NODE, LocalError, relays, up};
use crate::output::Output;

/// Longest wait for an answer of the controller.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(30);
/// Longest wait for a sign of life.
const PROBE_TIMEOUT: Duration = Duration::from_secs(2);

/// Home, controller and output of one run.
#[derive(Debug)]
pub struct Session {
    /// Folder of the local stack.
    pub home: Home,
    /// Socket that the user named; `None` for the local controller.
    pub controller: Option<PathBuf>,
    /// The output.
    pub out: Output,
    /// The local controller's, once it was asked something.
    pub(crate) local: OnceLock<Client>,
    /// The local controller has answered, a moment ago.
    pub(crate) answered: AtomicBool,
}

impl Session {
    /// As the global options say, or else the variables.
    pub fn new(globals: &Globals, out: Output) -> Result<Self, CliError> {
        let controller = or_variable(&globals.controller, "RTSCTL_CONTROLLER");
        Ok(Self {
            home: home(globals)?,
            controller: controller.filter(|socket| !socket.as_os_str().is_empty()),
            out,
            local: OnceLock::new(),
            answered: AtomicBool::new(false),
        })
    }

    /// Nodes of this home whose agents do not run; none when the controller is not the local one.
    pub fn lacking(&self) -> Vec<String> {
        let nodes = match &self.controller {
            None => Nodes::of(&self.home).ok(),
            Some(_) => None,
        };
        let own = nodes
            .iter()
            .flat_map(Nodes::all)
            .filter(|node| node.ssh.is_none());
        let names = own.map(|node| &node.name);
        let ended = |name: &&String| is_held(&self.home.agent_lock(name)).is_ok_and(|held| !held);
        names.filter(ended).cloned().collect()
    }

    /// What helps against an error here; none when the error itself knows best.
    pub fn help(&self, error: &CliError) -> Option<String> {
        let lacking = match error.needs_an_agent() {
            true => self.lacking(),
            false => Vec::new(),
        };
        let what = match lacking.as_slice() {
            [] => return error.help_on_demand(&relays::on_demand(error.nodes())),
            [node] => format!("the agent of this machine (node {node}) does not run"),
            nodes => format!(
                "agents of this machine (nodes {}) do not run",
                nodes.join(", ")
            ),
        };
        let them = if lacking.len() == 1 { "it" } else { "them" };
        Some(format!("{what}: `rtsctl up` starts {them} again"))
    }

    /// The controller that runs. Nothing is started.
    pub async fn connect(&self) -> Result<Controller, CliError> {
        match &self.controller {
            Some(socket) => client(socket.clone(), REQUEST_TIMEOUT),
            None => {
                self.home.check_length(LOCAL_NODE)?;
                if self.local_answers().await? {
                    relays::wake_for(self).await?;
                    return self.local(REQUEST_TIMEOUT);
                }
                if is_held(&self.home.controller_lock())? {
                    return Err(up::hangs(&self.home).into());
                }
                Err(CliError::NoController {
                    home: self.home.path().to_owned(),
                })
            }
        }
    }

    /// The controller; the local one is started when none was named and none runs.
    pub async fn connect_or_start(&self) -> Result<Controller, CliError> {
        if self.controller.is_none() {
            // It answers then.
            up::ensure(self, up::Wish::default()).await?;
            return self.local(REQUEST_TIMEOUT);
        }
        self.connect().await
    }

    /// A client of the local controller, running or not. All share their connections.
    pub fn local(&self, timeout: Duration) -> Result<Controller, CliError> {
        let client = match self.local.get() {
            Some(client) => client,
            None => {
                let made = Client::unix(self.home.controller_socket(), REQUEST_TIMEOUT);
                let made = made.map_err(CliError::request("reach the controller"))?;
                self.local.get_or_init(|| made)
            }
        };
        Ok(Controller::new(client.within(timeout)))
    }

    /// Asks the local controller for a sign of life while something else is done that takes time.
    pub async fn ask_ahead(&self) {
        if self.controller.is_none() {
            // Who needs it asks again, and says what is wrong.
            let answers = self.local_answers().await.unwrap_or(false);
            self.answered.store(answers, Ordering::Relaxed);
        }
    }

    /// The local controller answers.
    pub async fn local_answers(&self) -> Result<bool, CliError> {
        Ok(self.local(PROBE_TIMEOUT)?.alive().await)
    }
}

/// The home that the global options name, or else the variable.
pub fn home(globals: &Globals) -> Result<Home, LocalError> {
    Home::settle(or_variable(&globals.home, "RTSCTL_HOME"))
}

/// What was said on the command line, else in a variable.
fn or_variable(said: &Option<PathBuf>, variable: &str) -> Option<PathBuf> {
    let said = said.clone();
    said.or_else(|| std::env::var_os(variable).map(PathBuf::from))
}

fn client(socket: PathBuf, timeout: Duration) -> Result<Controller, CliError> {
    Client::unix(socket, timeout)
        .map(Controller::new)
        .map_err(CliError::request("reach the controller"))
}
