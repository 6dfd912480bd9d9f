//! One connection with the agent over there, from its first stream to its end.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use rts_bridge::{Kind, Link, Opener, Stream, pulse};
use tokio::io::copy_bidirectional;
use tokio::net::{UnixListener, UnixStream};
use tokio::sync::{Notify, mpsc};
use tokio::task::JoinSet;

use crate::awake::is_own;
use crate::config::Config;
use crate::modules::Modules;
use crate::reach::Reached;
use crate::session_api;

/// Pause after a connection could not be accepted (no file descriptor is left).
pub(crate) const PAUSE: Duration = Duration::from_millis(100);
/// Most connections to the agent at once.
const MAX_CONNECTIONS: usize = 128;
/// Most questions for modules that are answered at once.
const MAX_QUESTIONS: usize = 32;

/// Why a connection has ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum End {
    /// It was lost.
    Lost(String),
    /// The agent was told to end, by somebody over there.
    Told,
}

/// Whoever can be reached now.
#[derive(Debug, Default)]
pub(crate) struct Now(Mutex<Option<Opener>>);

impl Now {
    fn set(&self, opener: Option<Opener>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = opener;
    }

    fn get(&self) -> Option<Opener> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }
}

/// Keeps a connection until it ends. Dropping this ends it too.
pub(crate) async fn keep(
    config: &Config,
    reached: &mut Reached,
    now: &Now,
    greeted: Arc<Notify>,
) -> End {
    let Some(pulse) = reached.pulse.take() else {
        return End::Lost("it was kept before".to_owned());
    };
    let modules = Modules::new(&config.module_path, &reached.machine);
    let (tell, told) = mpsc::channel(session_api::BACKLOG);
    now.set(Some(reached.link.opener.clone()));
    let resident = reached.resident;
    let api = session_api::serve(config.clone(), resident, told, greeted);
    let streams = take(&mut reached.link, modules, tell);
    let end = tokio::select! {
        end = pulse.keep() => match end {
            pulse::End::Told => End::Told,
            pulse::End::Lost => End::Lost("it carries nothing any more".to_owned()),
        },
        why = streams => End::Lost(why),
        () = reached.session.lost() => End::Lost("the SSH session has ended".to_owned()),
        served = api => End::Lost(format!("the session's API ended: {served:?}")),
    };
    now.set(None);
    end
}

/// Takes the streams that the agent opens; says why there are no more.
async fn take(link: &mut Link, modules: Modules, controller: mpsc::Sender<Stream>) -> String {
    let mut questions = JoinSet::new();
    loop {
        tokio::select! {
            stream = link.incoming.next() => {
                let Some(mut stream) = stream else {
                    return link.ended().await;
                };
                match Kind::read(&mut stream).await {
                    // One that finds no room is dropped, and so refused.
                    Some(Kind::Controller) => drop(controller.try_send(stream)),
                    Some(Kind::Module) if questions.len() < MAX_QUESTIONS => {
                        questions.spawn(modules.clone().serve(stream));
                    }
                    _ => {}
                }
            }
            Some(_) = questions.join_next() => {}
        }
    }
}

/// Joins whoever connects to the node's socket here to the agent over there, for ever. Without a connection nobody is served.
pub(crate) async fn serve_agent(listener: UnixListener, now: &Now) {
    let mut open = JoinSet::new();
    loop {
        tokio::select! {
            accepted = listener.accept() => match accepted {
                Ok((stream, _)) if open.len() < MAX_CONNECTIONS && is_own(&stream) => {
                    if let Some(opener) = now.get() {
                        open.spawn(to_agent(stream, opener));
                    }
                }
                Ok(_) => {}
                Err(e) => {
                    tracing::warn!("cannot accept a connection to the agent: {e}");
                    tokio::time::sleep(PAUSE).await;
                }
            },
            Some(_) = open.join_next() => {}
        }
    }
}

async fn to_agent(mut here: UnixStream, opener: Opener) {
    if let Ok(mut there) = opener.open(Kind::Agent).await
        && let Err(e) = copy_bidirectional(&mut here, &mut there).await
    {
        tracing::debug!("a connection to the agent has failed: {e}");
    }
}
