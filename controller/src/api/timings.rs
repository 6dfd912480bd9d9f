//! Where the time went, here and on all nodes.

use std::time::Duration;

use axum::extract::State;
use futures_util::future::join_all;
use rts_agent_api::client::HttpAgent;
use rts_agent_api::messages::{TimedSpan, Timings, TimingsQuery, micros};
use rts_host::timing;
use rts_http::server::{Json, Principal};
use tokio::time::timeout;

use super::extract::Params;
use super::{App, managers};

/// How long an agent may take to tell.
const DEADLINE: Duration = Duration::from_secs(2);

/// What took how long lately, here and at the agents that tell. Their times are by this program's clock.
#[utoipa::path(
    get, path = "/v1/timings",
    params(("micros" = u64, Query, description = "Spans that ended within so many microseconds")),
    responses((status = 200, body = Timings))
)]
pub async fn timings(
    State(app): State<App>,
    _: Principal,
    Params(query): Params<TimingsQuery>,
) -> Json<Timings> {
    let kept = timing::within(Duration::from_micros(query.micros));
    let nodes = app.core.sessions.all().into_iter();
    let live = nodes.filter(|(_, entry)| !entry.lost);
    let agents = live.filter_map(|(node, _)| Some((managers::agent(&app, &node).ok()?, node)));
    let theirs = join_all(agents.map(|(agent, node)| of_agent(agent, node, &query))).await;
    let mut timings = Timings::of(kept, timing::now());
    timings.spans.extend(theirs.into_iter().flatten());
    Json(timings)
}

/// What an agent tells; nothing when it does not.
async fn of_agent(agent: HttpAgent, node: String, query: &TimingsQuery) -> Vec<TimedSpan> {
    let asked = micros(timing::now());
    let Ok(Ok(told)) = timeout(DEADLINE, agent.timings(query)).await else {
        return Vec::new();
    };
    // It looked at its clock somewhere in between.
    let told_at = asked.midpoint(micros(timing::now()));
    told.by(told_at, &format!("agent {node}")).collect()
}
