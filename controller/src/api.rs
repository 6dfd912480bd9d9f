//! The REST API: routes, and what every handler shares.

mod acts;
mod audit;
mod backup;
mod claims;
mod document;
mod export;
mod extract;
mod health;
mod managers;
mod objects;
mod pass;
mod ports;
mod sessions;
mod simulate;
mod systems;
mod timings;
mod watch;

use std::sync::Arc;

use axum::Router;
use axum::extract::{DefaultBodyLimit, Request};
use axum::http::Method;
use rts_controller_api::Problem;
use rts_http::server::ProblemResponse;
use tokio::sync::{Semaphore, watch as signal};
use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::core::Core;
use crate::greet::of_agent;

/// Largest body of a request in bytes.
const MAX_BODY: usize = 32 * 1024 * 1024;
/// Watches at once.
const MAX_WATCHES: usize = 256;

/// What handlers get.
#[derive(Clone)]
pub struct App {
    core: Arc<Core>,
    /// True once the program ends: watches end then.
    ending: signal::Receiver<bool>,
    watches: Arc<Semaphore>,
}

type Answer<T> = Result<T, ProblemResponse>;

/// The routes.
pub fn router(core: Arc<Core>, ending: signal::Receiver<bool>) -> Router {
    let app = App {
        core,
        ending,
        watches: Arc::new(Semaphore::new(MAX_WATCHES)),
    };
    // The document is made anew for whoever asks for it: it is larger than all else that an idle controller holds.
    let (router, _) = routes().split_for_parts();
    router
        .fallback(nothing_here)
        .method_not_allowed_fallback(not_allowed)
        .layer(DefaultBodyLimit::max(MAX_BODY))
        .with_state(app)
}

/// The description of the API.
pub fn openapi() -> utoipa::openapi::OpenApi {
    document::finished(routes().into_openapi())
}

fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::with_openapi(document::Document::openapi())
        .routes(routes!(objects::systems))
        .routes(routes!(objects::nodes))
        .routes(routes!(objects::components))
        .routes(routes!(objects::connectors))
        .routes(routes!(objects::managers))
        .routes(routes!(objects::events))
        .routes(routes!(systems::get, systems::put, systems::delete))
        .routes(routes!(systems::stored_plan, systems::plan))
        .routes(routes!(simulate::simulate))
        .routes(routes!(export::export))
        .routes(routes!(objects::node, claims::forget))
        .routes(routes!(objects::component))
        .routes(routes!(objects::log))
        .routes(routes!(ports::samples, ports::inject))
        .routes(routes!(objects::connector))
        .routes(routes!(objects::manager))
        .routes(routes!(managers::load))
        .routes(routes!(managers::unload))
        .routes(routes!(managers::factories))
        .routes(routes!(managers::create))
        .routes(routes!(managers::delete))
        .routes(routes!(acts::act))
        .routes(routes!(claims::adopt))
        .routes(routes!(claims::take_over))
        .routes(routes!(backup::backup))
        .routes(routes!(timings::timings))
        .routes(routes!(sessions::greet))
        .routes(routes!(sessions::heartbeat))
        .routes(routes!(health::livez))
        .routes(routes!(health::readyz))
        .routes(routes!(health::metrics))
        .routes(routes!(document::openapi))
}

async fn nothing_here(request: Request) -> ProblemResponse {
    let path = request.uri().path();
    Problem::not_found(format!("there is no {path}; /openapi.json lists all paths")).into()
}

async fn not_allowed(method: Method, request: Request) -> ProblemResponse {
    let path = request.uri().path();
    let detail = format!("{path} does not know {method}");
    Problem::new(405, "method-not-allowed", "method not allowed", detail).into()
}
