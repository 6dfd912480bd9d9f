//! The manager service, passed on to the node's agent. What is made by hand is shown as drift.

use axum::extract::State;
use axum::http::StatusCode;
use rts_agent_api::client::HttpAgent;
use rts_agent_api::messages::{CreateByHand, CreatedByHand, Factory, ModuleRequest};
use rts_controller_api::Problem;
use rts_http::server::{Json, Principal};

use super::audit::audit;
use super::extract::Segments;
use super::{Answer, App, of_agent};
use crate::fleet::http_agent;

/// Loads a module by hand.
#[utoipa::path(
    post, path = "/v1/managers/{node}/{name}/modules",
    params(("node" = String, Path,), ("name" = String, Path,)),
    request_body = ModuleRequest,
    responses((status = 200, body = Factory), (status = 404, body = Problem), (status = 503, body = Problem))
)]
pub async fn load(
    State(app): State<App>,
    principal: Principal,
    Segments((node, name)): Segments<(String, String)>,
    Json(request): Json<ModuleRequest>,
) -> Answer<Json<Factory>> {
    audit(&principal, "load-module", &format!("manager/{name}"));
    let answer = agent(&app, &node)?.load_module(&name, &request).await;
    app.core.wake.notify_one();
    Ok(Json(answer.map_err(|e| of_agent(&node, e))?))
}

/// Unloads a module.
#[utoipa::path(
    delete, path = "/v1/managers/{node}/{name}/modules/{type}",
    params(("node" = String, Path,), ("name" = String, Path,), ("type" = String, Path,)),
    responses((status = 204), (status = 404, body = Problem), (status = 409, body = Problem))
)]
pub async fn unload(
    State(app): State<App>,
    principal: Principal,
    Segments((node, name, type_name)): Segments<(String, String, String)>,
) -> Answer<StatusCode> {
    audit(&principal, "unload-module", &format!("manager/{name}"));
    let answer = agent(&app, &node)?.unload_module(&name, &type_name).await;
    app.core.wake.notify_one();
    answer.map_err(|e| of_agent(&node, e))?;
    Ok(StatusCode::NO_CONTENT)
}

/// Modules that a manager has opened.
#[utoipa::path(
    get, path = "/v1/managers/{node}/{name}/factories",
    params(("node" = String, Path,), ("name" = String, Path,)),
    responses((status = 200, body = Vec<Factory>), (status = 404, body = Problem))
)]
pub async fn factories(
    State(app): State<App>,
    _: Principal,
    Segments((node, name)): Segments<(String, String)>,
) -> Answer<Json<Vec<Factory>>> {
    let answer = agent(&app, &node)?.factories(&name).await;
    Ok(Json(answer.map_err(|e| of_agent(&node, e))?))
}

/// Creates a component by hand.
#[utoipa::path(
    post, path = "/v1/managers/{node}/{name}/components",
    params(("node" = String, Path,), ("name" = String, Path,)),
    request_body = CreateByHand,
    responses((status = 200, body = CreatedByHand), (status = 409, body = Problem), (status = 503, body = Problem))
)]
pub async fn create(
    State(app): State<App>,
    principal: Principal,
    Segments((node, name)): Segments<(String, String)>,
    Json(request): Json<CreateByHand>,
) -> Answer<Json<CreatedByHand>> {
    audit(&principal, "create-by-hand", &format!("manager/{name}"));
    let answer = agent(&app, &node)?.create(&name, &request).await;
    app.core.wake.notify_one();
    Ok(Json(answer.map_err(|e| of_agent(&node, e))?))
}

/// Deletes a component that was created by hand.
#[utoipa::path(
    delete, path = "/v1/managers/{node}/{name}/components/{instance}",
    params(("node" = String, Path,), ("name" = String, Path,), ("instance" = String, Path,)),
    responses((status = 204), (status = 404, body = Problem), (status = 409, body = Problem))
)]
pub async fn delete(
    State(app): State<App>,
    principal: Principal,
    Segments((node, name, instance)): Segments<(String, String, String)>,
) -> Answer<StatusCode> {
    audit(
        &principal,
        "delete-by-hand",
        &format!("component/{instance}"),
    );
    let answer = agent(&app, &node)?.delete_component(&name, &instance).await;
    app.core.wake.notify_one();
    answer.map_err(|e| of_agent(&node, e))?;
    Ok(StatusCode::NO_CONTENT)
}

/// The agent of a node that greeted.
pub fn agent(app: &App, node: &str) -> Result<HttpAgent, Problem> {
    let entry = app
        .core
        .sessions
        .get(node)
        .ok_or_else(|| Problem::not_found(format!("there is no node {node}")))?;
    if entry.lost {
        let detail = format!("node {node} is unknown: its agent sends no heartbeats");
        return Err(Problem::unavailable("agent-unreachable", detail));
    }
    http_agent(&entry.session.endpoint).map_err(|e| of_agent(node, e))
}
