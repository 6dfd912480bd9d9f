//! The whole store as one document.

use axum::extract::State;
use rts_controller_api::Problem;
use rts_http::server::{Json, Principal};

use super::audit::audit;
use super::{Answer, App};
use crate::apply::of_store;
use crate::store::Backup;

/// A backup of the store, for `rtsctl controller restore`. Its checksum is over the text of `content` as it is sent.
#[utoipa::path(
    get, path = "/v1/backup",
    responses((status = 200, body = serde_json::Value), (status = 503, body = Problem))
)]
pub async fn backup(State(app): State<App>, principal: Principal) -> Answer<Json<Backup>> {
    audit(&principal, "backup", "store");
    let state = app.core.store.load().await.map_err(|e| of_store(&e))?;
    let backup = Backup::of(&state, app.core.clock.now());
    Ok(Json(backup.map_err(|e| Problem::internal(e.to_string()))?))
}
