//! `/livez`, `/readyz`, `/metrics`.

use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use rts_controller_api::Problem;
use rts_controller_api::objects::{Component, Connector, Node, Phase, System};
use rts_http::server::Principal;
use serde::Deserialize;

use super::extract::Params;
use super::{Answer, App};
use crate::metrics::{Gauge, components, connectors};

/// Query of `/livez` and `/readyz`.
#[derive(Debug, Deserialize)]
pub struct Verbose {
    /// Present: list the checks.
    verbose: Option<String>,
}

/// The program runs. `?verbose` lists the checks.
#[utoipa::path(
    get, path = "/livez", params(("verbose" = Option<String>, Query,)),
    responses(
        (status = 200, body = String, content_type = "text/plain"),
        (status = 400, body = Problem, content_type = "application/problem+json")
    )
)]
pub async fn livez(_: Principal, Params(query): Params<Verbose>) -> Answer<Response> {
    checked("livez", &query, vec![("ping", Ok(()))])
}

/// The program serves. `?verbose` lists the checks, also those that fail.
#[utoipa::path(
    get, path = "/readyz", params(("verbose" = Option<String>, Query,)),
    responses(
        (status = 200, body = String, content_type = "text/plain"),
        (status = 400, body = Problem, content_type = "application/problem+json"),
        (status = 503, content(
            (Problem = "application/problem+json"),
            (String = "text/plain")
        ))
    )
)]
pub async fn readyz(
    State(app): State<App>,
    _: Principal,
    Params(query): Params<Verbose>,
) -> Answer<Response> {
    let store = app.core.store.check().await;
    let looked = match app.core.metrics.reconciles() {
        0 => Err("the first round is not over".to_owned()),
        _ => Ok(()),
    };
    let checks = vec![
        ("ping", Ok(())),
        ("store", store.map_err(|e| rts_host::error::chain(&e))),
        ("reconcile", looked),
    ];
    checked("readyz", &query, checks)
}

/// The results as Kubernetes writes them.
fn checked(
    page: &str,
    query: &Verbose,
    checks: Vec<(&'static str, Result<(), String>)>,
) -> Answer<Response> {
    let failed = checks.iter().find_map(|(name, result)| {
        let why = result.as_ref().err()?;
        Some(format!("check {name}: {why}"))
    });
    let status = match failed {
        None => StatusCode::OK,
        Some(_) => StatusCode::SERVICE_UNAVAILABLE,
    };
    if query.verbose.is_none() {
        return match failed {
            None => Ok("ok".into_response()),
            Some(why) => Err(Problem::unavailable("not-ready", why).into()),
        };
    }
    let mut text = String::new();
    for (name, result) in checks {
        text.push_str(&match result {
            Ok(()) => format!("[+]{name} ok\n"),
            Err(why) => format!("[-]{name} failed: {why}\n"),
        });
    }
    let word = if failed.is_none() { "passed" } else { "failed" };
    text.push_str(&format!("{page} check {word}\n"));
    Ok((status, text).into_response())
}

/// Numbers in the Prometheus text format.
#[utoipa::path(get, path = "/metrics", responses((status = 200, body = String, content_type = "text/plain")))]
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
    let all = view.list::<Component>().items;
    let states = all.iter().map(|c| c.status.state.clone());
    let page = app.core.metrics.page(&[
        Gauge::by_state("rtsctl_systems", "Systems by phase.", phases),
        Gauge::by_state(
            "rtsctl_nodes",
            "Nodes by state.",
            nodes.map(|n| n.status.state),
        ),
        Gauge::by_state("rtsctl_components", "Components by state.", states),
    ]);
    let page = page + &components::families(&all);
    let page = page + &connectors::families(&view.list::<Connector>().items);
    ([(header::CONTENT_TYPE, "text/plain; version=0.0.4")], page)
}
