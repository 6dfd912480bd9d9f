//! `/livez`, `/readyz`, `/metrics`.

use axum::extract::State;
use axum::http::header;
use axum::response::IntoResponse;
use rts_controller_api::Problem;
use rts_controller_api::objects::{Component, Node, Phase, System};
use rts_http::server::Principal;
use serde::Deserialize;

use super::extract::Params;
use super::{Answer, App};
use crate::metrics::Gauge;

/// Query of `/readyz`.
#[derive(Debug, Deserialize)]
pub struct Verbose {
    /// Present: list the checks.
    verbose: Option<String>,
}

/// The program runs.
#[utoipa::path(get, path = "/livez", responses((status = 200, body = String)))]
pub async fn livez(_: Principal) -> &'static str {
    "ok"
}

/// The program serves. `?verbose` lists the checks.
#[utoipa::path(
    get, path = "/readyz", params(("verbose" = Option<String>, Query,)),
    responses((status = 200, body = String), (status = 503, body = Problem))
)]
pub async fn readyz(
    State(app): State<App>,
    _: Principal,
    Params(query): Params<Verbose>,
) -> Answer<String> {
    let store = match app.core.store.check().await {
        Ok(()) => Ok(()),
        Err(e) => Err(crate::chain(&e)),
    };
    let looked = match app.core.metrics.reconciles() {
        0 => Err("the first round is not over".to_owned()),
        _ => Ok(()),
    };
    let checks = [("store", store), ("reconcile", looked)];
    let mut page = String::new();
    for (name, result) in checks {
        if let Err(why) = result {
            return Err(Problem::unavailable("not-ready", format!("check {name}: {why}")).into());
        }
        page.push_str(&format!("[+]{name} ok\n"));
    }
    Ok(match query.verbose {
        None => "ok".to_owned(),
        Some(_) => page + "readyz check passed\n",
    })
}

/// Numbers in the Prometheus text format.
#[utoipa::path(get, path = "/metrics", responses((status = 200, body = String)))]
pub async fn metrics(State(app): State<App>, _: Principal) -> impl IntoResponse {
    let view = &app.core.view;
    let systems = view.list::<System>().items.into_iter();
    let phases = systems.map(|system| {
        let phase = match system.status.phase {
            Phase::Progressing => "Progressing",
            Phase::Converged => "Converged",
            Phase::Degraded => "Degraded",
            Phase::Terminating => "Terminating",
        };
        phase.to_owned()
    });
    let nodes = view.list::<Node>().items.into_iter();
    let components = view.list::<Component>().items.into_iter();
    let page = app.core.metrics.page(&[
        Gauge::by_state("rtsctl_systems", "Systems by phase.", phases),
        Gauge::by_state(
            "rtsctl_nodes",
            "Nodes by state.",
            nodes.map(|n| n.status.state),
        ),
        Gauge::by_state(
            "rtsctl_components",
            "Components by state.",
            components.map(|c| c.status.state),
        ),
    ]);
    ([(header::CONTENT_TYPE, "text/plain; version=0.0.4")], page)
}
