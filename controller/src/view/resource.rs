//! What each kind of object means by its key and by "only a counter changed".

use rts_controller_api::objects::{
    Component, ComponentStatus, Connector, ConnectorStatus, Kind, Manager, ManagerStatus, Metadata,
    Node, NodeStatus, Object, System, SystemStatus,
};
use serde::Serialize;

use super::change::Shown;
use super::weight::Weigh;
use super::{Table, Tables};

/// An object of the API.
pub trait Resource: Shown + Weigh + Serialize + Clone + PartialEq + 'static {
    /// Its kind.
    const KIND: Kind;
    /// Unique in its kind, and sorts by name.
    fn key(&self) -> String;
    /// Its metadata.
    fn metadata(&self) -> &Metadata;
    /// Its metadata.
    fn metadata_mut(&mut self) -> &mut Metadata;
    /// True when nothing but counters, heartbeats and ages differ.
    fn is_same(&self, other: &Self) -> bool;
    /// Where objects of this kind are kept.
    fn table(tables: &mut Tables) -> &mut Table<Self>;
}

/// Key of a component, connector or manager: its name, then its node or system.
pub fn key(name: &str, place: &str) -> String {
    format!("{name}\0{place}")
}

macro_rules! resource {
    ($type:ty, $status:ty, $kind:ident, $table:ident, |$object:ident| $key:expr, |$copy:ident| $blank:block) => {
        impl Resource for $type {
            const KIND: Kind = Kind::$kind;

            fn key(&self) -> String {
                let $object = self;
                $key
            }

            fn metadata(&self) -> &Metadata {
                let Object { metadata, .. } = self;
                metadata
            }

            fn metadata_mut(&mut self) -> &mut Metadata {
                &mut self.metadata
            }

            fn is_same(&self, other: &Self) -> bool {
                let blank = |status: &$status| {
                    #[allow(unused_mut)]
                    let mut $copy = status.clone();
                    $blank
                    $copy
                };
                // What was applied is never copied: it may be most of an object.
                self.metadata == other.metadata
                    && self.spec == other.spec
                    && (self.status == other.status || blank(&self.status) == blank(&other.status))
            }

            fn table(tables: &mut Tables) -> &mut Table<Self> {
                &mut tables.$table
            }
        }
    };
}

resource!(
    System,
    SystemStatus,
    System,
    systems,
    |o| o.metadata.name.clone(),
    |c| {}
);
resource!(
    Node,
    NodeStatus,
    Node,
    nodes,
    |o| o.metadata.name.clone(),
    |c| {
        c.last_seen = None;
    }
);
resource!(
    Component,
    ComponentStatus,
    Component,
    components,
    |o| key(&o.metadata.name, &o.status.node),
    |c| {
        c.executions = 0;
        c.timing = None;
    }
);
resource!(
    Connector,
    ConnectorStatus,
    Connector,
    connectors,
    |o| key(&o.metadata.name, &o.spec.system),
    |c| {
        c.samples_sent = 0;
        c.samples_received = 0;
        c.bytes = 0;
        c.drops = 0;
        c.gaps = 0;
        c.rate = 0;
        c.latency = None;
    }
);
resource!(
    Manager,
    ManagerStatus,
    Manager,
    managers,
    |o| key(&o.metadata.name, &o.status.node),
    |c| {
        c.activity = Default::default();
    }
);
