//! Paths of the controller API. Lists and watches: [`objects`]; `?watch=true&resourceVersion=N` watches.

/// `GET`, `PUT` ([`crate::requests::ApplyRequest`] → [`crate::requests::ApplyResult`]), `DELETE`.
pub const SYSTEM: &str = "/v1/systems/{name}";
/// `GET`: plan of the stored system; `POST` ([`crate::requests::ApplyRequest`]): what an apply would do. Nothing changes.
pub const SYSTEM_PLAN: &str = "/v1/systems/{name}/plan";
/// `POST` ([`crate::simulate::SimulateRequest`] → [`crate::simulate::Simulated`]): what would happen under faults. Nothing
/// changes.
pub const SYSTEM_SIMULATE: &str = "/v1/systems/{name}/simulate";
/// `GET`: [`crate::requests::Exported`].
pub const SYSTEM_EXPORT: &str = "/v1/systems/{name}/export";
/// `POST` ([`rts_agent_api::messages::ActRequest`] → [`rts_agent_api::messages::Acted`]): a change by hand of what runs on
/// a node.
pub const NODE_ACTS: &str = "/v1/nodes/{node}/acts";
/// `GET`; `DELETE`: a node that is away is forgotten.
pub const NODE: &str = "/v1/nodes/{name}";
/// `POST`: what runs on a node of another controller becomes this one's.
pub const NODE_ADOPT: &str = "/v1/nodes/{node}/adopt";
/// `POST` ([`crate::requests::TakeOver`]): this controller's set replaces what a node runs for another.
pub const NODE_TAKE_OVER: &str = "/v1/nodes/{node}/take-over";
/// `GET`, query [`rts_agent_api::messages::TimingsQuery`]: [`rts_agent_api::messages::Timings`] of this program and all
/// nodes.
pub const TIMINGS: &str = "/v1/timings";
/// `GET`: the whole store as one document.
pub const BACKUP: &str = "/v1/backup";
/// `GET`: a component at its stable address.
pub const COMPONENT: &str = "/v1/components/{node}/{instance}";
/// `GET`, query [`rts_agent_api::messages::LogQuery`]: its log as text.
pub const COMPONENT_LOG: &str = "/v1/components/{node}/{instance}/log";
/// `GET`: what an out-port writes, as JSON Lines of [`rts_agent_api::messages::PortEvent`]. `POST`, query
/// [`rts_agent_api::messages::InjectQuery`]: JSON Lines of [`rts_agent_api::messages::InjectLine`] are written to an
/// in-port; [`rts_agent_api::messages::Injected`] back.
pub const PORT_SAMPLES: &str = "/v1/components/{node}/{instance}/ports/{port}/samples";
/// `GET`.
pub const CONNECTOR: &str = "/v1/connectors/{system}/{name}";
/// `GET`.
pub const MANAGER: &str = "/v1/managers/{node}/{name}";
/// `POST`: loads a module by hand. Starts a manager that no system owns when there is none of that name.
pub const MANAGER_MODULES: &str = "/v1/managers/{node}/{name}/modules";
/// `DELETE`: unloads a module.
pub const MANAGER_MODULE: &str = "/v1/managers/{node}/{name}/modules/{type}";
/// `GET`: modules that it has opened.
pub const MANAGER_FACTORIES: &str = "/v1/managers/{node}/{name}/factories";
/// `POST`: creates a component by hand.
pub const MANAGER_COMPONENTS: &str = "/v1/managers/{node}/{name}/components";
/// `DELETE`: deletes a component that was created by hand.
pub const MANAGER_COMPONENT: &str = "/v1/managers/{node}/{name}/components/{instance}";

/// Path of a kind's list: `/v1/systems`, `/v1/nodes`, …
pub fn objects(kind: crate::objects::Kind) -> String {
    format!("/v1/{}", kind.plural())
}
