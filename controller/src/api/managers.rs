//! The manager service, passed on to the node's agent. What is made by hand is shown as drift.

use axum::extract::State;
use axum::http::StatusCode;
use rts_agent_api::ClientError;
use rts_agent_api::client::HttpAgent;
use rts_agent_api::messages::{CreateByHand, CreatedByHand, Factory, ModuleRequest};
use rts_controller_api::Problem;
use rts_http::server::{Json, Principal};

use super::audit::audit;
use super::extract::Segments;
use super::{Answer, App, of_agent};
use crate::fleet::http_agent;
use crate::sessions::Lost;

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
    let answer = change(&app, &node, async |agent| {
        agent.load_module(&name, &request).await
    });
    Ok(Json(answer.await?))
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
    let answer = change(&app, &node, async |agent| {
        agent.unload_module(&name, &type_name).await
    });
    answer.await?;
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
    let answer = ask(&app, &node, async |agent| agent.factories(&name).await);
    Ok(Json(answer.await?))
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
    let answer = change(&app, &node, async |agent| {
        agent.create(&name, &request).await
    });
    Ok(Json(answer.await?))
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
    let answer = change(&app, &node, async |agent| {
        agent.delete_component(&name, &instance).await
    });
    answer.await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Asks the agent of a node; its loss, or the time-out of its client, ends that.
pub async fn ask<T>(
    app: &App,
    node: &str,
    work: impl AsyncFnOnce(&HttpAgent) -> Result<T, ClientError>,
) -> Result<T, Problem> {
    let agent = agent(app, node)?;
    let sessions = &app.core.sessions;
    let session = sessions
        .get(node)
        .map_or_else(String::new, |e| e.session.id);
    match sessions.while_live(node, &session, work(&agent)).await {
        Ok(answer) => answer.map_err(|e| of_agent(node, e)),
        Err(Lost) => Err(Problem::unavailable(
            "agent-unreachable",
            format!("the agent of node {node} was lost; whether it still did it is unknown"),
        )),
    }
}

/// The same for what changes the node: what was told of it before is then of yesterday.
pub async fn change<T>(
    app: &App,
    node: &str,
    work: impl AsyncFnOnce(&HttpAgent) -> Result<T, ClientError>,
) -> Result<T, Problem> {
    let answer = ask(app, node, work).await;
    app.core.sessions.doubt(node);
    app.core.wake.notify_one();
    answer
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
