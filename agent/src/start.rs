//! Start and end of an agent, and what it does of its own accord.

use std::sync::Arc;
use std::time::Duration;

use rts_host::error::chain;
use tokio::sync::oneshot;
use tokio::task::JoinSet;
use tokio::time::{Instant, MissedTickBehavior, interval, sleep};

use crate::agent::{Agent, StartError};
use crate::config::Config;
use crate::inputs::Inputs;
use crate::local::LocalAgent;
use crate::managers::{adopt_all, adopt_round, bury_orphans};
use crate::{heal, session};

/// How often the managers are asked without a reason: one that hangs tells nobody.
const SLOW_TICK: Duration = Duration::from_secs(1);
/// Slow ticks from one look for what managers without a run folder left behind to the next.
const ORPHANS: u64 = 30;
/// Shortest time between two rounds of questions.
const QUICK: Duration = Duration::from_millis(10);
/// So many times as long as a round took, others come first: with many components, or on a busy machine, looking must not be what
/// keeps managers from answering.
const REST: u32 = 4;
/// But no longer than this.
const MOST: Duration = Duration::from_secs(1);

/// An agent that runs. Its background tasks end when it is dropped.
pub struct Running {
    agent: Arc<Agent>,
    /// Told when another agent has taken the node; closed when the agent no longer looks.
    lost: oneshot::Receiver<StartError>,
    background: JoinSet<()>,
}

/// Starts an agent within the present runtime. When this returns, it has adopted the managers that run on its node.
pub async fn start(config: Config, inputs: Inputs) -> Result<Running, StartError> {
    Ok(begin(prepare(config, inputs).await?))
}

/// An agent that knows what runs, and does nothing yet.
pub(crate) async fn prepare(config: Config, inputs: Inputs) -> Result<Arc<Agent>, StartError> {
    let agent = Arc::new(Agent::new(config, inputs).await?);
    adopt_all(&agent).await;
    agent.observe().await;
    Ok(agent)
}

/// Lets an agent act.
pub(crate) fn begin(agent: Arc<Agent>) -> Running {
    let mut background = JoinSet::new();
    let (lose, lost) = oneshot::channel();
    background.spawn(watch(agent.clone(), lose));
    background.spawn(heal::keep(agent.clone()));
    if let Some(controller) = agent.inputs.controller.clone() {
        background.spawn(session::keep(agent.clone(), controller));
    }
    tracing::info!(
        node = agent.config.node,
        session = agent.session,
        managers = agent.managers.all().len(),
        "agent serves on {}",
        agent.folders.agent_socket().display()
    );
    Running {
        agent,
        lost,
        background,
    }
}

impl Running {
    /// Its API.
    pub fn api(&self) -> LocalAgent {
        LocalAgent::new(self.agent.clone())
    }

    /// Waits until another agent has taken the node: this one must end, and has stopped healing.
    pub async fn lost(&mut self) -> StartError {
        match (&mut self.lost).await {
            Ok(why) => why,
            // Nobody looks any more: it is just being stopped.
            Err(_) => std::future::pending().await,
        }
    }

    /// Ends it. Managers go on.
    pub async fn stop(mut self) {
        self.background.shutdown().await;
        self.agent.restarts.save().await;
    }
}

/// Asks the managers whenever something may have changed, and now and then without a reason. Ends when another agent
/// has the node.
async fn watch(agent: Arc<Agent>, lose: oneshot::Sender<StartError>) {
    let mut slow = interval(SLOW_TICK);
    slow.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut ticks = 0_u64;
    loop {
        tokio::select! {
            // First: it is due but once a second, and others ring all the time.
            biased;
            _ = slow.tick() => {
                if let Err(e) = keep(&agent).await {
                    agent.lease.superseded();
                    agent.batches.cancel_all("another agent has taken the node");
                    tracing::error!("{}", chain(&e));
                    let _ = lose.send(e);
                    return;
                }
                adopt_round(&agent).await;
                // Not at once: a manager makes its folder anew when somebody removed it.
                if ticks % ORPHANS == ORPHANS / 10 {
                    bury_orphans(&agent).await;
                }
                ticks = ticks.wrapping_add(1);
            }
            () = agent.dirty.notified() => {}
            () = agent.acted.rung() => if !agent.is_unseen_soon().await {
                continue;
            }
        }
        let begin = Instant::now();
        agent.observe().await;
        sleep((begin.elapsed() * REST).clamp(QUICK, MOST)).await;
    }
}

/// Makes anew what somebody has removed of the node's folders; an error when another agent has the node by now.
async fn keep(agent: &Agent) -> Result<(), StartError> {
    match agent.inputs.machine.keep().await {
        Err(e @ StartError::Running { .. }) => Err(e),
        // It may do better the next time.
        Err(e) => {
            tracing::warn!("{}", chain(&e));
            Ok(())
        }
        Ok(()) => Ok(()),
    }
}
