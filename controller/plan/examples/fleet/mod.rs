//! Fleets to measure with: so many components on one node, ten in each process, each feeding the next five.

use std::collections::BTreeMap;

use rts_plan::desired::{Desired, ManagerKey, NodeSystem, PlacedComponent, SystemRef};
use rts_plan::observed::{
    BindingObserved, ByHand, ComponentObserved, ConnectorObserved, ConnectorState, Inventory,
    LifeCycleState, ManagerObserved, NodeObserved, Observed,
};
use rts_plan::{NodeFacts, StoredSystem, place};
use rts_schemas::system::{
    ComponentSpec, Configuration, ConnectorSpec, ExecutionContextSpec, ExecutionKind, Orders,
    Placement, Policy, PortKind, PortRef, SystemSpec,
};

/// Connectors that start at each component.
const CONNECTORS: usize = 5;
/// Components in each process.
const IN_PROCESS: usize = 10;
/// The one node.
const NODE: &str = "local";

/// What is planned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Case {
    /// Nothing runs yet.
    First,
    /// Everything runs as desired.
    NoOp,
    /// The same, but for one configuration value.
    OneChange,
}

impl Case {
    /// By its name on the command line.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "first" => Some(Self::First),
            "no-op" => Some(Self::NoOp),
            "one-change" => Some(Self::OneChange),
            _ => None,
        }
    }
}

/// Desired and observed state of so many components.
pub fn fleet(components: usize, case: Case) -> (Desired, Observed) {
    let mut system = system(components);
    let running = place(std::slice::from_ref(&system), &nodes(), NODE).desired;
    let observed = match case {
        Case::First => observed(&Desired::default()),
        Case::NoOp | Case::OneChange => observed(&running),
    };
    if case == Case::OneChange {
        let changed = &mut system.spec.components[components / 2].configuration;
        let values = changed.sets.entry("default".to_owned()).or_default();
        values.insert("gain".to_owned(), "2.0".to_owned());
    }
    (place(&[system], &nodes(), NODE).desired, observed)
}

fn nodes() -> [NodeFacts; 1] {
    [NodeFacts {
        name: NODE.to_owned(),
        aliases: Vec::new(),
    }]
}

fn instance(number: usize) -> String {
    format!("Filter{number}")
}

fn system(components: usize) -> StoredSystem {
    let spec = SystemSpec {
        composites: Vec::new(),
        name: "fleet".to_owned(),
        full_id: "RTSystem:rtsctl:fleet:1.0".to_owned(),
        components: (0..components).map(component).collect(),
        connectors: (0..components)
            .flat_map(|from| (1..=CONNECTORS).map(move |step| (from, step)))
            .map(|(from, step)| connector(from, (from + step) % components, step))
            .collect(),
        orders: Orders::default(),
    };
    StoredSystem {
        reference: SystemRef {
            name: "fleet".to_owned(),
            uid: "7d1b3ec4-8d8f-4f9e-9d55-1a8a3a0c2f11".to_owned(),
        },
        stand_ins: Default::default(),
        module_digests: BTreeMap::from([("LowPassFilter".to_owned(), "0".repeat(64))]),
        spec,
        deleting: false,
    }
}

fn component(number: usize) -> ComponentSpec {
    let values = BTreeMap::from([("gain".to_owned(), "1.0".to_owned())]);
    ComponentSpec {
        instance: instance(number),
        type_name: "LowPassFilter".to_owned(),
        full_id: "RTC:rtsctl:example:LowPassFilter:1.0".to_owned(),
        required: true,
        ports: Vec::new(),
        configuration: Configuration {
            active: None,
            sets: BTreeMap::from([("default".to_owned(), values)]),
        },
        execution_context: ExecutionContextSpec {
            rate: Some(100.0),
            ..ExecutionContextSpec::default()
        },
        placement: Placement {
            manager: Some(format!("m{}", number / IN_PROCESS)),
            ..Placement::default()
        },
        policy: Policy::default(),
        ..ComponentSpec::default()
    }
}

