//! What agents tell: greetings and heartbeats.

use std::sync::Arc;

use rts_agent_api::ClientError;
use rts_agent_api::session::{Heartbeat, SessionGreeting, SessionReply};
use rts_controller_api::Problem;
use rts_schemas::names::is_dns_label;

use crate::core::Core;
use crate::view::Happening;

/// Events of one heartbeat that are taken in.
const MAX_EVENTS: usize = 100;

/// An agent greets; the newest session of a node wins.
pub fn greet(
    core: &Arc<Core>,
    node: &str,
    greeting: SessionGreeting,
) -> Result<SessionReply, Problem> {
    if !is_dns_label(node) {
        let detail = format!("node name {node:?} is not a DNS label: 1 to 63 of a-z, 0-9 and -");
        return Err(Problem::invalid("bad-name", detail));
    }
    let agent = core
        .fleet
        .agent(node, &greeting.endpoint)
        .map_err(|e| of_agent(node, e))?;
    let version = greeting.version.clone();
    let (uid, now) = (core.rng.uuid(), core.clock.now());
    if core.sessions.greet(node, greeting, agent, uid, now)? {
        let message = format!("agent {version} greeted");
        core.record(Happening::normal(
            "NodeReady",
            &format!("node/{node}"),
            message,
        ));
    }
    core.publish_soon();
    core.wake.notify_one();
    // The session is kept all the same: it is there when the loop goes on.
    core.pulse.check()?;
    Ok(SessionReply {
        cluster_uid: core.cluster_uid.clone(),
        epoch: core.epoch(),
    })
}

/// A sign of life.
pub fn heartbeat(
    core: &Arc<Core>,
    node: &str,
    session: &str,
    mut heartbeat: Heartbeat,
) -> Result<(), Problem> {
    let now = core.clock.now();
    let beat = core.sessions.beat(node, session, &mut heartbeat, now)?;
    for event in heartbeat.events.into_iter().take(MAX_EVENTS) {
        core.record(event.into());
    }
    if beat.back {
        let object = format!("node/{node}");
        core.record(Happening::normal(
            "NodeReady",
            &object,
            "its heartbeats are back",
        ));
        core.publish_soon();
    }
    if beat.back {
        core.wake.notify_one();
    } else if beat.inventory_changed {
        core.news.notify_one();
    }
    core.pulse.check()
}

/// An error of an agent, for our client.
pub fn of_agent(node: &str, error: ClientError) -> Problem {
    match error {
        ClientError::Problem(problem) => problem,
        ClientError::Unreachable { .. } => Problem::unavailable(
            "agent-unreachable",
            format!("the agent of node {node} cannot be reached: {error}"),
        ),
        ClientError::Protocol { .. } => Problem::new(
            502,
            "agent-protocol",
            "bad gateway",
            format!(
                "the agent of node {node} answers in an unknown way, upgrade the older side: {error}"
            ),
        ),
    }
}
