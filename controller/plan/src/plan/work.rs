//! What a step does.

use rts_schemas::stand_in::Shape;
use rts_schemas::system::{
    Configuration, ExecutionKind, OnDisconnect, Realtime, SharedExecutionContext,
};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::desired::{ManagerKey, PlacedConnector};

/// What a step does. Every value that an executor needs is here.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all_fields = "camelCase")]
pub enum Work {
    /// Make sure that the module of a type is on the node.
    Install {
        /// Type name.
        type_name: String,
        /// SHA-256 that the file must have, when it was pinned.
        module_digest: Option<String>,
    },
    /// Start a manager process.
    StartManager {
        /// Which one.
        manager: ManagerKey,
    },
    /// Open a module in a manager.
    LoadModule {
        /// Where.
        manager: ManagerKey,
        /// Type name.
        type_name: String,
        /// SHA-256 that the file must have, when it was pinned.
        module_digest: Option<String>,
    },
    /// Create and initialise a component with its configuration; it ends Inactive.
    Create {
        /// Where.
        manager: ManagerKey,
        /// Instance name.
        instance: String,
        /// Type name.
        type_name: String,
        /// Kept with the component and reported back.
        recreate_hash: String,
        /// Configuration to start with.
        configuration: Configuration,
        /// Kind of its execution context.
        execution_kind: ExecutionKind,
        /// Rate in Hz; `None` leaves the module's default.
        rate: Option<f64>,
        /// The execution context that it shares; none for its own.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        execution_context: Option<SharedExecutionContext>,
        /// What it does by itself when a peer is lost.
        #[serde(default)]
        on_disconnect: OnDisconnect,
        /// What is made in its place; none for the component itself.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        stand_in: Option<Shape>,
        /// What its execution context is to have of its node; none for nothing of its own.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        realtime: Option<Realtime>,
    },
    /// Set configuration values, the active set and the rate of a component in place.
    Configure {
        /// Where.
        manager: ManagerKey,
        /// Instance name.
        instance: String,
        /// Values and active set to set; what is not named stays.
        configuration: Configuration,
        /// Rate in Hz; `None` leaves it.
        rate: Option<f64>,
        /// What it does by itself when a peer is lost; `None` leaves it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        on_disconnect: Option<OnDisconnect>,
        /// Place in the order of its execution context; `None` leaves it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        order: Option<i32>,
    },
    /// Connect two ports. Carried out on the node of the source.
    Connect {
        /// The connector, with both ends' places.
        connector: PlacedConnector,
    },
    /// Activate a component.
    Activate {
        /// Where.
        manager: ManagerKey,
        /// Instance name.
        instance: String,
    },
    /// Deactivate a component.
    Deactivate {
        /// Where.
        manager: ManagerKey,
        /// Instance name.
        instance: String,
    },
    /// Take a component out of Error into Inactive.
    Reset {
        /// Where.
        manager: ManagerKey,
        /// Instance name.
        instance: String,
    },
    /// Remove a connector at its source.
    Disconnect {
        /// Manager of the source.
        manager: ManagerKey,
        /// Instance that owns it.
        instance: String,
        /// Connector name.
        connector: String,
    },
    /// Remove the end of a connector at an in-port, which no source is connected to.
    Unbind {
        /// Manager of the target.
        manager: ManagerKey,
        /// Instance with the in-port.
        instance: String,
        /// Connector name.
        connector: String,
    },
    /// Finalise and delete a component.
    Delete {
        /// Where.
        manager: ManagerKey,
        /// Instance name.
        instance: String,
    },
    /// Forget a module that no component uses any more.
    UnloadModule {
        /// Where.
        manager: ManagerKey,
        /// Type name.
        type_name: String,
    },
    /// Stop a manager process and wait until it and its group are gone.
    StopManager {
        /// Which one.
        manager: ManagerKey,
        /// The start that is meant: another one is left alone.
        incarnation: String,
    },
}

/// The process of a piece of work, borrowed as the work is.
macro_rules! manager {
    ($work:expr) => {
        match $work {
            Work::Install { .. } | Work::Connect { .. } => None,
            Work::StartManager { manager }
            | Work::LoadModule { manager, .. }
            | Work::UnloadModule { manager, .. }
            | Work::Create { manager, .. }
            | Work::Configure { manager, .. }
            | Work::Activate { manager, .. }
            | Work::Deactivate { manager, .. }
            | Work::Reset { manager, .. }
            | Work::Disconnect { manager, .. }
            | Work::Unbind { manager, .. }
            | Work::Delete { manager, .. }
            | Work::StopManager { manager, .. } => Some(manager),
        }
    };
}

impl Work {
    /// The process that it is done in; none for what concerns two, or none.
    pub fn manager(&self) -> Option<&ManagerKey> {
        manager!(self)
    }

    /// The same, to change it.
    pub fn manager_mut(&mut self) -> Option<&mut ManagerKey> {
        manager!(self)
    }

    /// Name of the kind, as in JSON.
    pub fn kind(&self) -> &'static str {
        match self {
            Work::Install { .. } => "Install",
            Work::StartManager { .. } => "StartManager",
            Work::LoadModule { .. } => "LoadModule",
            Work::Create { .. } => "Create",
            Work::Configure { .. } => "Configure",
            Work::Connect { .. } => "Connect",
            Work::Activate { .. } => "Activate",
            Work::Deactivate { .. } => "Deactivate",
            Work::Reset { .. } => "Reset",
            Work::Disconnect { .. } => "Disconnect",
            Work::Unbind { .. } => "Unbind",
            Work::Delete { .. } => "Delete",
            Work::UnloadModule { .. } => "UnloadModule",
            Work::StopManager { .. } => "StopManager",
        }
    }
}
