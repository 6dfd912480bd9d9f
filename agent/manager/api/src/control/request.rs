//! What can be asked of a manager.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{ByHandInfo, RealtimeRequest, StandInShape, SystemId};

/// A request. Responses may come in another order than the requests.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Request {
    /// Chosen by the sender; repeated in the response.
    pub id: u64,
    /// The manager answers within this time, with an error if need be.
    pub deadline_ms: u64,
    /// What to do.
    pub body: RequestBody,
}

/// What to do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase", rename_all_fields = "camelCase")]
#[allow(
    clippy::large_enum_variant,
    reason = "there is one at a time, and it is never moved in a loop"
)]
pub enum RequestBody {
    /// Open a module. Answer: `Module`. Idempotent for the same path.
    LoadModule {
        /// Type name that its descriptor must have.
        type_name: String,
        /// Absolute path of the shared library.
        path: String,
        /// SHA-256 of the file, hexadecimal: kept and reported.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        digest: Option<String>,
    },
    /// Forget a module (its code stays mapped). Refused while a component uses it. Answer: `Done`.
    UnloadModule {
        /// Type name.
        type_name: String,
    },
    /// Describe the loaded modules. Answer: `Modules`.
    Factories,
    /// Create and initialise a component; it ends Inactive. Answer: `Created`.
    Create(CreateRequest),
    /// Set values, active set and rate in place. Answer: `Done`.
    Configure {
        /// Instance name.
        instance: String,
        /// Set → parameter → value; unnamed ones stay.
        sets: BTreeMap<String, BTreeMap<String, String>>,
        /// New active set.
        active: Option<String>,
        /// New rate in Hz.
        rate: Option<f64>,
        /// `keep`, `deactivate` or `stop` when a peer is lost; none leaves it. Since version 2.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        on_disconnect: Option<String>,
        /// New place in the order of a shared execution context; none leaves it. Since version 2.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        order: Option<i32>,
        /// Done by a person: the mark to keep and report ([`ByHandInfo`]). None: by the plan, which ends the mark.
        ///
        /// [`ByHandInfo`]: super::ByHandInfo
        #[serde(default, skip_serializing_if = "Option::is_none")]
        by_hand: Option<String>,
    },
    /// Let the named connector be bound to an in-port: a data connection that says otherwise is refused. Answer: `Bound`.
    Bind(Binding),
    /// Remove a binding and close its connection, which is no loss at this end. Answer: `Done`; also when there is none.
    Unbind {
        /// Connector name.
        connector: String,
    },
    /// Connect an out-port, here or over a socket. Answer: `Done` when the other end has agreed.
    Connect(ConnectRequest),
    /// Remove a connector at its out-port end, which is no loss there. Answer: `Done`; also when there is none.
    Disconnect {
        /// Instance that owns it.
        instance: String,
        /// Connector name.
        connector: String,
        /// Done by a person: the mark to keep and report until a connector of this name is made again. None: by the
        /// plan, which ends the mark.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        by_hand: Option<String>,
    },
    /// Activate. Answer: `Done` when it is Active. Refused (`ComponentFailed`) while `on_disconnect` is not `keep` and a
    /// connector is lost at this end, until it is connected again, disconnected here or unbound here.
    /// That counts for a connector that nobody wants any more, too: whoever gives orders removes it first.
    Activate {
        /// Instance name.
        instance: String,
    },
    /// Deactivate. Answer: `Done` when it is Inactive. A component in Error stays there and is no error here.
    Deactivate {
        /// Instance name.
        instance: String,
        /// Done by a person: the mark to keep and report until it is activated. None: by the plan.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        by_hand: Option<String>,
    },
    /// Error → Inactive. Answer: `Done`.
    Reset {
        /// Instance name.
        instance: String,
    },
    /// Run cycles of an Active component whose execution context is of the kind `other`. Answer: `Done` after the last.
    Tick {
        /// Instance name.
        instance: String,
        /// How many.
        cycles: u32,
    },
    /// Deactivate if need be, finalise, disconnect and delete. Answer: `Done`; also when there is none.
    Delete {
        /// Instance name.
        instance: String,
    },
    /// Forget marks of changes by hand where they are still these, since what was desired then is desired no more. Only for
    /// a manager that reports marks. Answer: `Done`; also when there is no such component.
    Forget {
        /// Instance name.
        instance: String,
        /// Marks of the component.
        by_hand: ByHandInfo,
        /// Marks of connectors that were made by hand, by connector name.
        connectors: BTreeMap<String, String>,
    },
    /// Everything that there is, counters included. Never waits for a component. Answer: `Inventory`.
    Inventory,
    /// Deactivate and finalise everything within the deadline, answer `Done`, and exit 0.
    Shutdown,
}

