//! Changes by hand of what runs: passed on to the agent of the node.

use axum::extract::State;
use rts_agent_api::messages::{Act, ActRequest, Acted};
use rts_controller_api::Problem;
use rts_http::server::{Json, Principal};

use super::audit::audit;
use super::extract::Segments;
use super::managers::{ask, change};
use super::{Answer, App};
use crate::publish::drift::fate;
use crate::view::Happening;

/// Changes by hand what runs on a node. What becomes of it is up to `rtsctl.drift` of the component.
#[utoipa::path(
    post, path = "/v1/nodes/{node}/acts", params(("node" = String, Path,)),
    request_body = ActRequest,
    responses(
        (status = 200, body = Acted), (status = 404, body = Problem), (status = 409, body = Problem),
        (status = 422, body = Problem), (status = 503, body = Problem)
    )
)]
pub async fn act(
    State(app): State<App>,
    principal: Principal,
    Segments(node): Segments<String>,
    Json(request): Json<ActRequest>,
) -> Answer<Json<Acted>> {
    if request.dry_run {
        let answer = ask(&app, &node, async |agent| agent.act(&request).await);
        return Ok(Json(answer.await?));
    }
    let instance = request.act.instance();
    audit(&principal, "act-by-hand", &format!("component/{instance}"));
    let answer = change(&app, &node, async |agent| agent.act(&request).await);
    let acted = answer.await?;
    if acted.changed {
        app.core.record(event(&request.act, &acted, principal.uid));
    }
    Ok(Json(acted))
}

fn event(act: &Act, acted: &Acted, uid: u32) -> Happening {
    let fate = acted.policy.map(|policy| format!("; it {}", fate(policy)));
    let fate = fate.unwrap_or_default();
    let message = format!("{} by uid {uid}{fate}", what(act));
    Happening::normal("ChangedByHand", &acted.target, message).of(acted.system.as_deref())
}

/// What was done, as a person says it.
fn what(act: &Act) -> String {
    match act {
        Act::Activate { .. } => "activated".to_owned(),
        Act::Deactivate { .. } => "deactivated".to_owned(),
        Act::Reset { .. } => "reset".to_owned(),
        Act::Configure {
            set,
            values,
            active,
            ..
        } => {
            let set = set.as_ref().map(|set| format!("{set}."));
            let set = set.unwrap_or_default();
            let values = values
                .iter()
                .map(|(name, value)| format!("{set}{name}={value}"));
            let active = active.iter().map(|active| format!("active set {active}"));
            let all: Vec<String> = values.chain(active).collect();
            format!("configured ({})", all.join(", "))
        }
        Act::Connect { source, target, .. } => format!("{source} connected with {target}"),
        Act::Disconnect { connector, .. } => format!("{connector} disconnected"),
    }
}
