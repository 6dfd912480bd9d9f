//! Systems to apply.

use rts_schemas::system::{
    ComponentSpec, Condition, Configuration, ConnectorSpec, ExecutionContextSpec, Orders,
    Placement, Policy, PortKind, PortRef, SendingTiming, SystemSpec, WaitFor,
};

pub fn component(instance: &str, type_name: &str) -> ComponentSpec {
    ComponentSpec {
        instance: instance.into(),
        type_name: type_name.into(),
        full_id: String::new(),
        required: true,
        ports: Vec::new(),
        configuration: Configuration::default(),
        execution_context: ExecutionContextSpec {
            rate: Some(100.0),
            ..ExecutionContextSpec::default()
        },
        placement: Placement::default(),
        policy: Policy::default(),
        ..ComponentSpec::default()
    }
}

fn port(text: &str) -> PortRef {
    let (instance, port) = text.split_once('.').unwrap();
    PortRef {
        instance: instance.into(),
        port: port.into(),
    }
}

pub fn connector(source: &str, target: &str) -> ConnectorSpec {
    ConnectorSpec {
        name: format!("{source}-{target}"),
        kind: PortKind::Data,
        source: port(source),
        target: port(target),
        data_type: None,
        properties: [].into(),
    }
}

/// `target` goes after `before`.
pub fn after(target: &str, before: &str) -> Condition {
    Condition {
        target: target.into(),
        sequence: 0,
        wait: Some(WaitFor::Preceding {
            timing: SendingTiming::Sync,
            timeout_ms: 0,
            components: vec![before.into()],
        }),
    }
}

pub fn hello() -> SystemSpec {
    let mut printer = component("Printer0", "Printer");
    printer.placement.isolated = true;
    SystemSpec {
        composites: Vec::new(),
        name: "hello".into(),
        full_id: "RTSystem:rtsctl:hello:1.0".into(),
        components: vec![
            component("Sine0", "SineSource"),
            component("Filter0", "LowPassFilter"),
            printer,
        ],
        connectors: vec![
            connector("Sine0.out", "Filter0.in"),
            connector("Filter0.out", "Printer0.in"),
        ],
        orders: Orders {
            activation: vec![after("Filter0", "Printer0"), after("Sine0", "Filter0")],
            ..Orders::default()
        },
    }
}
