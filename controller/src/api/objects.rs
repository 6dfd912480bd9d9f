//! Lists, watches and single objects.

use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use rts_agent_api::messages::LogQuery;
use rts_controller_api::Problem;
use rts_controller_api::objects::{Component, Connector, Event, Kind, List, Manager, Node, System};
use rts_controller_api::watch::WatchEvent;
use rts_http::server::{Json, Principal};
use serde::Deserialize;

use super::extract::{Params, Segments};
use super::pass::{opened, pass_on};
use super::{Answer, App, managers, watch};
use crate::view::{Resource, key};

/// Query of a list.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ListQuery {
    /// Watch rather than list.
    watch: Option<String>,
    /// Version to watch from; none begins with all objects as they are.
    resource_version: Option<String>,
}

macro_rules! collection {
    ($(#[$doc:meta])* $name:ident, $kind:ident, $path:literal, fresh: $fresh:literal) => {
        $(#[$doc])*
        #[utoipa::path(
            get, path = $path,
            params(
                ("watch" = Option<bool>, Query, description = "Watch: answers with server-sent events"),
                ("resourceVersion" = Option<String>, Query,
                    description = "Version to watch from; none begins with all objects and a bookmark"),
                ("Last-Event-ID" = Option<String>, Header,
                    description = "Last `id:` of a watch that is gone on with; goes before resourceVersion")
            ),
            responses(
                (status = 200, description = "The list, or the stream of its changes", content(
                    (List<$kind> = "application/json"), (WatchEvent<$kind> = "text/event-stream")
                )),
                (status = 410, description = "The version is too old, or from another store: list again", body = Problem),
                (status = 503, description = "Too many watches are open", body = Problem)
            )
        )]
        pub async fn $name(
            State(app): State<App>,
            _: Principal,
            headers: HeaderMap,
            Params(query): Params<ListQuery>,
        ) -> Answer<Response> {
            if wants_watch(&query)? {
                return from(&query, &headers).and_then(|from| watch::watch(&app, Kind::$kind, from));
            }
            if $fresh {
                app.core.refresh().await;
            }
            Ok(Json(list!(app, $kind)).into_response())
        }
    };
}

macro_rules! list {
    ($app:ident, Event) => {
        $app.core.view.events()
    };
    ($app:ident, $kind:ident) => {
        $app.core.view.list::<$kind>()
    };
}

collection!(
    /// All systems.
    systems, System, "/v1/systems", fresh: false
);
collection!(
    /// All nodes.
    nodes, Node, "/v1/nodes", fresh: false
);
collection!(
    /// All components, with counters as of now.
    components, Component, "/v1/components", fresh: true
);
collection!(
    /// All connectors, with counters as of now.
    connectors, Connector, "/v1/connectors", fresh: true
);
collection!(
    /// All managers.
    managers, Manager, "/v1/managers", fresh: true
);
collection!(
    /// The event log, oldest first.
    events, Event, "/v1/events", fresh: false
);

/// One node.
#[utoipa::path(
    get, path = "/v1/nodes/{name}", params(("name" = String, Path,)),
    responses(
        (status = 200, body = Node, headers(("ETag" = String, description = "The resourceVersion"))),
        (status = 404, body = Problem)
    )
)]
pub async fn node(
    State(app): State<App>,
    _: Principal,
    Segments(name): Segments<String>,
) -> Answer<Response> {
    one::<Node>(&app, &name, || format!("node {name}"))
}

/// A component at its stable address.
#[utoipa::path(
    get, path = "/v1/components/{node}/{instance}",
    params(("node" = String, Path,), ("instance" = String, Path,)),
    responses(
        (status = 200, body = Component, headers(("ETag" = String, description = "The resourceVersion"))),
        (status = 404, body = Problem)
    )
)]
pub async fn component(
    State(app): State<App>,
    _: Principal,
    Segments((node, instance)): Segments<(String, String)>,
) -> Answer<Response> {
    app.core.refresh().await;
    one::<Component>(&app, &key(&instance, &node), || {
        format!("component {instance} on node {node}")
    })
}

