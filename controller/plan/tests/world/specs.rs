//! Systems to test with: the hello system, and random ones.

use std::collections::BTreeMap;

use proptest::prelude::*;
use rts_plan::StoredSystem;
use rts_plan::desired::SystemRef;
use rts_schemas::stand_in::shapes;
use rts_schemas::system::{
    ComponentSpec, Condition, Configuration, ConnectorSpec, DriftPolicy, ExecutionContextSpec,
    ExecutionKind, OnDisconnect, Orders, Placement, Policy, PortKind, PortRef, SendingTiming,
    SystemSpec, WaitFor,
};

/// Nodes of random systems.
pub const NODES: [&str; 3] = ["n0", "n1", "n2"];

pub fn component(instance: &str, type_name: &str) -> ComponentSpec {
    ComponentSpec {
        instance: instance.to_owned(),
        type_name: type_name.to_owned(),
        full_id: String::new(),
        required: true,
        ports: Vec::new(),
        configuration: Configuration::default(),
        execution_context: ExecutionContextSpec::default(),
        placement: Placement::default(),
        policy: Policy::default(),
        ..ComponentSpec::default()
    }
}

pub fn connector(source: (&str, &str), target: (&str, &str)) -> ConnectorSpec {
    let port = |(instance, port): (&str, &str)| PortRef {
        instance: instance.to_owned(),
        port: port.to_owned(),
    };
    let (source, target) = (port(source), port(target));
    ConnectorSpec {
        name: format!("{source}-{target}"),
        kind: PortKind::Data,
        source,
        target,
        data_type: Some("IDL:RTC/TimedDouble:1.0".to_owned()),
        properties: BTreeMap::new(),
    }
}

pub fn after(target: &str, sequence: u32, timing: SendingTiming, before: &[&str]) -> Condition {
    Condition {
        target: target.to_owned(),
        sequence,
        wait: (!before.is_empty()).then(|| WaitFor::Preceding {
            timing,
            timeout_ms: 0,
            components: before.iter().map(|&c| c.to_owned()).collect(),
        }),
    }
}

pub fn set(component: &mut ComponentSpec, name: &str, value: &str) {
    let sets = &mut component.configuration.sets;
    let set = sets.entry("default".to_owned()).or_default();
    set.insert(name.to_owned(), value.to_owned());
}

/// Sine0 and Filter0 in `main`, Printer0 in a process of its own; Printer0 is activated first.
pub fn hello() -> StoredSystem {
    let mut sine = component("Sine0", "SineSource");
    set(&mut sine, "amplitude", "1.0");
    let mut filter = component("Filter0", "LowPassFilter");
    set(&mut filter, "gain", "1.0");
    let mut printer = component("Printer0", "Printer");
    printer.placement.isolated = true;
    for component in [&mut sine, &mut filter, &mut printer] {
        component.execution_context.rate = Some(100.0);
    }
    let sync = SendingTiming::Sync;
    stored(SystemSpec {
        composites: Vec::new(),
        name: "hello".to_owned(),
        full_id: "RTSystem:rtsctl:hello:1.0".to_owned(),
        components: vec![sine, filter, printer],
        connectors: vec![
            connector(("Sine0", "out"), ("Filter0", "in")),
            connector(("Filter0", "out"), ("Printer0", "in")),
        ],
        orders: Orders {
            activation: vec![
                after("Filter0", 0, sync, &["Printer0"]),
                after("Sine0", 0, sync, &["Filter0"]),
            ],
            ..Orders::default()
        },
    })
}

/// The hello system, with this policy on what a person changes.
pub fn with_policy(policy: DriftPolicy) -> StoredSystem {
    let mut system = hello();
    for component in &mut system.spec.components {
        component.policy.drift = policy;
    }
    system
}

pub fn stored(spec: SystemSpec) -> StoredSystem {
    let types = spec.components.iter().map(|c| &c.type_name);
    StoredSystem {
        reference: SystemRef {
            name: spec.name.clone(),
            uid: format!("uid-of-{}", spec.name),
        },
        module_digests: types
            .map(|t| (t.clone(), format!("digest-{t}-0")))
            .collect(),
        spec,
        stand_ins: Default::default(),
        deleting: false,
    }
}

type Choices = (u8, u8, u8, u8, u8, bool, bool, u8, u8, u8);

