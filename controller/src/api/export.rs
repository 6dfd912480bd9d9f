//! A running system as what an apply would take.

use axum::extract::State;
use rts_controller_api::Problem;
use rts_controller_api::requests::Exported;
use rts_http::server::{Json, Principal};

use super::extract::Segments;
use super::{Answer, App};
use crate::export;

/// The stored system with what was changed by hand in it.
#[utoipa::path(
    get, path = "/v1/systems/{name}/export", params(("name" = String, Path,)),
    responses(
        (status = 200, body = Exported), (status = 404, body = Problem),
        (status = 409, description = "terminating", body = Problem)
    )
)]
pub async fn export(
    State(app): State<App>,
    _: Principal,
    Segments(name): Segments<String>,
) -> Answer<Json<Exported>> {
    Ok(Json(export::export(&app.core, &name).await?))
}
