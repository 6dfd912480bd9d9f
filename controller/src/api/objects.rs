//! Lists, watches and single objects.

use std::sync::Arc;

use axum::extract::State as Of;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use rts_agent_api::messages::LogQuery;
use rts_controller_api::Problem;
use rts_controller_api::objects::{
    Component, Connector, Event, Kind, List, Manager, Node, Object, System,
};
use rts_controller_api::watch::WatchEvent;
use rts_http::server::{Json, Principal};
use serde::{Deserialize, Serialize};

use super::extract::{Params, Segments};
use super::pass::{opened, pass_on};
use super::{Answer, App, managers, watch};
use crate::view::{Resource, State, key};

/// Query of a list.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ListQuery {
    /// Watch rather than list.
    watch: Option<String>,
    /// Version to watch from; none begins with all objects as they are.
    resource_version: Option<String>,
    /// False: objects without their spec.
    spec: Option<String>,
}

/// Query of a single object.
#[derive(Debug, Default, Deserialize)]
pub struct OneQuery {
    /// False: without its spec.
    spec: Option<String>,
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
                    description = "Last `id:` of a watch that is gone on with; goes before resourceVersion"),
                ("spec" = Option<bool>, Query,
                    description = "`false`: objects without their spec, for those who follow how they are")
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
            Of(app): Of<App>,
            _: Principal,
            headers: HeaderMap,
            Params(query): Params<ListQuery>,
        ) -> Answer<Response> {
            let with_spec = is_true("spec", query.spec.as_deref(), true)?;
            if is_true("watch", query.watch.as_deref(), false)? {
                let from = from(&query, &headers)?;
                return watch::watch(&app, Kind::$kind, from, with_spec);
            }
            if $fresh {
                app.core.refresh().await;
            }
            Ok(listed(list!(app, $kind), with_spec))
        }
    };
}

macro_rules! list {
    ($app:ident, Event) => {
        $app.core.view.shared_events()
    };
    ($app:ident, $kind:ident) => {
        $app.core.view.shared::<$kind>()
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
    Of(app): Of<App>,
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
    Of(app): Of<App>,
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
    Of(app): Of<App>,
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
    Of(app): Of<App>,
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
    Of(app): Of<App>,
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
    let version = object.metadata().resource_version.clone();
    tagged(&version, Json(object).into_response())
}

fn tagged(version: &str, mut response: Response) -> Response {
    let tag = format!("\"{version}\"");
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
fn is_true(key: &str, value: Option<&str>, else_: bool) -> Answer<bool> {
    match value {
        None => Ok(else_),
        Some("false" | "0") => Ok(false),
        Some("true" | "1" | "") => Ok(true),
        Some(other) => Err(Problem::bad_request(format!(
            "{key}={other} is not understood: write {key}=true or {key}=false"
        ))
        .into()),
    }
}

/// A list, whose objects are given with their spec or without.
fn listed<Spec: Serialize, Status: Serialize>(
    list: List<Arc<Object<Spec, Status>>>,
    with_spec: bool,
) -> Response {
    if with_spec {
        return Json(list).into_response();
    }
    let states = list.items.iter().map(|object| State::from(object.as_ref()));
    Json(List {
        items: states.collect(),
        api_version: list.api_version.clone(),
        kind: list.kind.clone(),
        metadata: list.metadata.clone(),
    })
    .into_response()
}

/// A system as it is, and without its spec where that is not asked for.
pub fn system_as_asked(system: System, query: &OneQuery) -> Answer<Response> {
    if is_true("spec", query.spec.as_deref(), true)? {
        return Ok(with_etag(system));
    }
    let state = Json(State::from(&system)).into_response();
    Ok(tagged(&system.metadata.resource_version, state))
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
