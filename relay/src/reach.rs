//! From an SSH session to an agent that serves over it: programs are there by their digest, and one of them is started.

use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll};
use std::time::Duration;

use rts_bridge::{Link, LinkError, pulse};
use rts_host::error::chain;
use rts_ssh::{Child, Claim, Collected, Kind, LocalFile, Session, SshError};
use tokio::io::{AsyncRead, ReadBuf};
use tokio::time::timeout;

use crate::config::Config;
use crate::log;

/// Connections that may be cut before the first one is given up.
const CUTS: u32 = 4;
/// Pause before the next of them.
const PAUSE: Duration = Duration::from_millis(300);
/// How long old copies may be looked for before the connection is made: the agent waits for its greeting meanwhile.
const COLLECT: Duration = Duration::from_secs(5);

/// The node was not reached.
#[derive(Debug, thiserror::Error)]
pub enum ReachError {
    /// The session.
    #[error(transparent)]
    Ssh(#[from] SshError),
    /// The agent over there.
    #[error("no agent serves on {host}{}", last.as_ref().map(|last| format!(", it said {last:?}")).unwrap_or_default())]
    Agent {
        /// Whom.
        host: String,
        /// Why.
        source: LinkError,
        /// The last that it said.
        last: Option<String>,
    },
}

impl ReachError {
    /// Exit code of a program that needs the node.
    pub fn exit(&self) -> u8 {
        match self {
            Self::Ssh(e) => match e.kind() {
                Kind::Unreachable => 4,
                Kind::Forbidden => 8,
                Kind::Partly => 5,
                Kind::Usage => 2,
                Kind::Conflict => 7,
            },
            Self::Agent { .. } => 4,
        }
    }

    /// How to mend it.
    pub fn help(&self) -> Option<String> {
        match self {
            Self::Ssh(e) => e.help(),
            Self::Agent { .. } => None,
        }
    }

    /// The connection was there, or just coming about, and was cut: the next may well come about at once.
    pub fn was_cut(&self) -> bool {
        match self {
            Self::Ssh(e) => e.was_cut(),
            Self::Agent { .. } => self.is_passing(),
        }
    }

    /// Trying again may help without that anybody mends something.
    pub fn is_passing(&self) -> bool {
        match self {
            Self::Ssh(e) => e.is_passing(),
            Self::Agent { source, .. } => {
                !matches!(source, LinkError::Version { .. } | LinkError::Refused(_))
            }
        }
    }
}

/// A node that is reached. Dropping it ends the agent over there, and then the session.
pub(crate) struct Reached {
    /// The connection with the agent.
    pub link: Link,
    /// Signs of life; taken by whoever keeps the connection.
    pub pulse: Option<pulse::Near>,
    /// An agent lives there on its own.
    pub resident: bool,
    /// The machine over there, as `uname -m` names it.
    pub machine: String,
    /// The session, which ends after the connection.
    pub session: Session,
}

/// What the agent over there says. The agent's process is held with it.
struct Output(Child);

impl AsyncRead for Output {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.0.stdout).poll_read(context, buffer)
    }
}

/// Reaches it, and at once again should the connection be cut meanwhile.
pub(crate) async fn reach_first(config: &Config) -> Result<Reached, ReachError> {
    for _ in 1..CUTS {
        match reach(config).await {
            Err(e) if e.was_cut() => {
                tracing::warn!(
                    "node {} is not reached, trying again: {}",
                    config.node,
                    chain(&e)
                );
                tokio::time::sleep(PAUSE).await;
            }
            done => return done,
        }
    }
    reach(config).await
}

/// Logs in, copies what is missing, and starts the agent.
pub(crate) async fn reach(config: &Config) -> Result<Reached, ReachError> {
    let session = Session::open(&config.destination, &config.run()).await?;
    let survey = session.survey().await?;
    let programs = ["rts-agent", "rts-manager"].map(|name| config.programs.join(name));
    for program in &programs {
        survey.check_machine(session.host(), program)?;
    }
    let home = survey.rtsctl_home();
    let files = programs.map(LocalFile::program);
    let lease = config.lease();
    let stored = session.store_programs(&files, &home, &lease).await?;
    if stored.sent_files() > 0 {
        tracing::info!(
            bytes = stored.sent_bytes(),
            files = stored.sent_files(),
            "copied programs"
        );
    }
    let path = |name| stored.path(name).unwrap_or(name);
    let (agent, manager) = (path("rts-agent"), path("rts-manager"));
    let variable = format!("RTSCTL_HOME={home}");
    let installed = format!("{home}/modules");
    let arguments = [
        variable.as_str(),
        agent,
        "--stdio",
        "--home",
        &home,
        "--node",
        &config.node,
        "--manager-program",
        manager,
        "--module-path",
        &installed,
    ];
    let keep: Vec<&str> = stored
        .files
        .iter()
        .map(|file| file.digest.as_str())
        .collect();
    // What a component starts can be told to be of this home, wherever it goes.
    let (child, collected) = tokio::join!(
        session.spawn("env", &arguments),
        timeout(COLLECT, session.collect(&home, Claim::Keep(&lease, &keep)))
    );
    match collected {
        Ok(Ok(Collected { removed, told })) => {
            if removed > 0 {
                tracing::info!("removed {removed} old copies over there");
            }
            for why in told {
                tracing::warn!("copies over there: {why}");
            }
        }
        Ok(Err(e)) => tracing::warn!("old copies stay over there: {}", chain(&e)),
        // The lease was written first. The next session goes on.
        Err(_) => tracing::warn!("removing old copies over there takes long: some may stay"),
    }
    let mut child = child?;
    let last = Arc::new(Mutex::new(None));
    if let Some(stderr) = child.stderr.take() {
        tokio::spawn(log::bring_home(stderr, Arc::clone(&last)));
    }
    let host = session.host().to_owned();
    let failed = |source| ReachError::Agent {
        host: host.clone(),
        source,
        last: log::last(&last),
    };
    let Some(stdin) = child.stdin.take() else {
        return Err(failed(LinkError::Gone(rts_bridge::Gone)));
    };
    let near = rts_bridge::near(Output(child), stdin, env!("CARGO_PKG_VERSION")).await;
    let near = near.map_err(failed)?;
    Ok(Reached {
        link: near.link,
        pulse: Some(near.pulse),
        resident: near.resident,
        machine: survey.machine_name(),
        session,
    })
}
