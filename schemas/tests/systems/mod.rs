//! Random systems that the checks let pass, with everything that a system can say.

use std::collections::{BTreeMap, BTreeSet};

use proptest::collection::{btree_map, vec};
use proptest::option;
use proptest::prelude::*;
use proptest::sample::select;
use rts_schemas::system::{
    ComponentSpec, Condition, Configuration, ConnectorSpec, Direction, DriftPolicy,
    ExecutionContextSpec, ExecutionKind, OnDisconnect, OnHang, Orders, Package, Placement, Policy,
    PortKind, PortRef, PortSpec, Resources, RestartPolicy, SendingTiming, StandIn, StandInFault,
    StandInSpec, SystemSpec, WaitFor,
};

/// Any text that XML can hold, blanks and line ends at its ends too.
fn value() -> impl Strategy<Value = String> {
    prop_oneof![
        Just(String::new()),
        "[ \\t\\n\\r<>&\"'a-z0-9日本語😀\u{85}\u{1}\u{1b}]{0,12}",
        select(vec![
            "1.0", "0<=x<=1", "(0,1)", "&amp;", " a ", "]]>", "<!--"
        ])
        .prop_map(str::to_owned),
    ]
}

/// A name, without blanks at its ends.
fn name() -> impl Strategy<Value = String> {
    select(vec![
        "Sine0",
        "Sine",
        "Filter0",
        "左腕0",
        "My Sine",
        "a.b",
        "50%",
        "A&B",
        "x<y>",
        "in",
        "Sine0.out",
        "#2",
        "\"q\"",
        "A-B",
    ])
    .prop_map(str::to_owned)
}

/// A value that readers trim.
fn trimmed() -> impl Strategy<Value = String> {
    value().prop_map(|text| text.trim().to_owned())
}

fn policy() -> impl Strategy<Value = Policy> {
    let ms = || option::of(100..=86_400_000u64);
    (
        (
            select(vec![
                RestartPolicy::Always,
                RestartPolicy::OnFailure,
                RestartPolicy::Never,
            ]),
            select(vec![
                OnDisconnect::Keep,
                OnDisconnect::Deactivate,
                OnDisconnect::Stop,
            ]),
            any::<bool>(),
            option::of(1..=1000u32),
        ),
        (ms(), ms(), ms()),
        select(vec![OnHang::Report, OnHang::Restart]),
        select(vec![
            DriftPolicy::Repair,
            DriftPolicy::Ignore,
            DriftPolicy::Adopt,
        ]),
    )
        .prop_map(|(first, times, on_hang, drift)| Policy {
            restart: first.0,
            on_disconnect: first.1,
            reset_on_error: first.2,
            restart_limit: first.3,
            restart_window_ms: times.0,
            start_timeout_ms: times.1,
            liveness_timeout_ms: times.2,
            on_hang,
            drift,
        })
}

fn placement() -> impl Strategy<Value = Placement> {
    let host = select(vec![
        "robot-1.local",
        "10.4.62.1",
        "fe80::1",
        "fe80::2%eth0",
        "ロボット",
    ]);
    (
        option::of(select(vec!["n0", "robot-1.local", "fe80::1"])),
        option::of(host),
        option::of(select(vec!["main", "m-sine0", "left.arm"])),
        any::<bool>(),
    )
        .prop_map(|(node, host, manager, isolated)| Placement {
            node: node.map(str::to_owned),
            host: host.map(str::to_owned),
            manager: manager.map(str::to_owned),
            isolated,
        })
}

fn data_type() -> impl Strategy<Value = Option<String>> {
    let types = vec![
        "IDL:RTC/TimedLong:1.0",
        "IDL:ssr/Frame:2.0",
        "IDL:RTC/TimedDouble:1.0",
    ];
    option::of(select(types).prop_map(str::to_owned))
}

/// Declared ports: the name tells what a port is, as in [`connectors`].
fn ports() -> impl Strategy<Value = Vec<PortSpec>> {
    let port = (select(PORTS.to_vec()), any::<bool>(), data_type());
    vec(port, 0..5).prop_map(|ports| {
        let mut seen = BTreeSet::new();
        let ports = ports.into_iter().filter(|(name, _, _)| seen.insert(*name));
        ports
            .map(|(name, direction, data_type)| {
                let kind = kind(name);
                let is_data = kind == PortKind::Data;
                let side = if name.contains("out") {
                    Direction::Out
                } else {
                    Direction::In
                };
                PortSpec {
                    name: name.to_owned(),
                    kind,
                    direction: (is_data && direction).then_some(side),
                    data_type: data_type.filter(|_| is_data),
                }
            })
            .collect()
    })
}

const PORTS: [&str; 7] = [
    "out",
    "out & <2>",
    "out.3",
    "in",
    "in.ポート",
    "service",
    "service 2",
];

