//! Objects with fixed contents for tests of how they look.

use jiff::Timestamp;
use rts_controller_api::API_VERSION;
use rts_controller_api::objects::{
    Activity, Component, ComponentStatus, ComponentView, Connector, ConnectorStatus, ConnectorView,
    Event, EventStatus, EventView, Kind, Latency, Manager, ManagerStatus, ManagerView, Metadata,
    Node, NodeSpecView, NodeStatus, Object, Phase, System, SystemStatus, TapObserved, Usage,
};
use rts_plan::observed::{DurationsObserved, PortObserved, RealtimeObserved, TimingObserved};
use rts_schemas::system::{Direction, PortKind, SystemSpec};
use serde::Serialize;
use serde_json::{Value, json};

/// When the tests look.
pub const NOW: Timestamp = Timestamp::constant(1_700_000_000, 0);

fn ago(seconds: i64) -> Option<Timestamp> {
    Some(Timestamp::constant(1_700_000_000 - seconds, 0))
}

fn object<S, T>(kind: Kind, name: &str, spec: S, status: T) -> Object<S, T> {
    Object {
        api_version: API_VERSION.to_owned(),
        kind,
        metadata: Metadata {
            name: name.to_owned(),
            uid: "0b0e".to_owned(),
            resource_version: "7".to_owned(),
            generation: 2,
            creation_timestamp: ago(125),
            ..Metadata::default()
        },
        spec,
        status,
    }
}

/// The hello system, converged.
pub fn system() -> System {
    let spec = SystemSpec {
        composites: Vec::new(),
        name: "hello".to_owned(),
        full_id: "RTSystem:rtsctl:hello:1.0".to_owned(),
        components: Vec::new(),
        connectors: Vec::new(),
        orders: Default::default(),
    };
    let status = SystemStatus {
        observed_generation: 2,
        phase: Phase::Converged,
        synced: true,
        healthy: true,
        components: 3,
        active: 3,
        ..SystemStatus::default()
    };
    object(Kind::System, "hello", spec.into(), status)
}

fn node() -> Node {
    let spec = NodeSpecView {
        endpoint: "/tmp/h/run/local/agent.sock".to_owned(),
        aliases: Vec::new(),
        transport: None,
    };
    let status = NodeStatus {
        state: "Ready".to_owned(),
        last_seen: ago(1),
        version: "0.1.0".to_owned(),
        session: "s".to_owned(),
        managers: 2,
        components: 4,
        ..NodeStatus::default()
    };
    object(Kind::Node, "local", spec, status)
}

fn timing() -> TimingObserved {
    let durations = |median| DurationsObserved {
        count: 12_000,
        median,
        p99: 3 * median,
        p999: 9 * median,
        max: 40 * median,
        buckets: Vec::new(),
    };
    TimingObserved {
        overruns: 3,
        reached: Some(99),
        execution: durations(5_120),
        jitter: Some(durations(57_344)),
    }
}

fn realtime() -> RealtimeObserved {
    RealtimeObserved {
        scheduler: "SCHED_FIFO".to_owned(),
        priority: 50,
        cpus: "2-3".to_owned(),
        memory_locked: true,
        ..RealtimeObserved::default()
    }
}

fn component(name: &str, type_name: &str, system: &str, manager: &str, state: &str) -> Component {
    let spec = ComponentView {
        system: system.to_owned(),
        type_name: type_name.to_owned(),
        required: true,
        ..ComponentView::default()
    };
    let status = ComponentStatus {
        state: state.to_owned(),
        node: "local".to_owned(),
        manager: manager.to_owned(),
        pid: Some(4711),
        drift: system.is_empty(),
        rate: Some(100.0),
        executions: 12_000,
        timing: (system == "hello").then(timing),
        realtime: (name == "Sine0").then(realtime),
        ports: vec![PortObserved {
            name: "out".to_owned(),
            kind: PortKind::Data,
            direction: Some(Direction::Out),
            data_type: "IDL:RTC/TimedDouble:1.0".to_owned(),
        }],
        created: ago(5),
        ..ComponentStatus::default()
    };
    object(Kind::Component, name, spec, status)
}

fn connector() -> Connector {
    let spec = ConnectorView {
        system: "hello".to_owned(),
        kind: PortKind::Data,
        source: "Sine0.out".to_owned(),
        target: "Filter0.in".to_owned(),
        data_type: Some("IDL:RTC/TimedDouble:1.0".to_owned()),
        properties: Default::default(),
    };
    let status = ConnectorStatus {
        state: "Connected".to_owned(),
        transport: "direct".to_owned(),
        samples_sent: 1200,
        samples_received: 1199,
        bytes: 28_800,
        drops: 1,
        gaps: 1,
        rate: 100,
        latency: Some(Latency {
            count: 1199,
            min_ns: 5_100,
            median_ns: 16_383,
            p99_ns: 131_071,
            max_ns: 2_500_000,
        }),
        ..ConnectorStatus::default()
    };
    object(Kind::Connector, "Sine0.out-Filter0.in", spec, status)
}

fn manager() -> Manager {
    let spec = ManagerView {
        system: "hello".to_owned(),
    };
    let status = ManagerStatus {
        node: "local".to_owned(),
        pid: 4711,
        state: "Ready".to_owned(),
        components: vec!["Filter0".to_owned(), "Sine0".to_owned()],
        modules: vec!["LowPassFilter".to_owned(), "SineSource".to_owned()],
        incarnation: "i".to_owned(),
        started: ago(300),
        activity: Activity {
            taps: vec![TapObserved {
                port: "Sine0.out".to_owned(),
                way: "print".to_owned(),
            }],
            usage: Some(Usage {
                cpu_ms: 780,
                memory: 8_257_536,
            }),
        },
    };
    object(Kind::Manager, "hello.main", spec, status)
}

fn event() -> Event {
    let spec = EventView {
        system: "hello".to_owned(),
        kind: "Warning".to_owned(),
        reason: "ManagerDied".to_owned(),
        object: "manager/hello.main".to_owned(),
        message: "the process ended with signal 9".to_owned(),
    };
    object(Kind::Event, "e-1", spec, EventStatus { time: ago(7300) })
}

/// Objects of a kind as the API sends them.
pub fn values(kind: Kind) -> Vec<Value> {
    match kind {
        Kind::System => json_of(&[system()]),
        Kind::Node => json_of(&[node()]),
        Kind::Component => json_of(&[
            component("Sine0", "SineSource", "hello", "main", "Active"),
            component("Printer0", "Printer", "hello", "Printer0", "Inactive"),
            component("C9", "ConsoleOut", "", "main", "Error"),
        ]),
        Kind::Connector => json_of(&[connector()]),
        Kind::Manager => json_of(&[manager()]),
        Kind::Event => json_of(&[event()]),
    }
}

fn json_of<T: Serialize>(items: &[T]) -> Vec<Value> {
    match json!(items) {
        Value::Array(items) => items,
        other => vec![other],
    }
}
