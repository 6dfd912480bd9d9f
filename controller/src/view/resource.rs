//! What each kind of object means by its key and by "only a counter changed".

use std::collections::BTreeMap;

use rts_controller_api::objects::{
    Component, Connector, Kind, Manager, Metadata, Node, Object, System,
};
use serde::Serialize;

use super::Tables;

/// An object of the API.
pub trait Resource: Serialize + Clone + PartialEq {
    /// Its kind.
    const KIND: Kind;
    /// Unique in its kind, and sorts by name.
    fn key(&self) -> String;
    /// Its metadata.
    fn metadata(&self) -> &Metadata;
    /// Its metadata.
    fn metadata_mut(&mut self) -> &mut Metadata;
    /// A copy in which counters, heartbeats and ages are blank.
    fn without_counters(&self) -> Self;
    /// Where objects of this kind are kept.
    fn table(tables: &mut Tables) -> &mut BTreeMap<String, Self>;
}

/// Key of a component, connector or manager: its name, then its node or system.
pub fn key(name: &str, place: &str) -> String {
    format!("{name}\0{place}")
}

macro_rules! resource {
    ($type:ty, $kind:ident, $table:ident, |$object:ident| $key:expr, |$copy:ident| $blank:block) => {
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

            fn without_counters(&self) -> Self {
                #[allow(unused_mut)]
                let mut $copy = self.clone();
                $blank
                $copy
            }

            fn table(tables: &mut Tables) -> &mut BTreeMap<String, Self> {
                &mut tables.$table
            }
        }
    };
}

resource!(System, System, systems, |o| o.metadata.name.clone(), |c| {});
resource!(Node, Node, nodes, |o| o.metadata.name.clone(), |c| {
    c.status.last_seen = None;
});
resource!(
    Component,
    Component,
    components,
    |o| key(&o.metadata.name, &o.status.node),
    |c| {
        c.status.executions = 0;
        c.status.timing = None;
    }
);
resource!(
    Connector,
    Connector,
    connectors,
    |o| key(&o.metadata.name, &o.spec.system),
    |c| {
        let status = &mut c.status;
        status.samples_sent = 0;
        status.samples_received = 0;
        status.bytes = 0;
        status.drops = 0;
        status.gaps = 0;
        status.rate = 0;
        status.latency = None;
    }
);
resource!(
    Manager,
    Manager,
    managers,
    |o| key(&o.metadata.name, &o.status.node),
    |c| {
        c.status.activity = Default::default();
    }
);
