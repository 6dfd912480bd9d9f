//! Passing on what an agent streams, as it comes: what breaks there breaks off here.

use std::io;
use std::time::Duration;

use axum::body::Body;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use futures_util::stream;
use rts_agent_api::ClientError;
use rts_controller_api::Problem;
use tokio::sync::OwnedSemaphorePermit;
use tokio::time::timeout;

use super::{App, of_agent};

/// How long an agent may take to open a stream.
const OPEN: Duration = Duration::from_secs(10);

/// Waits until the agent of a node has opened a stream.
pub async fn opened(
    node: &str,
    open: impl Future<Output = Result<reqwest::Response, ClientError>>,
) -> Result<reqwest::Response, Problem> {
    let silent = |_| {
        let detail = format!("the agent of node {node} does not answer");
        Problem::unavailable("agent-unreachable", detail)
    };
    let opened = timeout(OPEN, open).await.map_err(silent)?;
    opened.map_err(|e| of_agent(node, e))
}

/// Passes a stream on, until the client goes, the stream ends, or this program does. The permit is held so long.
pub fn pass_on(
    app: &App,
    from: reqwest::Response,
    permit: Option<OwnedSemaphorePermit>,
    kind: &'static str,
) -> Response {
    let pieces = stream::try_unfold(
        (from, app.ending.clone(), permit),
        |(mut from, mut ending, permit)| async move {
            let chunk = tokio::select! {
                chunk = from.chunk() => chunk.map_err(io::Error::other)?,
                _ = ending.wait_for(|ending| *ending) => {
                    return Err(io::Error::other("the controller ends"));
                }
            };
            Ok(chunk.map(|bytes| (bytes, (from, ending, permit))))
        },
    );
    ([(CONTENT_TYPE, kind)], Body::from_stream(pieces)).into_response()
}
