//! The session with the controller: a greeting, then heartbeats. The agent works on without a controller.

use std::sync::Arc;
use std::time::Duration;

use rts_agent_api::PROTOCOL_VERSION;
use rts_agent_api::session::{HEARTBEAT, Heartbeat, SessionApi, SessionGreeting};
use rts_http::client::ClientError;
use rts_plan::delta::InventoryDelta;
use rts_plan::observed::Inventory;
use tokio::time::{Instant, sleep, sleep_until};

use crate::agent::Agent;
use crate::inventory::delta;

/// Shortest time between two greetings.
const RETRY: Duration = Duration::from_secs(1);
/// The same at first, doubled each time: a controller that is started beside this agent is there in a moment.
const FIRST: Duration = Duration::from_millis(4);
/// Shortest time between two heartbeats, however much there is to tell.
const BREATH: Duration = Duration::from_millis(50);

/// Largest delta in a heartbeat, in bytes: after a larger change the controller asks for all.
const MAX_DELTA: usize = 1024 * 1024;

/// Why heartbeats end.
enum End {
    /// The controller does not know the session.
    GreetAgain,
    /// A newer session of this node was opened.
    Superseded,
}

/// Keeps a session for as long as the agent runs, or until a newer one takes over.
pub(crate) async fn keep(agent: Arc<Agent>, controller: Arc<dyn SessionApi>) {
    let mut reported = String::new();
    let mut retry = FIRST;
    loop {
        let next = Instant::now() + retry;
        retry = (retry * 2).min(RETRY);
        match greet(&agent, &*controller).await {
            Ok(known) => {
                reported.clear();
                retry = RETRY;
                match beat(&agent, &*controller, known).await {
                    End::GreetAgain => {}
                    End::Superseded => return,
                }
            }
            Err(e) => {
                // The same reason is not told each second.
                let reason = e.to_string();
                if reason != reported && retry == RETRY {
                    tracing::warn!(
                        "no session with the controller, trying again each second: {reason}"
                    );
                    reported = reason;
                }
            }
        }
        sleep_until(next).await;
    }
}

/// Opens the session. Gives the inventory that the controller knows now.
async fn greet(
    agent: &Arc<Agent>,
    controller: &dyn SessionApi,
) -> Result<Arc<Inventory>, ClientError> {
    // What a restart would begin with: what is not durable yet is sent once more.
    let ledger = agent.ledger.lock().await.saved();
    let inventory = agent.observe().await;
    let greeting = SessionGreeting {
        protocol_version: PROTOCOL_VERSION,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        session: agent.session.clone(),
        endpoint: agent.folders.agent_socket().display().to_string(),
        aliases: agent.config.aliases.clone(),
        ledger,
        inventory: inventory.as_ref().clone(),
        transport: None,
    };
    let reply = controller.greet(&greeting).await?;
    agent.lease.sign();
    tracing::info!(
        cluster = reply.cluster_uid,
        epoch = reply.epoch,
        "session with the controller opened"
    );
    Ok(inventory)
}

/// Sends heartbeats. `known` is the inventory that the controller knows. One that is silent is sent the next heartbeat, and no
/// greeting: it may only be busy, and a greeting is much more to read.
async fn beat(agent: &Agent, controller: &dyn SessionApi, mut known: Arc<Inventory>) -> End {
    let mut silent = false;
    loop {
        let (mark, events) = agent.events.waiting();
        let now = agent.inventory.last();
        let heartbeat = Heartbeat {
            inventory_revision: now.revision,
            delta: delta(&known, &now).filter(is_small),
            events,
        };
        match controller.heartbeat(&agent.session, &heartbeat).await {
            Ok(()) => {
                agent.lease.sign();
                agent.events.told(mark);
                known = now;
                silent = false;
            }
            Err(ClientError::Problem(problem)) if problem.status == 409 => {
                tracing::error!(
                    "this agent was superseded: {problem}; it stays, but the controller no longer listens to it. Stop one of the two agents of node {}",
                    agent.config.node
                );
                agent.lease.superseded();
                return End::Superseded;
            }
            Err(ClientError::Problem(problem)) if problem.status == 404 => {
                tracing::warn!("heartbeat was not accepted: {problem}");
                return End::GreetAgain;
            }
            Err(e) => {
                if !std::mem::replace(&mut silent, true) {
                    tracing::warn!("heartbeat was not answered, trying again each second: {e}");
                }
                sleep(RETRY).await;
                continue;
            }
        }
        sleep(BREATH).await;
        tokio::select! {
            biased;
            () = sleep(HEARTBEAT - BREATH) => {}
            () = agent.events.bell.notified() => {}
        }
    }
}

fn is_small(delta: &InventoryDelta) -> bool {
    serde_json::to_vec(delta).is_ok_and(|text| text.len() <= MAX_DELTA)
}
