//! Changes by hand of what runs: passed on to the agent of the node.

use axum::extract::State;
use rts_agent_api::messages::{Act, ActRequest, Acted};
use rts_controller_api::Problem;
use rts_http::server::{Json, Principal};
use rts_plan::target;

use super::audit::{audit, ended};
use super::extract::Segments;
use super::managers::{ask, change};
use super::{Answer, App};
use crate::admit;
use crate::publish::drift::{fate, short};
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
    admit::act(&request.act)?;
    if request.dry_run {
        let answer = ask(&app, &node, async |agent| agent.act(&request).await);
        return Ok(Json(answer.await?));
    }
    let (verb, object) = names(&request.act);
    // Before it is tried, too: a client that goes away breaks it off, and nothing is told of its end then.
    audit(&principal, verb, &object);
    let answer = change(&app, &node, async |agent| agent.act(&request).await);
    let answer = answer.await;
    ended(&principal, verb, &object, &outcome(&answer));
    let acted = answer?;
    // A simulator may tick a thousand times in a second, and what is desired is not touched by it.
    if acted.changed && !matches!(request.act, Act::Tick { .. }) {
        app.core.record(event(&request.act, &acted, principal.uid));
    }
    Ok(Json(acted))
}

/// Verb and object of an audit line.
fn names(act: &Act) -> (&'static str, String) {
    let component = |instance: &String| target::component(instance);
    match act {
        Act::Activate { instance } => ("act-activate", component(instance)),
        Act::Deactivate { instance } => ("act-deactivate", component(instance)),
        Act::Reset { instance } => ("act-reset", component(instance)),
        Act::Tick { instance, cycles } => {
            ("act-tick", format!("{} ({cycles})", component(instance)))
        }
        Act::Configure { instance, .. } => ("act-configure", component(instance)),
        Act::Connect {
            source,
            target,
            name,
            ..
        } => {
            let ends = format!("{source}-{target}");
            let connector = target::connector(name.as_ref().unwrap_or(&ends));
            (
                "act-connect",
                format!("{connector} ({source} with {target})"),
            )
        }
        Act::Disconnect {
            instance,
            connector,
        } => {
            let connector = target::connector(connector);
            ("act-disconnect", format!("{connector} (of {instance})"))
        }
    }
}

fn outcome(answer: &Result<Acted, Problem>) -> String {
    match answer {
        Ok(acted) if acted.changed => "changed".to_owned(),
        Ok(_) => "nothing to change".to_owned(),
        Err(problem) => format!("{}: {}", problem.code, problem.detail),
    }
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
        Act::Tick { cycles, .. } => format!("ticked {cycles} times"),
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
                .map(|(name, value)| format!("{set}{name}={}", short(value)));
            let active = active.iter().map(|active| format!("active set {active}"));
            let all: Vec<String> = values.chain(active).collect();
            format!("configured ({})", all.join(", "))
        }
        Act::Connect { source, target, .. } => format!("{source} connected with {target}"),
        Act::Disconnect { connector, .. } => format!("{connector} disconnected"),
    }
}
