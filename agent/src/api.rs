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
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

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

fn documented() -> OpenApiRouter<Arc<Agent>> {
    OpenApiRouter::with_openapi(Doc::openapi())
        .routes(routes!(health::livez))
        .routes(routes!(health::readyz))
        .routes(routes!(node::node))
        .routes(routes!(node::inventory))
        .routes(routes!(node::node_spec, node::put_node_spec))
        .routes(routes!(node::resolve))
        .routes(routes!(node::log))
        .routes(routes!(ports::samples, ports::inject))
        .routes(routes!(batches::run_batch))
        .routes(routes!(batches::release))
        .routes(routes!(bindings::bind))
        .routes(routes!(managers::load_module))
        .routes(routes!(managers::unload_module))
        .routes(routes!(managers::factories))
        .routes(routes!(managers::create_component))
        .routes(routes!(managers::delete_component))
        .routes(routes!(acts::act))
        .routes(routes!(timings::timings))
}

/// The description of the API.
pub(crate) fn openapi() -> utoipa::openapi::OpenApi {
    documented().into_openapi()
}

/// The whole service.
pub(crate) fn router(agent: Arc<Agent>) -> Router {
    // The description is made anew for whoever asks for it: it is larger than all else that an idle agent holds.
    let (router, _) = documented().split_for_parts();
    router
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
