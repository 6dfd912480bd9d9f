//! What a verb works with: the home, the controller's socket, and the output.

use std::path::PathBuf;
use std::time::Duration;

use rts_controller_api::client::Controller;
use rts_http::client::Client;

use crate::cli::Globals;
use crate::error::CliError;
use crate::local::home::Home;
use crate::local::lock::is_held;
use crate::local::up;
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
}

impl Session {
    /// As the global options say.
    pub fn new(globals: &Globals, out: Output) -> Result<Self, CliError> {
        Ok(Self {
            home: Home::settle(globals.home.clone())?,
            controller: globals
                .controller
                .clone()
                .filter(|socket| !socket.as_os_str().is_empty()),
            out,
        })
    }

    /// The controller that runs. Nothing is started.
    pub async fn connect(&self) -> Result<Controller, CliError> {
        match &self.controller {
            Some(socket) => client(socket.clone(), REQUEST_TIMEOUT),
            None => {
                self.home.check_length()?;
                if self.local_answers().await? {
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
            up::ensure(self, None).await?;
        }
        self.connect().await
    }

    /// A client of the local controller, running or not.
    pub fn local(&self, timeout: Duration) -> Result<Controller, CliError> {
        client(self.home.controller_socket(), timeout)
    }

    /// The local controller answers.
    pub async fn local_answers(&self) -> Result<bool, CliError> {
        Ok(self.local(PROBE_TIMEOUT)?.alive().await)
    }
}

fn client(socket: PathBuf, timeout: Duration) -> Result<Controller, CliError> {
    Client::unix(socket, timeout)
        .map(Controller::new)
        .map_err(CliError::request("reach the controller"))
}
