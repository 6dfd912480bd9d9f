//! A node, and a small system that it is told to run.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use futures_util::StreamExt;
use rts_agent::peers::HomePeers;
use rts_agent::{Config, Inputs, Running};
use rts_agent_api::AgentApi;
use rts_agent_api::messages::{Batch, BatchEvent, NodeSpecEnvelope, StepOutcome};
use rts_plan::desired::{
    EndPlace, ManagerKey, NodeSpec, NodeSystem, PlacedComponent, PlacedConnector, SystemRef,
};
use rts_plan::observed::{Inventory, LifeCycleState};
use rts_plan::plan::{Step, StepId, Work};
use rts_schemas::system::{
    ComponentSpec, Configuration, ConnectorSpec, ExecutionKind, Policy, PortKind, PortRef,
};
use rts_simulation::{Life, Seed, SimClock, SimDisk, SimMachine, SimModule, Truth};
use tokio::time::{Instant, sleep, timeout};

/// Longer than anything takes.
pub const LONG: Duration = Duration::from_secs(120);

/// A node, which survives its agents.
pub struct Node {
    pub seed: Seed,
    pub machine: SimMachine,
    pub disk: SimDisk,
    clock: SimClock,
    pub truth: Truth,
}

impl Node {
    pub fn new(seed: u64) -> Self {
        let (seed, clock) = (Seed(seed), SimClock::new(Instant::now()));
        let truth = Truth::new();
        let machine = SimMachine::new("node1", seed, clock.clone(), truth.clone());
        for type_name in ["Sine", "Filter", "Printer"] {
            let module = SimModule::new(type_name)
                .port("in", "in", "TimedLong")
                .port("out", "out", "TimedLong");
            machine.install(module);
        }
        let disk = SimDisk::new("node1", seed);
        Self {
            seed,
            machine,
            disk,
            clock,
            truth,
        }
    }

    pub async fn start(&self, life: &Life) -> Running {
        let config = Config {
            home: "/rts".into(),
            node: "node1".to_owned(),
            aliases: Vec::new(),
            module_path: Vec::new(),
            manager_program: "/rts/rts-manager".into(),
            controller_socket: None,
            heal_after: Some(Duration::from_secs(3)),
            idle_managers: None,
        };
        let inputs = Inputs {
            clock: Arc::new(self.clock.clone()),
            chance: Arc::new(self.seed.stream(&format!("agent/{}", life.number()))),
            disk: self.disk.grip(life.clone()),
            machine: self.machine.grip(life.clone()),
            controller: None,
            peers: Arc::new(HomePeers::new(Path::new("/none"))),
        };
        rts_agent::start(config, inputs).await.unwrap()
    }
}

pub fn system() -> SystemRef {
    SystemRef {
        name: "hello".to_owned(),
        uid: "u-1".to_owned(),
    }
}

pub fn manager(name: &str) -> ManagerKey {
    ManagerKey {
        system: Some(system()),
        name: name.to_owned(),
    }
}

pub fn connector(source: &str, from: &str, target: &str, to: &str) -> PlacedConnector {
    let end = |manager: &str| EndPlace {
        node: "node1".to_owned(),
        manager: manager.to_owned(),
    };
    let port = |instance: &str, port: &str| PortRef {
        instance: instance.to_owned(),
        port: port.to_owned(),
    };
    PlacedConnector {
        spec: ConnectorSpec {
            name: format!("{source}.out-{target}.in"),
            kind: PortKind::Data,
            source: port(source, "out"),
            target: port(target, "in"),
            data_type: None,
            properties: Default::default(),
        },
        source: end(from),
        target: end(to),
        undetermined: None,
    }
}

pub fn connectors() -> Vec<PlacedConnector> {
    vec![
        connector("Sine0", "main", "Filter0", "main"),
        connector("Filter0", "main", "Printer0", "print"),
    ]
}

/// Instance, type and manager of each.
pub const COMPONENTS: [(&str, &str, &str); 3] = [
    ("Sine0", "Sine", "main"),
    ("Filter0", "Filter", "main"),
    ("Printer0", "Printer", "print"),
];

pub fn node_spec() -> NodeSpecEnvelope {
    node_spec_with(&Policy::default())
}