/// A component's log as its agent sends it; what breaks there breaks off here.
#[utoipa::path(
    get, path = "/v1/components/{node}/{instance}/log",
    params(
        ("node" = String, Path,), ("instance" = String, Path,),
        ("tail" = Option<usize>, Query, description = "Lines from the end, at most 10000; none for 200, or for all with since or previous"),
        ("follow" = Option<bool>, Query, description = "Stay, and send what is added, across rotations and restarts"),
        ("previous" = Option<bool>, Query, description = "Of the incarnation before the newest only; not with follow"),
        ("since" = Option<String>, Query, description = "Only lines from this time on, RFC 3339")
    ),
    responses(
        (status = 200, body = String, content_type = "text/plain"),
        (status = 400, body = Problem),
        (status = 404, description = "not-found, no-previous", body = Problem),
        (status = 503, body = Problem)
    )
)]
pub async fn log(
    State(app): State<App>,
    _: Principal,
    Segments((node, instance)): Segments<(String, String)>,
    Params(query): Params<LogQuery>,
) -> Answer<Response> {
    let permit = if query.follow {
        Some(watch::permit(&app)?)
    } else {
        None
    };
    let agent = managers::agent(&app, &node)?;
    let log = opened(&node, agent.stream_log(&instance, &query)).await?;
    Ok(pass_on(&app, log, permit, "text/plain; charset=utf-8"))
}

/// One connector.
#[utoipa::path(
    get, path = "/v1/connectors/{system}/{name}",
    params(("system" = String, Path,), ("name" = String, Path,)),
    responses(
        (status = 200, body = Connector, headers(("ETag" = String, description = "The resourceVersion"))),
        (status = 404, body = Problem)
    )
)]
pub async fn connector(
    State(app): State<App>,
    _: Principal,
    Segments((system, name)): Segments<(String, String)>,
) -> Answer<Response> {
    app.core.refresh().await;
    one::<Connector>(&app, &key(&name, &system), || {
        format!("connector {name} of system {system}")
    })
}

/// One manager.
#[utoipa::path(
    get, path = "/v1/managers/{node}/{name}",
    params(("node" = String, Path,), ("name" = String, Path,)),
    responses(
        (status = 200, body = Manager, headers(("ETag" = String, description = "The resourceVersion"))),
        (status = 404, body = Problem)
    )
)]
pub async fn manager(
    State(app): State<App>,
    _: Principal,
    Segments((node, name)): Segments<(String, String)>,
) -> Answer<Response> {
    app.core.refresh().await;
    one::<Manager>(&app, &key(&name, &node), || {
        format!("manager {name} on node {node}")
    })
}

/// An object with its version as ETag.
pub fn with_etag<T: Resource>(object: T) -> Response {
    let tag = format!("\"{}\"", object.metadata().resource_version);
    let mut response = Json(object).into_response();
    if let Ok(tag) = HeaderValue::from_str(&tag) {
        response.headers_mut().insert(header::ETAG, tag);
    }
    response
}

fn one<T: Resource>(app: &App, key: &str, what: impl FnOnce() -> String) -> Answer<Response> {
    let object = app.core.view.get::<T>(key);
    let object = object.ok_or_else(|| Problem::not_found(format!("there is no {}", what())))?;
    Ok(with_etag(object))
}

/// `watch=true` and `watch=1`, as Kubernetes takes them.
fn wants_watch(query: &ListQuery) -> Answer<bool> {
    match query.watch.as_deref() {
        None | Some("false" | "0") => Ok(false),
        Some("true" | "1" | "") => Ok(true),
        Some(other) => Err(Problem::bad_request(format!(
            "watch={other} is not understood: write watch=true or watch=false"
        ))
        .into()),
    }
}

/// The version to watch from: `Last-Event-ID` of a reader that comes back, else the query's.
fn from(query: &ListQuery, headers: &HeaderMap) -> Answer<Option<u64>> {
    let last = headers
        .get("last-event-id")
        .map(|id| id.to_str().unwrap_or("?"));
    let Some(text) = last.or(query.resource_version.as_deref()) else {
        return Ok(None);
    };
    match text.parse() {
        Ok(version) => Ok(Some(version)),
        Err(_) => Err(Problem::bad_request(format!("{text:?} is no version")).into()),
    }
}