impl RequestBody {
    /// Without what a manager that speaks `version` does not know.
    #[must_use]
    pub fn for_version(mut self, version: u32) -> Self {
        if version >= 2 {
            return self;
        }
        match &mut self {
            Self::Configure {
                on_disconnect,
                order,
                by_hand,
                ..
            } => {
                *on_disconnect = None;
                *order = None;
                *by_hand = None;
            }
            Self::Create(CreateRequest {
                on_disconnect,
                realtime,
                execution_kind,
                ..
            }) => {
                *on_disconnect = None;
                *realtime = None;
                if execution_kind.is_empty() {
                    "periodic".clone_into(execution_kind);
                }
            }
            Self::LoadModule { digest, .. } => *digest = None,
            Self::Disconnect { by_hand, .. } | Self::Deactivate { by_hand, .. } => *by_hand = None,
            Self::Connect(request) => {
                request.by_hand = None;
                request.between_nodes = false;
            }
            _ => {}
        }
        self
    }
}

/// Arguments of `Create`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct CreateRequest {
    /// Instance name, unique in the manager.
    pub instance: String,
    /// Type name: of a loaded module, unless it is a stand-in.
    pub type_name: String,
    /// System that it is created for; none when made by hand.
    pub system: Option<SystemId>,
    /// Kept and reported back.
    pub recreate_hash: String,
    /// Kept and reported back.
    pub restarts: u32,
    /// Set → parameter → value, set before `on_initialize`.
    pub sets: BTreeMap<String, BTreeMap<String, String>>,
    /// Active set.
    pub active: Option<String>,
    /// `periodic`, `eventDriven` or `other` (driven from outside by `Tick`); empty for what the module wants. Since
    /// version 2 it may be empty.
    pub execution_kind: String,
    /// Rate in Hz; none for the module's default.
    pub rate: Option<f64>,
    /// Absolute path of the component's log; opened with O_APPEND.
    pub log_path: String,
    /// `keep` (default), `deactivate` or `stop` when a peer is lost. Since version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub on_disconnect: Option<String>,
    /// A stand-in is made, of this and without a module. Since version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stand_in: Option<StandInShape>,
    /// What its execution context is to have of the machine; none for nothing of its own. Since version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub realtime: Option<RealtimeRequest>,
    /// The execution context that it shares with others; none for one of its own. Since version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub execution_context: Option<Box<ExecutionContextRequest>>,
}

/// An execution context that components of one manager share.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ExecutionContextRequest {
    /// Its name.
    pub name: String,
    /// Place among its components: lower numbers run first, those with the same by name.
    #[serde(default)]
    pub order: i32,
    /// Name of the composite whose members share their state with it: an error of one is that of all, and they are
    /// deactivated and reset together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shared_state: Option<String>,
}

/// An in-port end that waits for its connector.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Binding {
    /// Connector name, unique in the system.
    pub connector: String,
    /// Instance with the in-port.
    pub instance: String,
    /// In-port.
    pub port: String,
    /// Source as `Instance.port`.
    pub source: String,
}

/// Arguments of `Connect`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ConnectRequest {
    /// Connector name.
    pub connector: String,
    /// Instance with the out-port, in this manager.
    pub instance: String,
    /// Out-port.
    pub port: String,
    /// Instance with the in-port.
    pub target_instance: String,
    /// In-port.
    pub target_port: String,
    /// Control socket of the target's manager; none when it is this one.
    pub target_socket: Option<String>,
    /// Incarnation that the target must have.
    pub target_incarnation: String,
    /// The target is on another node. Since version 2.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub between_nodes: bool,
    /// Connector properties, reported back.
    pub properties: BTreeMap<String, String>,
    /// Done by a person: reported back with the connector.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by_hand: Option<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_to_an_older_manager_has_no_newer_fields() {
        let configure = RequestBody::Configure {
            instance: "A".to_owned(),
            sets: BTreeMap::new(),
            active: None,
            rate: None,
            on_disconnect: Some("stop".to_owned()),
            order: Some(3),
            by_hand: Some("mark".to_owned()),
        };
        let text =
            |version| serde_json::to_string(&configure.clone().for_version(version)).unwrap();
        assert!(text(2).contains(r#""onDisconnect":"stop","order":3,"byHand":"mark""#));
        assert!(!text(1).contains("onDisconnect") && !text(1).contains("byHand"));
    }
}
