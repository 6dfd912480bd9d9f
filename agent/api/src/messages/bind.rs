//! Connectors between nodes: what the agent of the out-port asks the agent of the in-port.

use rts_plan::desired::{PlacedConnector, SystemRef};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Asks the agent of an in-port to let a connector come to it. Only one that its own NodeSpec holds is let in.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct BindRequest {
    /// System that the connector belongs to.
    pub system: SystemRef,
    /// The connector, with the places of its ends.
    pub connector: PlacedConnector,
}

/// An in-port expects its connector. Good for one connect: who asks later may be told something else.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Bound {
    /// Incarnation of the component with the in-port.
    pub incarnation: String,
    /// Unix socket at which its manager takes the connector.
    pub socket: String,
}
