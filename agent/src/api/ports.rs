//! What goes over a port: looked at, or written by hand, for as long as the client stays.

use std::io;

use axum::body::Body;
use axum::extract::{Path, Query, State};
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use futures_util::{StreamExt, stream};
use jiff::Timestamp;
use rts_agent_api::messages::{InjectLine, InjectQuery, Injected, PortEvent};
use rts_agent_api::paths;
use rts_http::lines::{Lines, MAX_LINE};
use rts_http::problem::Problem;
use rts_http::server::{Json, Principal};
use rts_manager_api::tap::{MAX_SAMPLE, TapEnd, TapWay};

use super::{Answer, Shared};
use crate::tap::{Came, Reader, Tap};

/// Largest sample whose bytes fit a line in base64, with room for the rest of it.
const MAX_SHOWN: usize = MAX_LINE / 4 * 3 - 1024;

/// What an out-port writes, as JSON Lines of PortEvent, for as long as the client stays. Who reads too slowly misses
/// samples, and is told how many; the component never waits.
#[utoipa::path(
    get,
    path = paths::SAMPLES,
    params(
        ("instance" = String, Path, description = "instance name"),
        ("port" = String, Path, description = "bare name of an out-port")
    ),
    responses(
        (status = 200, body = PortEvent, content_type = "application/jsonl"),
        (status = 404, description = "not-found: component or out-port", body = Problem),
        (status = 409, description = "manager-conflict: too many are looked at", body = Problem),
        (status = 501, description = "upgrade: the manager is of an older version", body = Problem),
        (status = 503, description = "manager-silent", body = Problem)
    )
)]
pub(super) async fn samples(
    _: Principal,
    State(agent): Shared,
    Path((instance, port)): Path<(String, String)>,
) -> Answer<Response> {
    let tap = agent.tap(&instance, &port, TapWay::Print).await?;
    let Tap { opened, from, to } = tap;
    let first = PortEvent::Opened {
        incarnation: opened.incarnation,
        data_type: opened.data_type,
    };
    // The writing half stays with the stream: its end would be that of the connection.
    let events = stream::unfold((Some(first), Some(from), to), |(first, from, to)| async {
        let mut from = from?;
        if let Some(first) = first {
            return Some((first, (None, Some(from), to)));
        }
        let event = next(&mut from).await;
        let from = match event {
            PortEvent::End { .. } => None,
            _ => Some(from),
        };
        Some((event, (None, from, to)))
    });
    let lines = events.map(|event| {
        let mut line = serde_json::to_vec(&event).map_err(io::Error::other)?;
        line.push(b'\n');
        Ok::<_, io::Error>(line)
    });
    let kind = [(CONTENT_TYPE, "application/jsonl")];
    Ok((kind, Body::from_stream(lines)).into_response())
}

async fn next(from: &mut Reader) -> PortEvent {
    match from.next().await {
        Ok(Came::Sample(sample, payload)) => PortEvent::Sample {
            time: Timestamp::from_nanosecond(sample.time.into())
                .unwrap_or_default()
                .to_string(),
            missed: sample.missed,
            size: payload.len() as u64,
            data: (payload.len() <= MAX_SHOWN).then(|| BASE64_STANDARD.encode(&payload)),
        },
        Ok(Came::End(end)) => PortEvent::End {
            reason: why(end).unwrap_or_else(|| "the manager ended it".to_owned()),
        },
        Err(e) => PortEvent::End {
            reason: format!("the connection to its manager was lost: {e}"),
        },
    }
}

fn why(end: TapEnd) -> Option<String> {
    end.failure.map(|failure| failure.message)
}

/// Writes samples to an in-port: JSON Lines of InjectLine, for as long as the client sends. Answered when the component has
/// read all of them, or the time for that is over.
#[utoipa::path(
    post,
    path = paths::SAMPLES,
    params(
        ("instance" = String, Path, description = "instance name"),
        ("port" = String, Path, description = "bare name of an in-port"),
        ("dataType" = String, Query, description = "IDL repository id of the samples"),
        ("waitMs" = Option<u64>, Query, description = "how long a sample waits for room; with 0 the oldest goes for it"),
        ("lingerMs" = Option<u64>, Query, description = "how long the last samples may wait to be read")
    ),
    request_body(content = InjectLine, content_type = "application/jsonl"),
    responses(
        (status = 200, body = Injected),
        (status = 400, description = "bad-request: a line is no InjectLine", body = Problem),
        (status = 404, description = "not-found: component or in-port", body = Problem),
        (status = 409, description = "manager-conflict: too many are written to", body = Problem),
        (status = 422, description = "manager-invalid: another data type", body = Problem),
        (status = 501, description = "upgrade: the manager is of an older version", body = Problem),
        (status = 503, description = "manager-silent", body = Problem)
    )
)]
pub(super) async fn inject(
    principal: Principal,
    State(agent): Shared,
    Path((instance, port)): Path<(String, String)>,
    Query(query): Query<InjectQuery>,
    body: Body,
) -> Answer<Json<Injected>> {
    let way = TapWay::Inject {
        data_type: query.data_type,
        wait_ms: query.wait_ms,
        linger_ms: query.linger_ms,
    };
    let tap = agent.tap(&instance, &port, way).await?;
    tracing::info!(
        target: "audit",
        uid = principal.uid,
        pid = principal.pid,
        verb = "inject",
        object = format!("component/{instance}.{port}"),
    );
    let Tap {
        mut from, mut to, ..
    } = tap;
    let mut lines = Lines::new(
        body.into_data_stream()
            .map(|chunk| chunk.map_err(|e| e.to_string())),
    );
    let sent = async {
        while let Some(line) = lines.next().await {
            // One that breaks off is no end: the client has gone.
            let line = line.map_err(|e| Problem::bad_request(e.to_string()))?;
            let sample = sample(&line)?;
            // Why it takes no more, the manager says itself.
            if to.send(&sample).await.is_err() {
                return Ok(());
            }
        }
        // As above.
        let _ = to.end().await;
        Ok::<_, Problem>(())
    };
    let lost = |e: io::Error| {
        let detail = format!("the connection to the manager of {instance} was lost: {e}");
        Problem::unavailable("manager-silent", detail)
    };
    let end = from.end();
    tokio::pin!(sent, end);
    let end = tokio::select! {
        biased;
        end = &mut end => end,
        sent = &mut sent => {
            sent?;
            end.await
        }
    };
    let end = end.map_err(lost)?;
    Ok(Json(Injected {
        taken: end.taken,
        read: end.read,
        dropped: end.dropped,
        ended: why(end),
    }))
}

fn sample(line: &str) -> Result<Vec<u8>, Problem> {
    let line: InjectLine = serde_json::from_str(line)
        .map_err(|e| Problem::bad_request(format!("a line is no sample: {e}")))?;
    let sample = BASE64_STANDARD
        .decode(line.data)
        .map_err(|e| Problem::bad_request(format!("the data of a sample is no base64: {e}")))?;
    if sample.len() > MAX_SAMPLE {
        let detail = format!("a sample of {} bytes is too long", sample.len());
        return Err(Problem::bad_request(detail));
    }
    Ok(sample)
}
