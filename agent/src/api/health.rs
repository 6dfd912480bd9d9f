//! Is it alive, is it ready.

use axum::extract::State;
use rts_http::server::Principal;

use super::Shared;

/// Answers when the process serves at all.
#[utoipa::path(get, path = "/livez", responses((status = 200, description = "it lives", body = String)))]
pub(super) async fn livez(_: Principal) -> &'static str {
    "ok"
}

/// Answers when the ledger is loaded and running managers were adopted, which is before the socket serves.
#[utoipa::path(get, path = "/readyz", responses((status = 200, description = "it is ready", body = String)))]
pub(super) async fn readyz(_: Principal, State(agent): Shared) -> String {
    let managers = agent.managers.all().len();
    format!("ok\nledger ok\nmanagers {managers}\n")
}