fn kind(port: &str) -> PortKind {
    if port.starts_with("service") {
        PortKind::Service
    } else {
        PortKind::Data
    }
}

fn configuration() -> impl Strategy<Value = Configuration> {
    let set = || select(vec!["default", "mode0", "左 & 右", "__x"]).prop_map(str::to_owned);
    let values = btree_map(name(), value(), 0..4);
    (option::of(set()), btree_map(set(), values, 0..3))
        .prop_map(|(active, sets)| Configuration { active, sets })
}

fn execution_context() -> impl Strategy<Value = ExecutionContextSpec> {
    let kinds = vec![
        ExecutionKind::Periodic,
        ExecutionKind::EventDriven,
        ExecutionKind::Other,
    ];
    let rate = prop_oneof![
        select(vec![0.001, 0.1, 1.0, 1000.0, 1e6, 29.97, 100.0 / 3.0]),
        0.001..1e6f64
    ];
    (
        select(vec!["0", "1", "Comp1Ec1"]),
        select(kinds),
        option::of(rate),
        option::of(select(vec!["control", "slow.loop"])),
        select(vec![0, -3, 10]),
    )
        .prop_map(|(id, kind, rate, name, order)| ExecutionContextSpec {
            id: id.to_owned(),
            kind,
            rate,
            name: name.map(str::to_owned),
            order,
            shared_state: None,
        })
}

/// One component, whose id mostly says its type.
fn component(instance: String) -> impl Strategy<Value = ComponentSpec> {
    let id = (
        select(vec!["Sine", "Sine0", "LowPassFilter", "カメラ"]),
        0..4u8,
    );
    (
        id,
        any::<bool>(),
        ports(),
        configuration(),
        execution_context(),
        (placement(), policy()),
        kept(),
    )
        .prop_map(
            move |(id, required, ports, configuration, context, (placement, policy), kept)| {
                let (package, stand_in, resources) = kept;
                // Whoever shares one must fit the others.
                let mut context = context;
                let own = context.name.map(|name| format!("{name} of {instance}"));
                context.name = own.filter(|name| name.len() <= 128);
                let (type_name, form) = id;
                let full_id = match form {
                    0 => String::new(),
                    1 => format!("RTC:A & B, \"C\".:example:{type_name}:1.0"),
                    2 => format!("RTC:v.c.{type_name}:1.0"),
                    _ => "RTC:v:c:Other:1.0".to_owned(),
                };
                ComponentSpec {
                    instance: instance.clone(),
                    type_name: type_name.to_owned(),
                    full_id,
                    required,
                    ports,
                    configuration,
                    execution_context: context,
                    placement,
                    policy,
                    package,
                    stand_in,
                    resources,
                }
            },
        )
}

/// What is kept, though nothing is done with it.
fn kept() -> impl Strategy<Value = (Package, StandInSpec, Resources)> {
    let package = (
        option::of("[a-z]{1,9}"),
        option::of(select(vec!["1.2", ">=1, <2"])),
    );
    let when = option::of(select(vec![
        StandIn::Never,
        StandIn::Missing,
        StandIn::Always,
    ]));
    let fail = option::of(select(vec![
        StandInFault::Initialize,
        StandInFault::Activate,
        StandInFault::Execute,
    ]));
    let time = || option::of(select(vec![100_u64, 90_000]));
    let stand_in =
        (when, time(), fail, time()).prop_map(|(when, startup, fail, crash)| StandInSpec {
            when,
            startup_time_ms: startup,
            fail,
            crash_after_ms: crash,
            // Only of the ports that there are; tests of its own have it.
            data: BTreeMap::new(),
            profile: None,
        });
    let resources = (
        option::of(select(vec!["0", "2-3", "0-1,5"])),
        option::of(1..=99u8),
        (option::of(any::<bool>()), option::of(any::<bool>())),
        option::of(1u64 << 20..1 << 50),
    );
    (package, stand_in, resources).prop_map(|((name, version), stand_in, resources)| {
        let (cpus, realtime_priority, (lock_memory, required), memory_limit_bytes) = resources;
        let package = Package {
            name,
            version: version.map(str::to_owned),
        };
        let resources = Resources {
            cpus: cpus.map(str::to_owned),
            realtime_priority,
            lock_memory,
            required,
            memory_limit_bytes,
        };
        (package, stand_in, resources)
    })
}

type Choice = prop::sample::Index;

