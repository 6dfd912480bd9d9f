//! The HTTP API of an agent. Every handler takes a [`rts_http::server::Principal`].

mod acts;
mod batches;
mod bindings;
mod health;
mod managers;
mod node;
mod ports;
mod timings;

use std::sync::Arc;

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::routing::get;
use rts_http::problem::Problem;
use rts_http::server::{Json, Principal, ProblemResponse};
use utoipa::OpenApi;

use crate::agent::Agent;

/// Largest body of a request in bytes.
const MAX_BODY: usize = 64 * 1024 * 1024;

/// What handlers share.
type Shared = axum::extract::State<Arc<Agent>>;
/// What handlers return.
type Answer<T> = Result<T, ProblemResponse>;

#[derive(OpenApi)]
#[openapi(
    info(
        title = "rts-agent",
        description = "The agent of a node: takes its desired set, carries out batches, and says what really runs."
    ),
    components(schemas(
        rts_agent_api::messages::BatchEvent,
        rts_agent_api::messages::InjectLine,
        rts_agent_api::messages::PortEvent,
        Problem
    ))
)]
struct Doc;

rts_http::handlers! {
    Arc<Agent>, Doc::openapi();
    health::livez,
    health::readyz,
    node::node,
    node::inventory,
    node::node_spec,
    node::put_node_spec,
    node::resolve,
    node::log,
    ports::samples,
    ports::inject,
    batches::run_batch,
    batches::release,
    bindings::bind,
    managers::load_module,
    managers::unload_module,
    managers::factories,
    managers::create_component,
    managers::delete_component,
    acts::act,
    timings::timings,
}

/// The description of the API.
pub(crate) fn openapi() -> utoipa::openapi::OpenApi {
    documented()
}

/// The whole service.
pub(crate) fn router(agent: Arc<Agent>) -> Router {
    // The description is made anew for whoever asks for it: it is larger than all else that an idle agent holds.
    routes()
        .route(
            "/openapi.json",
            get(|_: Principal| async { Json(openapi()) }),
        )
        .fallback(no_such_path)
        .layer(DefaultBodyLimit::max(MAX_BODY))
        .with_state(agent)
}

async fn no_such_path(_: Principal, uri: axum::http::Uri) -> ProblemResponse {
    Problem::not_found(format!("the agent has no {}", uri.path())).into()
}