/// A random system `name` with instances `{prefix}0`, `{prefix}1`, …
pub fn system(
    name: &'static str,
    prefix: &'static str,
    most: usize,
) -> impl Strategy<Value = StoredSystem> {
    let component = (
        0..3u8,
        0..3u8,
        0..4u8,
        0..3u8,
        0..3u8,
        any::<bool>(),
        any::<bool>(),
        0..5u8,
        0..6u8,
        0..4u8,
    );
    let connectors = prop::collection::vec((0..most, 0..most, 0..2u8), 0..most * 2);
    let orders = prop::collection::vec((0..9u8, 0..most, 0..most, any::<bool>(), 0..6u32), 0..20);
    (
        prop::collection::vec(component, 1..=most),
        connectors,
        orders,
        prop::collection::vec(0..2u8, 3),
        prop::collection::vec(prop::bool::weighted(0.2), most),
    )
        .prop_map(
            move |(components, connectors, orders, digests, stand_ins)| {
                let count = components.len();
                let instance = |index: usize| format!("{prefix}{}", index % count);
                let spec = SystemSpec {
                    composites: Vec::new(),
                    name: name.to_owned(),
                    full_id: String::new(),
                    components: components
                        .into_iter()
                        .enumerate()
                        .map(|(index, choices)| random_component(&instance(index), choices))
                        .collect(),
                    connectors: random_connectors(&connectors, instance),
                    orders: random_orders(&orders, count, instance),
                };
                let mut system = stored(spec);
                let components = system.spec.components.iter().zip(stand_ins);
                let stand_ins = components.filter(|(_, stand_in)| *stand_in);
                let names: Vec<String> = stand_ins.map(|(c, _)| c.instance.clone()).collect();
                system.stand_ins = shapes(&system.spec, &names, &Default::default());
                for (type_name, digest) in &mut system.module_digests {
                    let index = type_name.as_bytes()[1] - b'0';
                    *digest = format!("digest-{type_name}-{}", digests[usize::from(index)]);
                }
                system
            },
        )
}

fn random_component(instance: &str, choices: Choices) -> ComponentSpec {
    let (type_name, node, manager, gain, rate, reset, event, policy, drift, optional) = choices;
    let mut spec = component(instance, &format!("T{type_name}"));
    spec.placement = Placement {
        node: Some(NODES[usize::from(node)].to_owned()),
        host: None,
        manager: (manager == 1).then(|| "aux".to_owned()),
        isolated: manager == 2,
    };
    set(&mut spec, "gain", ["1.0", "1", "2.5"][usize::from(gain)]);
    spec.execution_context.rate = [None, Some(100.0), Some(50.0)][usize::from(rate)];
    spec.required = optional != 0;
    spec.policy.reset_on_error = reset;
    spec.policy.on_disconnect = on_disconnect(policy);
    spec.policy.drift = drift_policy(drift);
    // All laws hold for these as well.
    spec.execution_context.name = (gain != 1).then(|| format!("of-{instance}"));
    spec.execution_context.order = i32::from(rate);
    if event && manager == 3 {
        spec.execution_context.kind = ExecutionKind::EventDriven;
    }
    spec
}

/// `keep` is as likely as the others together.
pub fn on_disconnect(choice: u8) -> OnDisconnect {
    match choice {
        0 => OnDisconnect::Deactivate,
        1 => OnDisconnect::Stop,
        _ => OnDisconnect::Keep,
    }
}

/// `repair` is as likely as the others together.
pub fn drift_policy(choice: u8) -> DriftPolicy {
    match choice {
        0 | 1 => DriftPolicy::Ignore,
        2 => DriftPolicy::Adopt,
        _ => DriftPolicy::Repair,
    }
}

fn random_connectors(
    choices: &[(usize, usize, u8)],
    instance: impl Fn(usize) -> String,
) -> Vec<ConnectorSpec> {
    let mut connectors: BTreeMap<String, ConnectorSpec> = BTreeMap::new();
    for (source, target, policy) in choices {
        let (source, target) = (instance(*source), instance(*target));
        let mut spec = connector((&source, "out"), (&target, "in"));
        let policy = ["flush", "new"][usize::from(*policy)].to_owned();
        spec.properties
            .insert("dataport.subscription_type".to_owned(), policy);
        connectors.insert(spec.name.clone(), spec);
    }
    connectors.into_values().collect()
}

/// Orders without a cycle: everyone waits only for higher numbers in every list, and sequences fall with the number.
fn random_orders(
    choices: &[(u8, usize, usize, bool, u32)],
    count: usize,
    instance: impl Fn(usize) -> String,
) -> Orders {
    let mut orders = Orders::default();
    for &(list, one, other, sync, wait) in choices {
        let (low, high) = (
            (one % count).min(other % count),
            (one % count).max(other % count),
        );
        let timing = if sync {
            SendingTiming::Sync
        } else {
            SendingTiming::Async
        };
        let before = instance(high);
        let before: &[&str] = if low == high { &[] } else { &[&before] };
        let sequence = (count - low) as u32 / 2;
        let mut condition = after(&instance(low), sequence, timing, before);
        match (wait, &mut condition.wait) {
            (3, wait) => *wait = Some(WaitFor::Time { milliseconds: 20 }),
            (4.., Some(WaitFor::Preceding { timeout_ms, .. })) => *timeout_ms = wait * 100,
            _ => {}
        }
        let list = match list {
            0 => &mut orders.start_up,
            1 => &mut orders.deactivation,
            2 => &mut orders.shut_down,
            3 => &mut orders.resetting,
            4 => &mut orders.initializing,
            5 => &mut orders.finalizing,
            _ => &mut orders.activation,
        };
        list.push(condition);
    }
    orders
}
