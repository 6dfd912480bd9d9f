//! What unit tests of invariants let happen. The n-th thing of a list, from 0, happens at n seconds.

use std::collections::BTreeMap;
use std::time::Duration;

use rts_agent_api::messages::LedgerFence;
use rts_plan::desired::{ManagerKey, SystemRef};
use rts_schemas::system::{ComponentSpec, ConnectorSpec, PortKind, PortRef, SystemSpec};
use serde_json::json;

use crate::truth::{Cause, Happened, Subject, Witness};

pub fn see(witness: &mut dyn Witness, all: &[Happened]) {
    let mut at = Duration::ZERO;
    for what in all {
        witness.see(at, what);
        at += Duration::from_secs(1);
    }
}

fn reference() -> SystemRef {
    SystemRef {
        name: "hello".to_owned(),
        uid: "u1".to_owned(),
    }
}

pub fn main_manager() -> ManagerKey {
    ManagerKey {
        system: Some(reference()),
        name: "main".to_owned(),
    }
}

pub fn subject(instance: &str, node: &str, process: &str) -> Subject {
    Subject {
        node: node.to_owned(),
        manager: main_manager(),
        process: process.to_owned(),
        system: Some(reference()),
        instance: instance.to_owned(),
        incarnation: format!("{instance} in {process}"),
        recreate_hash: String::new(),
    }
}

pub fn created(of: &Subject) -> Happened {
    Happened::Created(of.clone())
}

pub fn deleted(of: &Subject, cause: Cause) -> Happened {
    Happened::Deleted(of.clone(), cause)
}

pub fn state(of: &Subject, from: &str, to: &str, cause: Cause) -> Happened {
    Happened::State {
        of: of.clone(),
        from: from.to_owned(),
        to: to.to_owned(),
        cause,
    }
}

pub fn activated(of: &Subject) -> Happened {
    state(of, "Inactive", "Active", Cause::Asked)
}

pub fn connected(of: &Subject, connector: &str) -> Happened {
    Happened::Connected {
        of: of.clone(),
        connector: connector.to_owned(),
    }
}

pub fn disconnected(of: &Subject, connector: &str, cause: Cause) -> Happened {
    Happened::Disconnected {
        of: of.clone(),
        connector: connector.to_owned(),
        cause,
    }
}

pub fn started(node: &str, process: &str) -> Happened {
    Happened::ProcessStarted {
        node: node.to_owned(),
        manager: main_manager(),
        process: process.to_owned(),
    }
}

pub fn ended(node: &str, process: &str, cause: Cause) -> Happened {
    Happened::ProcessEnded {
        node: node.to_owned(),
        manager: main_manager(),
        process: process.to_owned(),
        cause,
    }
}

pub fn blemished(process: &str, instance: Option<&str>) -> Happened {
    Happened::Blemished {
        node: "node1".to_owned(),
        process: process.to_owned(),
        instance: instance.map(str::to_owned),
        what: "hangs".to_owned(),
    }
}

pub fn fence(cluster: &str, epoch: u64, generation: u64, digest: &str) -> LedgerFence {
    LedgerFence {
        cluster_uid: cluster.to_owned(),
        epoch,
        generation,
        digest: digest.to_owned(),
    }
}

pub fn ledger_acked(fence: LedgerFence, systems: &[&str]) -> Happened {
    Happened::LedgerAcked {
        node: "node1".to_owned(),
        fence,
        systems: systems.iter().map(|uid| (*uid).to_owned()).collect(),
    }
}

pub fn ledger_read(fence: Option<LedgerFence>) -> Happened {
    Happened::LedgerRead {
        node: "node1".to_owned(),
        fence,
    }
}

pub fn desired_acked(generation: Option<u64>) -> Happened {
    Happened::DesiredAcked {
        system: "hello".to_owned(),
        generation,
    }
}

pub fn component(instance: &str) -> ComponentSpec {
    serde_json::from_value(json!({"instance": instance, "type": "Any"})).unwrap()
}

/// A system `hello` of these components.
pub fn hello(instances: &[&str]) -> SystemSpec {
    SystemSpec {
        composites: Vec::new(),
        name: "hello".to_owned(),
        full_id: String::new(),
        components: instances.iter().map(|name| component(name)).collect(),
        connectors: Vec::new(),
        orders: rts_schemas::system::Orders::default(),
    }
}

/// A connector between two of its components.
pub fn connector(name: &str, source: &str, target: &str) -> ConnectorSpec {
    let end = |instance: &str, port: &str| PortRef {
        instance: instance.to_owned(),
        port: port.to_owned(),
    };
    ConnectorSpec {
        name: name.to_owned(),
        kind: PortKind::Data,
        source: end(source, "out"),
        target: end(target, "in"),
        data_type: None,
        properties: BTreeMap::new(),
    }
}