fn connector(from: usize, to: usize, step: usize) -> ConnectorSpec {
    let end = |number, port: String| PortRef {
        instance: instance(number),
        port,
    };
    let (source, target) = (end(from, "out".to_owned()), end(to, format!("in{step}")));
    ConnectorSpec {
        name: format!("{source}-{target}"),
        kind: PortKind::Data,
        source,
        target,
        data_type: Some("IDL:RTC/TimedDouble:1.0".to_owned()),
        properties: BTreeMap::from([("dataport.subscription_type".to_owned(), "flush".to_owned())]),
    }
}

/// A world in which everything is as desired.
fn observed(desired: &Desired) -> Observed {
    let parts = desired.nodes.get(NODE).into_iter().flat_map(|n| &n.systems);
    let inventory = Inventory {
        node: NODE.to_owned(),
        revision: 1,
        managers: parts.flat_map(managers).collect(),
        held: Vec::new(),
    };
    Observed {
        nodes: BTreeMap::from([(NODE.to_owned(), NodeObserved::Known(inventory.into()))]),
    }
}

fn managers(part: &NodeSystem) -> Vec<ManagerObserved> {
    let mut sources: BTreeMap<&str, Vec<ConnectorObserved>> = BTreeMap::new();
    let mut targets: BTreeMap<&str, Vec<BindingObserved>> = BTreeMap::new();
    for placed in &part.connectors {
        let spec = &placed.spec;
        let ends = targets.entry(spec.target.instance.as_str()).or_default();
        ends.push(BindingObserved {
            connector: spec.name.clone(),
            port: spec.target.port.clone(),
            source: Some(spec.source.clone()),
            connected: true,
            samples_received: 0,
            drops: 0,
            gaps: 0,
        });
        let own = sources.entry(spec.source.instance.as_str()).or_default();
        own.push(ConnectorObserved {
            name: spec.name.clone(),
            source: spec.source.clone(),
            target: spec.target.clone(),
            target_incarnation: format!("of {}", spec.target.instance),
            properties: spec.properties.clone(),
            by_hand: None,
            state: ConnectorState::Connected,
            transport: "direct".to_owned(),
            samples_sent: 0,
            samples_received: 0,
            bytes: 0,
            drops: 0,
            gaps: 0,
            rate: 0,
            latency: None,
        });
    }
    let mut managers: BTreeMap<&str, ManagerObserved> = BTreeMap::new();
    for placed in &part.components {
        let connectors = sources.remove(placed.spec.instance.as_str());
        let bindings = targets.remove(placed.spec.instance.as_str());
        let manager = managers
            .entry(&placed.manager)
            .or_insert_with(|| manager(&part.system, &placed.manager));
        let mut live = live(&part.system, placed, connectors.unwrap_or_default());
        live.bindings = bindings.unwrap_or_default();
        manager.modules.insert(live.type_name.clone());
        manager.components.push(live);
    }
    managers.into_values().collect()
}

fn manager(system: &SystemRef, name: &str) -> ManagerObserved {
    ManagerObserved {
        key: ManagerKey {
            system: Some(system.clone()),
            name: name.to_owned(),
        },
        incarnation: format!("of {name}"),
        pid: 1,
        started: String::new(),
        responsive: true,
        unseen: false,
        expired: None,
        modules: Default::default(),
        opened: Default::default(),
        components: Vec::new(),
        activity: Default::default(),
    }
}

fn live(
    system: &SystemRef,
    placed: &PlacedComponent,
    connectors: Vec<ConnectorObserved>,
) -> ComponentObserved {
    let spec = &placed.spec;
    ComponentObserved {
        instance: spec.instance.clone(),
        type_name: spec.type_name.clone(),
        system: Some(system.clone()),
        incarnation: format!("of {}", spec.instance),
        recreate_hash: placed.recreate_hash.clone(),
        stand_in: placed.stand_in.is_some(),
        state: LifeCycleState::Active,
        message: None,
        restarts: 0,
        created: String::new(),
        configuration: spec.configuration.clone(),
        defaults: BTreeMap::from([("gain".to_owned(), "1.0".to_owned())]),
        hangs: None,
        on_disconnect: spec.policy.on_disconnect,
        execution_kind: ExecutionKind::Periodic,
        execution_context: None,
        runs_with: Vec::new(),
        rate: spec.execution_context.rate.unwrap_or(1000.0),
        executions: 0,
        timing: None,
        realtime: None,
        ports: Vec::new(),
        connectors,
        bindings: Vec::new(),
        by_hand: ByHand::default(),
    }
}