pub fn node_spec_with(policy: &Policy) -> NodeSpecEnvelope {
    let placed = |(instance, type_name, manager): (&str, &str, &str)| PlacedComponent {
        spec: ComponentSpec {
            instance: instance.to_owned(),
            type_name: type_name.to_owned(),
            full_id: String::new(),
            required: true,
            ports: Vec::new(),
            configuration: Configuration::default(),
            execution_context: Default::default(),
            placement: Default::default(),
            policy: policy.clone(),
            ..ComponentSpec::default()
        },
        manager: manager.to_owned(),
        stand_in: None,
        module_digest: None,
        recreate_hash: "h".to_owned(),
    };
    let spec = NodeSpec {
        node: "node1".to_owned(),
        systems: vec![NodeSystem {
            system: system(),
            components: COMPONENTS.map(placed).to_vec(),
            connectors: connectors(),
            orders: Default::default(),
            elsewhere: Default::default(),
            generation: 1,
        }],
    };
    NodeSpecEnvelope {
        cluster_uid: "cluster".to_owned(),
        epoch: 1,
        generation: 1,
        digest: rts_plan::place::digest(&spec),
        take_over: None,
        spec,
    }
}

/// Brings everything up, one step after the other.
pub fn up() -> Batch {
    let mut works: Vec<(String, Work)> = Vec::new();
    for name in ["main", "print"] {
        let manager = manager(name);
        works.push((
            format!("manager/hello.{name}"),
            Work::StartManager { manager },
        ));
    }
    for (instance, type_name, name) in COMPONENTS {
        works.push((
            format!("module/{type_name}"),
            Work::LoadModule {
                manager: manager(name),
                type_name: type_name.to_owned(),
                module_digest: None,
            },
        ));
        works.push((
            format!("component/{instance}"),
            Work::Create {
                manager: manager(name),
                instance: instance.to_owned(),
                type_name: type_name.to_owned(),
                recreate_hash: "h".to_owned(),
                configuration: Configuration::default(),
                execution_kind: ExecutionKind::Periodic,
                execution_context: None,
                rate: Some(100.0),
                on_disconnect: Default::default(),
                stand_in: None,
                realtime: None,
            },
        ));
    }
    for connector in connectors() {
        let target = format!("connector/{}", connector.spec.name);
        works.push((target, Work::Connect { connector }));
    }
    for (instance, _, name) in COMPONENTS {
        let manager = manager(name);
        let work = Work::Activate {
            manager,
            instance: instance.to_owned(),
        };
        works.push((format!("component/{instance}"), work));
    }
    let steps = works.into_iter().zip(1..).map(|((target, work), id)| Step {
        system: Some(system()),
        needs: (id > 1)
            .then_some(id - 1)
            .into_iter()
            .collect::<Vec<StepId>>(),
        reason: "test".to_owned(),
        ..Step::new(id, "node1", &target, work)
    });
    Batch {
        plan_id: "up".to_owned(),
        cluster_uid: "cluster".to_owned(),
        epoch: 1,
        generation: 1,
        steps: steps.collect(),
        gates: Vec::new(),
        deadline_ms: 60_000,
        parallelism: 8,
        seen: None,
    }
}

pub async fn bring_up(agent: &Running) {
    let api = agent.api();
    api.put_node_spec(&node_spec()).await.unwrap();
    let events = api.run_batch(&up()).await.unwrap();
    let events: Vec<BatchEvent> = events.map(Result::unwrap).collect().await;
    assert_eq!(events.last(), Some(&BatchEvent::End));
    let failed = events.iter().filter(|event| match event {
        BatchEvent::Finished { outcome, .. } => *outcome != StepOutcome::Succeeded,
        _ => false,
    });
    assert_eq!(failed.collect::<Vec<_>>(), Vec::<&BatchEvent>::new());
}

/// What must not change: incarnations of processes and components, and that all of them are Active.
pub fn identity(inventory: &Inventory) -> Vec<String> {
    let lines = inventory.managers.iter().flat_map(|manager| {
        let name = manager.key.display_name();
        let of = format!("{name} {} {}", manager.incarnation, manager.pid);
        let components = manager.components.iter().map(move |c| {
            let state = c.state;
            assert_eq!(state, LifeCycleState::Active, "{}", c.instance);
            format!("{of} {} {}", c.instance, c.incarnation)
        });
        components.collect::<Vec<_>>()
    });
    lines.collect()
}

/// Waits until all three components are Active, and gives the identity of everything.
pub async fn until_up(agent: &Running) -> Vec<String> {
    let api = agent.api();
    let up = async {
        loop {
            let inventory = api.inventory().await.unwrap();
            let components = inventory.managers.iter().flat_map(|m| &m.components);
            let active = components.filter(|c| c.state == LifeCycleState::Active);
            if active.count() == 3 {
                return identity(&inventory);
            }
            sleep(Duration::from_millis(100)).await;
        }
    };
    match timeout(LONG, up).await {
        Ok(up) => up,
        Err(_) => panic!("{:#?}", api.inventory().await),
    }
}
