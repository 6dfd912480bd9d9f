//! The manager service for people, as OpenRTM's manager has it.

use axum::extract::{Path, State};
use axum::http::StatusCode;
use rts_agent_api::messages::{CreateByHand, CreatedByHand, Factory, ModuleRequest};
use rts_agent_api::paths;
use rts_http::problem::Problem;
use rts_http::server::{Json, Principal};

use super::{Answer, Shared};

/// Opens a module; starts the manager when it is not there.
#[utoipa::path(
    post,
    path = paths::MANAGER_MODULES,
    params(("manager" = String, Path, description = "manager name")),
    request_body = ModuleRequest,
    responses((status = 200, body = Factory), (status = 404, body = Problem), (status = 422, body = Problem))
)]
pub(super) async fn load_module(
    _: Principal,
    State(agent): Shared,
    Path(manager): Path<String>,
    Json(request): Json<ModuleRequest>,
) -> Answer<Json<Factory>> {
    Ok(Json(
        agent.load_by_hand(&manager, &request.type_name).await?,
    ))
}

/// Forgets a module.
#[utoipa::path(
    delete,
    path = paths::MANAGER_MODULE,
    params(
        ("manager" = String, Path, description = "manager name"),
        ("type" = String, Path, description = "type name")
    ),
    responses((status = 204, description = "forgotten"), (status = 404, body = Problem), (status = 409, body = Problem))
)]
pub(super) async fn unload_module(
    _: Principal,
    State(agent): Shared,
    Path((manager, type_name)): Path<(String, String)>,
) -> Answer<StatusCode> {
    agent.unload_by_hand(&manager, type_name).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Modules that a manager has opened.
#[utoipa::path(
    get,
    path = paths::MANAGER_FACTORIES,
    params(("manager" = String, Path, description = "manager name")),
    responses((status = 200, body = Vec<Factory>), (status = 404, body = Problem))
)]
pub(super) async fn factories(
    _: Principal,
    State(agent): Shared,
    Path(manager): Path<String>,
) -> Answer<Json<Vec<Factory>>> {
    Ok(Json(agent.factories(&manager).await?))
}

/// Creates a component that belongs to no system.
#[utoipa::path(
    post,
    path = paths::MANAGER_COMPONENTS,
    params(("manager" = String, Path, description = "manager name")),
    request_body = CreateByHand,
    responses((status = 200, body = CreatedByHand), (status = 404, body = Problem), (status = 409, body = Problem))
)]
pub(super) async fn create_component(
    _: Principal,
    State(agent): Shared,
    Path(manager): Path<String>,
    Json(wish): Json<CreateByHand>,
) -> Answer<Json<CreatedByHand>> {
    Ok(Json(agent.create_by_hand(&manager, wish).await?))
}

/// Deletes a component that belongs to no system.
#[utoipa::path(
    delete,
    path = paths::MANAGER_COMPONENT,
    params(
        ("manager" = String, Path, description = "manager name"),
        ("instance" = String, Path, description = "instance name")
    ),
    responses((status = 204, description = "deleted"), (status = 404, body = Problem), (status = 409, body = Problem))
)]
pub(super) async fn delete_component(
    _: Principal,
    State(agent): Shared,
    Path((manager, instance)): Path<(String, String)>,
) -> Answer<StatusCode> {
    agent.delete_by_hand(&manager, &instance).await?;
    Ok(StatusCode::NO_CONTENT)
}
