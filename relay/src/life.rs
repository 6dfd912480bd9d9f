//! The life of a relay: as long as commands need it and some time more; a session that is lost meanwhile is opened again.

use std::sync::Arc;
use std::time::Duration;

use rts_host::error::chain;
use tokio::sync::{Notify, watch};
use tokio::time::{Instant, sleep, timeout};

use crate::awake::{Commands, State};
use crate::config::Config;
use crate::link::{End, Now, keep};
use crate::reach::{ReachError, Reached, reach};

/// First pause before a lost session is opened again; each is twice the one before.
const FIRST_PAUSE: Duration = Duration::from_millis(200);
/// Longest of these pauses.
const LONGEST_PAUSE: Duration = Duration::from_secs(5);
/// Longest time that is spent on reaching a node again.
const PATIENCE: Duration = Duration::from_secs(120);
/// Longest wait until the controller has met the agent.
const GREETING: Duration = Duration::from_secs(5);
/// Time for those who wait to read why it ends.
const LAST_WORDS: Duration = Duration::from_millis(200);
/// Longest orderly end of a session.
const CLOSE: Duration = Duration::from_secs(3);

/// Lives until nobody needs the node, or it cannot be reached any more.
pub(crate) async fn live(
    config: &Config,
    first: Reached,
    now: &Now,
    commands: &Commands,
    state: &watch::Sender<State>,
) {
    let mut reached = first;
    loop {
        let resident = reached.resident;
        let greeted = Arc::new(Notify::new());
        // A command that goes on before the controller has met the agent would find a session that has ended.
        let up = async {
            let _ = timeout(GREETING, greeted.notified()).await;
            state.send_replace(State::Up { resident });
            std::future::pending::<()>().await;
        };
        let end = tokio::select! {
            end = keep(config, &mut reached, now, Arc::clone(&greeted)) => end,
            () = up => return,
            () = unneeded(commands, config.keep) => {
                tracing::info!("no command needs node {}: the session is closed, managers go on", config.node);
                close(reached).await;
                return;
            }
        };
        // The connection first: the agent over there must not outlive what it answers.
        drop(reached);
        let reason = match end {
            End::Told => {
                let reason = "its agent was told to end over there, perhaps for another rtsctl";
                return give_up(state, reason.to_owned(), None, 4).await;
            }
            End::Lost(reason) => reason,
        };
        tracing::warn!(
            "the connection with node {} was lost: {reason}",
            config.node
        );
        state.send_replace(State::Lost {
            reason: reason.clone(),
        });
        reached = match again(config, commands).await {
            Some(Ok(reached)) => reached,
            Some(Err(e)) => {
                tracing::error!("node {} is given up: {}", config.node, chain(&e));
                return give_up(state, chain(&e), e.help(), e.exit()).await;
            }
            None => return,
        };
        tracing::info!("node {} is reached again", config.node);
    }
}

/// Opens a session again; none when nobody needs it.
async fn again(config: &Config, commands: &Commands) -> Option<Result<Reached, ReachError>> {
    let end = Instant::now() + PATIENCE;
    let mut pause = FIRST_PAUSE;
    let mut count = commands.count();
    loop {
        if *count.borrow_and_update() == 0 {
            tracing::info!("no command needs node {} any more", config.node);
            return None;
        }
        sleep(pause).await;
        match reach(config).await {
            Err(e) if e.is_passing() && Instant::now() < end => {
                tracing::warn!(
                    "node {} is not reached, trying again: {}",
                    config.node,
                    chain(&e)
                );
            }
            done => return Some(done),
        }
        pause = (pause * 2).min(LONGEST_PAUSE);
    }
}

/// Returns when no command has needed the node for so long.
async fn unneeded(commands: &Commands, patience: Duration) {
    let mut count = commands.count();
    loop {
        let none = *count.borrow_and_update() == 0;
        let changed = count.changed();
        if !none {
            if changed.await.is_err() {
                return;
            }
        } else if timeout(patience, changed).await.is_err() {
            return;
        }
    }
}

/// Says to those who wait why it ends.
pub(crate) async fn give_up(
    state: &watch::Sender<State>,
    reason: String,
    help: Option<String>,
    exit: u8,
) {
    state.send_replace(State::Failed { reason, help, exit });
    sleep(LAST_WORDS).await;
}

/// Ends the agent over there, and then the session.
pub(crate) async fn close(reached: Reached) {
    let Reached { link, session, .. } = reached;
    drop(link);
    let _ = timeout(CLOSE, session.close()).await;
}