/// Connectors between the components, each from an out-port to an in-port or between service ports; their names are as
/// a reader would make them, or others.
fn connectors(instances: Vec<String>) -> impl Strategy<Value = Vec<ConnectorSpec>> {
    let key = prop_oneof![
        select(vec![
            "dataport.interface_type",
            "dataport.push_interval",
            "a & b",
        ])
        .prop_map(str::to_owned),
        "[a-z.]{1,9}",
    ];
    let value = prop_oneof![
        3 => trimmed().prop_map(|text| text.to_lowercase()),
        1 => select(vec!["0.5", "1e3", "0", "-1", "inf"]).prop_map(str::to_owned),
    ];
    // Of these only some words are right.
    let chosen = |key: &'static str, words: &'static [&'static str]| {
        (Just(key.to_owned()), select(words).prop_map(str::to_owned))
    };
    let property = prop_oneof![
        3 => (key, value),
        1 => chosen("dataport.dataflow_type", &["push", "pull", "duplex"]),
        1 => chosen("dataport.subscription_type", &["flush", "new", "block"]),
    ];
    let connector = (
        any::<(Choice, Choice, Choice, bool)>(),
        data_type(),
        vec(property, 0..4).prop_map(BTreeMap::from_iter),
        option::of(name()),
    );
    vec(connector, 0..8).prop_map(move |all| {
        let mut used = BTreeSet::new();
        let all = all.into_iter().map(|(ends, data_type, properties, name)| {
            let (source, target, ports, is_data) = ends;
            let (out, into) = if is_data {
                (&PORTS[ports.index(3)], &PORTS[3 + ports.index(2)])
            } else {
                (&PORTS[5], &PORTS[5 + ports.index(2)])
            };
            let end = |index: Choice, port: &str| PortRef {
                instance: instances[index.index(instances.len())].clone(),
                port: port.to_owned(),
            };
            let (source, target) = (end(source, out), end(target, into));
            let made = name.unwrap_or_else(|| format!("{source}-{target}"));
            let numbers = (1..).map(|n| {
                if n == 1 {
                    made.clone()
                } else {
                    format!("{made}#{n}")
                }
            });
            let name = numbers.into_iter().find(|name| used.insert(name.clone()));
            ConnectorSpec {
                name: name.unwrap_or_default(),
                kind: if is_data {
                    PortKind::Data
                } else {
                    PortKind::Service
                },
                source,
                target,
                data_type: data_type.filter(|_| is_data),
                properties,
            }
        });
        all.collect()
    })
}

fn order(instances: Vec<String>) -> impl Strategy<Value = Vec<Condition>> {
    let one = select(instances.clone());
    let timing = select(vec![SendingTiming::Sync, SendingTiming::Async]);
    let wait = prop_oneof![
        Just(None),
        any::<u32>().prop_map(|milliseconds| Some(WaitFor::Time { milliseconds })),
        (
            timing,
            prop_oneof![Just(0), any::<u32>()],
            vec(one.clone(), 1..3)
        )
            .prop_map(|(timing, timeout_ms, components)| Some(WaitFor::Preceding {
                timing,
                timeout_ms,
                components,
            })),
    ];
    let condition = (one, prop_oneof![0..4u32, any::<u32>()], wait);
    vec(
        condition.prop_map(|(target, sequence, wait)| Condition {
            target,
            sequence,
            wait,
        }),
        0..4,
    )
}

fn orders(instances: Vec<String>) -> BoxedStrategy<Orders> {
    if instances.is_empty() {
        return Just(Orders::default()).boxed();
    }
    let order = || order(instances.clone());
    (
        order(),
        order(),
        order(),
        order(),
        order(),
        order(),
        order(),
    )
        .prop_map(|all| Orders {
            start_up: all.0,
            shut_down: all.1,
            activation: all.2,
            deactivation: all.3,
            resetting: all.4,
            initializing: all.5,
            finalizing: all.6,
        })
        .boxed()
}

/// A system of at most five components.
pub fn system() -> impl Strategy<Value = SystemSpec> {
    let instances = prop::collection::btree_set(name(), 0..6);
    instances.prop_flat_map(|instances| {
        let instances: Vec<String> = instances.into_iter().collect();
        let head = select(vec![
            ("hello", "RTSystem:rtsctl:hello:1.0"),
            ("hello", "RTSystem :Me & You.hello.0"),
            ("demo", "RTSystem:rtsctl:hello:1.0"),
            ("demo", "RTSystem:v:日本:1.0"),
            ("demo", ""),
            ("file", "RTSystem :Me.RTSystem.0"),
        ]);
        let components: Vec<_> = instances.iter().cloned().map(component).collect();
        let connectors = if instances.is_empty() {
            Just(Vec::new()).boxed()
        } else {
            connectors(instances.clone()).boxed()
        };
        (head, components, connectors, orders(instances)).prop_map(
            |((name, full_id), components, connectors, orders)| SystemSpec {
                composites: Vec::new(),
                name: name.to_owned(),
                full_id: full_id.to_owned(),
                components,
                connectors,
                orders,
            },
        )
    })
}
