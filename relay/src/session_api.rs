//! What the agent over there may tell the controller: its greeting and its heartbeats, and nothing else. Its greeting names the
//! node's socket on this machine, how the node is reached, and the hosts that mean it.

use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use axum::Router;
use axum::extract::{DefaultBodyLimit, Path, State};
use axum::routing::post;
use axum::serve::Listener;
use rts_agent_api::ClientError;
use rts_agent_api::session::{
    HEARTBEATS, Heartbeat, SESSIONS, SessionApi, SessionClient, SessionGreeting, SessionReply,
    Transport,
};
use rts_bridge::Stream;
use rts_http::client::{Client, MAX_BODY};
use rts_http::problem::Problem;
use rts_http::server::{Json, ProblemResponse};
use tokio::sync::{Notify, mpsc};

use crate::config::Config;

/// Bound on one request to the controller.
const REQUEST: Duration = Duration::from_secs(5);
/// Connections that wait to be served; more are refused.
pub(crate) const BACKLOG: usize = 16;

/// What is said for the node.
struct Speaker {
    node: String,
    endpoint: String,
    aliases: Vec<String>,
    transport: Transport,
    controller: SessionClient,
    /// Rings when the controller has answered a greeting.
    greeted: Arc<Notify>,
    /// It has answered one of this session. An agent that lives over there on its own goes on with heartbeats when it is reached
    /// again; only a greeting tells how, and that may be another way than before.
    met: AtomicBool,
}

/// The connections of the agent over there.
struct Incoming(mpsc::Receiver<Stream>);

impl Listener for Incoming {
    type Io = Stream;
    type Addr = ();

    async fn accept(&mut self) -> (Stream, ()) {
        match self.0.recv().await {
            Some(stream) => (stream, ()),
            // The connection is just ending, and this task with it.
            None => std::future::pending().await,
        }
    }

    fn local_addr(&self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Serves connections of the agent over there, for ever.
pub(crate) async fn serve(
    config: Config,
    resident: bool,
    streams: mpsc::Receiver<Stream>,
    greeted: Arc<Notify>,
) -> std::io::Result<()> {
    let http = Client::unix(config.controller_socket(), REQUEST).map_err(std::io::Error::other)?;
    let speaker = Speaker {
        endpoint: config.agent_socket().display().to_string(),
        aliases: config.aliases.clone(),
        transport: Transport {
            kind: Transport::SSH.to_owned(),
            destination: config.destination.to_string(),
            resident,
        },
        controller: SessionClient::new(http, &config.node),
        node: config.node,
        greeted,
        met: AtomicBool::new(false),
    };
    axum::serve(Incoming(streams), router(Arc::new(speaker))).await
}

fn router(speaker: Arc<Speaker>) -> Router {
    Router::new()
        .route(SESSIONS, post(greet))
        .route(HEARTBEATS, post(beat))
        .fallback(nothing_else)
        .layer(DefaultBodyLimit::max(MAX_BODY))
        .with_state(speaker)
}

async fn greet(
    State(speaker): State<Arc<Speaker>>,
    Path(node): Path<String>,
    Json(mut greeting): Json<SessionGreeting>,
) -> Result<Json<SessionReply>, ProblemResponse> {
    speaker.is_own(&node)?;
    greeting.endpoint.clone_from(&speaker.endpoint);
    greeting.aliases.clone_from(&speaker.aliases);
    greeting.transport = Some(speaker.transport.clone());
    let reply = speaker.controller.greet(&greeting).await;
    if matches!(reply, Ok(_) | Err(ClientError::Problem(_))) {
        speaker.met.store(true, Ordering::Relaxed);
        speaker.greeted.notify_one();
    }
    reply.map(Json).map_err(passed_on)
}

async fn beat(
    State(speaker): State<Arc<Speaker>>,
    Path((node, session)): Path<(String, String)>,
    Json(heartbeat): Json<Heartbeat>,
) -> Result<(), ProblemResponse> {
    speaker.is_own(&node)?;
    if !speaker.met.load(Ordering::Relaxed) {
        let detail = format!("node {node} is reached anew: greet again");
        return Err(Problem::not_found(detail).into());
    }
    let taken = speaker.controller.heartbeat(&session, &heartbeat).await;
    taken.map_err(passed_on)
}

async fn nothing_else() -> Result<Infallible, ProblemResponse> {
    let detail =
        "a node that is reached by SSH tells its controller of its own session, and nothing else";
    Err(Problem::new(403, "forbidden", "forbidden", detail).into())
}

impl Speaker {
    fn is_own(&self, node: &str) -> Result<(), Problem> {
        if node == self.node {
            return Ok(());
        }
        let detail = format!(
            "this connection is that of node {}, not of {node}",
            self.node
        );
        Err(Problem::new(403, "forbidden", "forbidden", detail))
    }
}

fn passed_on(error: ClientError) -> ProblemResponse {
    match error {
        ClientError::Problem(problem) => problem.into(),
        other => Problem::unavailable("controller-unreachable", other.to_string()).into(),
    }
}
