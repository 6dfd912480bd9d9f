//! How an agent greets its controller: a session, then heartbeats. The newest session of a node wins.

use std::time::Duration;

use futures_util::future::BoxFuture;
use reqwest::Method;
use rts_http::client::{Client, ClientError, segment};
use rts_plan::delta::InventoryDelta;
use rts_plan::observed::Inventory;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::messages::LedgerFence;

/// Time between two heartbeats.
pub const HEARTBEAT: Duration = Duration::from_secs(1);
/// A node without a heartbeat for this long is unknown.
pub const UNKNOWN_AFTER: Duration = Duration::from_secs(3);
/// Time for a controller to answer a heartbeat. A busy one answers late, and it helps nobody when it is asked again before.
pub const ANSWERED_WITHIN: Duration = UNKNOWN_AFTER;
/// Time for a controller to answer a greeting, which brings all that the node has.
const GREETED_WITHIN: Duration = Duration::from_secs(5);

/// `POST` on the controller: [`SessionGreeting`], [`SessionReply`] back.
pub const SESSIONS: &str = "/v1/nodes/{node}/sessions";
/// `POST` on the controller: [`Heartbeat`]. 404: greet again. 409: a newer session has taken over.
pub const HEARTBEATS: &str = "/v1/nodes/{node}/sessions/{session}/heartbeat";

/// First message of an agent.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct SessionGreeting {
    /// [`crate::PROTOCOL_VERSION`].
    pub protocol_version: u32,
    /// Program version.
    pub version: String,
    /// Unique id of this session.
    pub session: String,
    /// Unix socket on which the agent serves its API.
    pub endpoint: String,
    /// Names by which hosts in profiles may mean this node.
    pub aliases: Vec<String>,
    /// What its ledger holds, and so the generation that it applied last; none when it has none.
    pub ledger: Option<LedgerFence>,
    /// Everything that runs on it.
    pub inventory: Inventory,
    /// How the agent is reached, where it is not of the controller's machine. Said by whoever reached it, not by the agent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transport: Option<Transport>,
}

/// How a node of another machine is reached.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Transport {
    /// `ssh`.
    pub kind: String,
    /// Whom it leads to (`user@host`).
    pub destination: String,
    /// An agent lives there on its own, and heals the node also while nobody reaches it.
    pub resident: bool,
}

impl Transport {
    /// Reached by SSH, while a command needs it.
    pub const SSH: &str = "ssh";
}

/// Answer to a greeting.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct SessionReply {
    /// Uid of the controller's store.
    pub cluster_uid: String,
    /// Epoch of the controller's store.
    pub epoch: u64,
}

/// A sign of life.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Heartbeat {
    /// Revision of the agent's inventory: one that the controller cannot reach by `delta` makes it ask for all.
    pub inventory_revision: u64,
    /// What has changed since the last heartbeat that was accepted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delta: Option<InventoryDelta>,
    /// What happened since the last heartbeat that was accepted.
    #[serde(default)]
    pub events: Vec<AgentEvent>,
}

/// Something that an agent saw.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct AgentEvent {
    /// `Normal` or `Warning`, as in Kubernetes.
    #[serde(rename = "type")]
    pub kind: String,
    /// One CamelCase word (`ManagerDied`).
    pub reason: String,
    /// What it is about (`manager/hello.main`).
    pub object: String,
    /// System name, when it belongs to one.
    #[serde(default)]
    pub system: Option<String>,
    /// For people.
    pub message: String,
}

/// What an agent tells its controller. A simulation implements it too.
pub trait SessionApi: Send + Sync + 'static {
    /// Greets.
    fn greet<'a>(
        &'a self,
        greeting: &'a SessionGreeting,
    ) -> BoxFuture<'a, Result<SessionReply, ClientError>>;
    /// Sends a heartbeat.
    fn heartbeat<'a>(
        &'a self,
        session: &'a str,
        heartbeat: &'a Heartbeat,
    ) -> BoxFuture<'a, Result<(), ClientError>>;
}

/// The agent's side of a session.
#[derive(Debug, Clone)]
pub struct SessionClient {
    http: Client,
    node: String,
}

impl SessionClient {
    /// A client of the controller that listens on a socket.
    pub fn new(http: Client, node: impl Into<String>) -> Self {
        Self {
            http,
            node: node.into(),
        }
    }
}

impl SessionApi for SessionClient {
    fn greet<'a>(
        &'a self,
        greeting: &'a SessionGreeting,
    ) -> BoxFuture<'a, Result<SessionReply, ClientError>> {
        let path = SESSIONS.replace("{node}", &segment(&self.node));
        let http = self.http.within(GREETED_WITHIN);
        Box::pin(async move { http.send(Method::POST, &path, greeting).await })
    }

    fn heartbeat<'a>(
        &'a self,
        session: &'a str,
        heartbeat: &'a Heartbeat,
    ) -> BoxFuture<'a, Result<(), ClientError>> {
        let path = HEARTBEATS
            .replace("{node}", &segment(&self.node))
            .replace("{session}", &segment(session));
        let request = self.http.request(Method::POST, &path).json(heartbeat);
        Box::pin(async move { self.http.text(request).await.map(drop) })
    }
}
