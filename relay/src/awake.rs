//! Who needs the relay: each command holds a connection to its socket, and reads there how the session is.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{UnixListener, UnixStream};
use tokio::sync::watch;
use tokio::task::JoinSet;

/// Most commands at once; more are not let in.
const MAX_COMMANDS: usize = 256;

/// How the session is: a line of JSON for each change.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "state", rename_all = "camelCase")]
pub enum State {
    /// The node is reached.
    Up {
        /// An agent lives there on its own.
        resident: bool,
    },
    /// The session was lost; another one is being opened.
    Lost {
        /// Why.
        reason: String,
    },
    /// It was given up: the relay ends.
    Failed {
        /// Why.
        reason: String,
        /// How to mend it.
        help: Option<String>,
        /// Exit code of a program that needs the node.
        exit: u8,
    },
}

/// Counts commands.
#[derive(Debug, Clone)]
pub(crate) struct Commands(Arc<watch::Sender<usize>>);

/// A command that holds the relay awake until this is dropped.
struct Holds(Commands);

impl Commands {
    pub fn new() -> Self {
        Self(Arc::new(watch::Sender::new(0)))
    }

    /// How many there are, and its changes.
    pub fn count(&self) -> watch::Receiver<usize> {
        self.0.subscribe()
    }

    fn hold(&self) -> Holds {
        self.0.send_modify(|count| *count += 1);
        Holds(self.clone())
    }
}

impl Drop for Holds {
    fn drop(&mut self) {
        self.0
            .0
            .send_modify(|count| *count = count.saturating_sub(1));
    }
}

/// Lets commands hold the relay awake, for ever.
pub(crate) async fn serve(
    listener: UnixListener,
    commands: Commands,
    state: watch::Receiver<State>,
) {
    let mut open = JoinSet::new();
    loop {
        tokio::select! {
            accepted = listener.accept() => match accepted {
                Ok((stream, _)) if open.len() < MAX_COMMANDS && is_own(&stream) => {
                    open.spawn(hold(stream, commands.hold(), state.clone()));
                }
                Ok(_) => {}
                Err(e) => {
                    tracing::warn!("cannot accept a command: {e}");
                    tokio::time::sleep(crate::link::PAUSE).await;
                }
            },
            Some(_) = open.join_next() => {}
        }
    }
}

/// Tells a command how the session is, until the command has gone.
async fn hold(stream: UnixStream, holds: Holds, mut state: watch::Receiver<State>) {
    let (mut from, mut to) = stream.into_split();
    let tell = async {
        loop {
            let now = state.borrow_and_update().clone();
            let Ok(mut line) = serde_json::to_vec(&now) else {
                return;
            };
            line.push(b'\n');
            if to.write_all(&line).await.is_err() || state.changed().await.is_err() {
                return;
            }
        }
    };
    let mut byte = [0];
    tokio::select! {
        () = tell => {}
        _ = from.read(&mut byte) => {}
    }
    drop(holds);
}

/// Whether whoever connected is the user of this process, or root.
pub(crate) fn is_own(stream: &UnixStream) -> bool {
    let own = rustix::process::geteuid().as_raw();
    stream
        .peer_cred()
        .is_ok_and(|peer| peer.uid() == own || peer.uid() == 0)
}
