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
    routes()
        .fallback(nothing_here)
        .method_not_allowed_fallback(not_allowed)
        .layer(DefaultBodyLimit::max(MAX_BODY))
        .with_state(app)
}

/// The description of the API.
pub fn openapi() -> utoipa::openapi::OpenApi {
    document::finished(documented())
}

rts_http::handlers! {
    App, document::Document::openapi();
    objects::systems,
    objects::nodes,
    objects::components,
    objects::connectors,
    objects::managers,
    objects::events,
    systems::get,
    systems::put,
    systems::delete,
    systems::stored_plan,
    systems::plan,
    simulate::simulate,
    export::export,
    objects::node,
    claims::forget,
    objects::component,
    objects::log,
    ports::samples,
    ports::inject,
    objects::connector,
    objects::manager,
    managers::load,
    managers::unload,
    managers::factories,
    managers::create,
    managers::delete,
    acts::act,
    claims::adopt,
    claims::take_over,
    backup::backup,
    timings::timings,
    sessions::greet,
    sessions::heartbeat,
    health::livez,
    health::readyz,
    health::metrics,
    document::openapi,
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
