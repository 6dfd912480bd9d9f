//! Who keeps the node: an agent of this very process, or one that lives there on its own.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rts_bridge::Opener;
use rts_host::files;
use rts_host::identity::Identity;
use rts_host::process::Process;
use rustix::process::Signal;
use tokio::task::spawn_blocking;

use super::controller_socket;
use crate::agent::StartError;
use crate::config::Config;
use crate::folders::Folders;
use crate::machine::Pull;
use crate::serve::{Serving, serve_with};

/// How long the one before may take to end, when it is asked and when it is killed.
const END: Duration = Duration::from_secs(3);

/// A node that is kept.
pub(super) struct Seat {
    agent_socket: PathBuf,
    controller_socket: PathBuf,
    /// Names this process as the one that joins streams.
    description: PathBuf,
    pull: Pull,
    /// None where an agent lives on its own.
    serving: Option<Serving>,
}

impl Seat {
    /// Ends the process of an earlier connection, and becomes the agent of the node unless one lives there.
    pub async fn take(mut config: Config, folders: &Folders) -> Result<Self, StartError> {
        let description = folders.run.join("stdio.json");
        end_former(&description).await;
        describe(&description, folders)?;
        let pull = Pull::new(&folders.home);
        let controller = folders.controller_socket();
        config.controller_socket = Some(controller.clone());
        let serving = match resident(folders)? {
            true => None,
            false => Some(serve_with(config, Some(pull.clone())).await?),
        };
        Ok(Self {
            agent_socket: folders.agent_socket(),
            controller_socket: controller,
            description,
            pull,
            serving,
        })
    }

    /// An agent lives there on its own.
    pub fn is_resident(&self) -> bool {
        self.serving.is_none()
    }

    /// Where the agent serves.
    pub fn agent_socket(&self) -> &Path {
        &self.agent_socket
    }

    /// The connection is there.
    pub fn connected(&self, near: &Opener) {
        self.pull.connected(near.clone());
    }

    /// Ends the agent, if it is this process. What a newcomer has put in its place stays.
    pub async fn leave(self) {
        if let Some(serving) = self.serving {
            serving.stop().await;
        }
        if Identity::read(&self.description).is_some_and(|i| i.pid == std::process::id()) {
            let _ = std::fs::remove_file(&self.controller_socket);
            let _ = std::fs::remove_file(&self.description);
        }
    }
}

impl Folders {
    /// Where an agent that is reached by a connection finds its controller.
    pub fn controller_socket(&self) -> PathBuf {
        controller_socket(&self.run)
    }
}

/// The connection of the one before is cut, or is another one's: a newcomer goes before it.
async fn end_former(description: &Path) {
    let Some(former) = Identity::read(description) else {
        return;
    };
    let ended = spawn_blocking(move || {
        let Some(process) = Process::identified(&former) else {
            return true;
        };
        process.signal(Signal::TERM);
        if process.ended(END) {
            return true;
        }
        process.signal(Signal::KILL);
        process.ended(END)
    });
    if !ended.await.unwrap_or(false) {
        tracing::warn!("the process of an earlier connection does not end");
    }
}

fn describe(path: &Path, folders: &Folders) -> Result<(), StartError> {
    let own = Identity::own(env!("CARGO_PKG_VERSION"));
    serde_json::to_vec(&own)
        .map_err(io::Error::from)
        .and_then(|text| folders.reserve().write(|| files::replace(path, &text)))
        .map_err(|source| StartError::File {
            path: path.to_owned(),
            source,
        })
}

/// True when an agent holds the node that says who it is, and lives.
fn resident(folders: &Folders) -> Result<bool, StartError> {
    let path = folders.state.join("agent.lock");
    let lock = files::lock(&path).map_err(|source| StartError::File {
        path: path.clone(),
        source,
    })?;
    Ok(lock.is_none() && Identity::read(&folders.description()).is_some_and(|i| i.is_now()))
}
