//! A node in a temporary home, and words to talk to it.

use std::path::{Path, PathBuf};
use std::time::Duration;

use futures_util::StreamExt;
use rts_agent::{Config, Serving, StartError};
use rts_agent_api::AgentApi;
use rts_agent_api::client::HttpAgent;
use rts_agent_api::messages::{Batch, BatchEvent, NodeSpecEnvelope, StepOutcome};
use rts_host::cgroup::{Cgroups, Choice};
use rts_http::client::{Client, ClientError};
use rts_http::problem::Problem;
use rts_manager_api::files::{MANAGER_JSON, ManagerFile};
use rts_plan::desired::{
    EndPlace, ManagerKey, NodeSpec, NodeSystem, PlacedComponent, PlacedConnector, SystemRef,
};
use rts_plan::observed::{ComponentObserved, Inventory};
use rts_plan::place::digest;
use rts_plan::plan::{Step, StepId, Work};
use rts_schemas::system::{
    ComponentSpec, Configuration, ConnectorSpec, ExecutionKind, PortKind, PortRef,
};
use tempfile::TempDir;

use crate::fake_manager;

/// How long a test waits for something that must happen.
pub const PATIENCE: Duration = Duration::from_secs(10);

/// A home, and an agent that serves in it unless it was stopped.
pub struct Node {
    pub home: TempDir,
    pub config: Config,
    pub agent: HttpAgent,
    running: Option<Serving>,
}

impl Node {
    /// A node with fake managers and modules for a few types.
    pub async fn start() -> Self {
        Self::with("", None).await
    }

    pub async fn with(behaviour: &str, controller: Option<PathBuf>) -> Self {
        let home = tempfile::Builder::new()
            .prefix("rts")
            .tempdir_in("/tmp")
            .unwrap();
        let modules = home.path().join("modules");
        std::fs::create_dir(&modules).unwrap();
        for name in ["sine", "filter", "printer", "crash"] {
            std::fs::write(modules.join(format!("lib{name}.so")), name).unwrap();
        }
        let config = Config {
            home: home.path().to_owned(),
            node: "local".to_owned(),
            aliases: vec!["robot".to_owned()],
            module_path: vec![modules],
            manager_program: fake_manager::program(home.path(), behaviour),
            controller_socket: controller,
            heal_after: None,
            idle_managers: None,
        };
        Self::of(home, config).await
    }

    pub async fn of(home: TempDir, config: Config) -> Self {
        let running = start(&config).await.unwrap();
        let http = Client::unix(running.socket(), PATIENCE).unwrap();
        Self {
            home,
            config,
            agent: HttpAgent::new(http),
            running: Some(running),
        }
    }

    /// A node whose agent is another process.
    pub fn of_process(home: TempDir, config: Config) -> Self {
        let http = Client::unix(config.home.join("run/local/agent.sock"), PATIENCE).unwrap();
        Self {
            home,
            config,
            agent: HttpAgent::new(http),
            running: None,
        }
    }

    pub async fn stop(&mut self) {
        self.running.take().unwrap().stop().await;
    }

    pub async fn start_again(&mut self) {
        self.running = Some(start(&self.config).await.unwrap());
    }

    pub fn run(&self) -> PathBuf {
        self.home.path().join("run/local")
    }

    /// Descriptions of the managers that have a run folder.
    pub fn managers(&self) -> Vec<ManagerFile> {
        let entries = std::fs::read_dir(self.run())
            .into_iter()
            .flatten()
            .flatten();
        entries
            .filter_map(|e| std::fs::read(e.path().join(MANAGER_JSON)).ok())
            .filter_map(|text| serde_json::from_slice(&text).ok())
            .collect()
    }

    /// Waits until the inventory is as wanted.
    pub async fn until(&self, wanted: impl Fn(&Inventory) -> bool) -> Inventory {
        let end = tokio::time::Instant::now() + PATIENCE;
        loop {
            let inventory = self.agent.inventory().await.unwrap();
            if wanted(&inventory) {
                return inventory;
            }
            assert!(tokio::time::Instant::now() < end, "{inventory:#?}");
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    }

    /// Runs a batch to its end; gives the outcome of each step.
    pub async fn outcomes(&self, batch: &Batch) -> Vec<(StepId, String)> {
        let mut events = self.agent.run_batch(batch).await.unwrap();
        let mut outcomes = Vec::new();
        let mut ended = false;
        while let Some(event) = events.next().await {
            match event.unwrap() {
                BatchEvent::Finished { step, outcome, .. } => outcomes.push((step, say(outcome))),
                BatchEvent::End => ended = true,
                _ => {}
            }
        }
        assert!(ended);
        outcomes.sort();
        outcomes
    }

    /// Accepts the hello system as a generation.
    pub async fn accept(&self, generation: u64) {
        let receipt = self.agent.put_node_spec(&hello_spec(generation)).await;
        assert_eq!(receipt.unwrap().generation, generation);
    }

    /// Runs the whole hello system.
    pub async fn hello(&self) {
        self.accept(1).await;
        let outcomes = self.outcomes(&hello_batch("up", 1)).await;
        assert!(outcomes.iter().all(|(_, o)| o == "ok"), "{outcomes:?}");
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        for manager in self.managers() {
            kill(manager.pid, rustix::process::Signal::KILL);
        }
        let cgroups = Cgroups::of(self.home.path(), Choice::Auto);
        for cgroup in cgroups.find() {
            cgroup.kill_within(PATIENCE);
            let _ = cgroup.remove();
        }
        cgroups.tidy();
    }
}

async fn start(config: &Config) -> Result<Serving, StartError> {
    rts_agent::serve(config.clone()).await
}

/// Starts a second agent where one runs.
pub async fn start_beside(config: &Config) -> Result<Serving, StartError> {
    start(config).await
}

pub fn kill(pid: u32, signal: rustix::process::Signal) {
    let pid = rustix::process::Pid::from_raw(pid as i32).unwrap();
    let _ = rustix::process::kill_process_group(pid, signal);
}

pub fn problem<T: std::fmt::Debug>(result: Result<T, ClientError>) -> Problem {
    match result {
        Err(ClientError::Problem(problem)) => problem,
        other => panic!("{other:?}"),
    }
}

fn say(outcome: StepOutcome) -> String {
    match outcome {
        StepOutcome::Succeeded => "ok".to_owned(),
        StepOutcome::Failed { reason } => format!("failed: {reason}"),
        StepOutcome::Skipped { because_of, reason } => format!("skipped {because_of:?}: {reason}"),
    }
}

pub fn component<'a>(inventory: &'a Inventory, name: &str) -> &'a ComponentObserved {
    let mut all = inventory.managers.iter().flat_map(|m| &m.components);
    all.find(|c| c.instance == name).unwrap()
}

pub fn system() -> SystemRef {
    SystemRef {
        name: "hello".to_owned(),
        uid: "8c1d7c8e-0000-4000-8000-000000000001".to_owned(),
    }
}

pub fn manager(name: &str) -> ManagerKey {
    ManagerKey {
        system: Some(system()),
        name: name.to_owned(),
    }
}

pub fn envelope(generation: u64, systems: Vec<NodeSystem>) -> NodeSpecEnvelope {
    let spec = NodeSpec {
        node: "local".to_owned(),
        systems,
    };
    NodeSpecEnvelope {
        cluster_uid: "cluster".to_owned(),
        epoch: 1,
        generation,
        digest: digest(&spec),
        take_over: None,
        spec,
    }
}

pub fn hello_spec(generation: u64) -> NodeSpecEnvelope {
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
            policy: Default::default(),
            ..ComponentSpec::default()
        },
        manager: manager.to_owned(),
        module_digest: None,
        stand_in: None,
        recreate_hash: "h".to_owned(),
    };
    let components = [
        ("Sine0", "Sine", "main"),
        ("Filter0", "Filter", "main"),
        ("Printer0", "Printer", "Printer0"),
    ];
    let hello = NodeSystem {
        system: system(),
        components: components.map(placed).to_vec(),
        connectors: vec![
            connector("Sine0", "main", "Filter0", "main"),
            connector("Filter0", "main", "Printer0", "Printer0"),
        ],
        orders: Default::default(),
        elsewhere: Default::default(),
        generation: 0,
    };
    envelope(generation, vec![hello])
}

pub fn connector(
    source: &str,
    source_manager: &str,
    target: &str,
    target_manager: &str,
) -> PlacedConnector {
    let end = |manager: &str| EndPlace {
        node: "local".to_owned(),
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
        source: end(source_manager),
        target: end(target_manager),
        undetermined: None,
    }
}

pub fn step(id: StepId, needs: &[StepId], target: &str, work: Work) -> Step {
    Step {
        system: Some(system()),
        needs: needs.to_vec(),
        reason: "test".to_owned(),
        ..Step::new(id, "local", target, work)
    }
}

pub fn start_manager(id: StepId, name: &str) -> Step {
    let target = format!("manager/hello.{name}");
    let manager = manager(name);
    step(id, &[], &target, Work::StartManager { manager })
}

pub fn load(id: StepId, needs: &[StepId], at: &str, type_name: &str) -> Step {
    let work = Work::LoadModule {
        manager: manager(at),
        type_name: type_name.to_owned(),
        module_digest: None,
    };
    step(id, needs, &format!("module/{type_name}"), work)
}

pub fn create(id: StepId, needs: &[StepId], at: &str, instance: &str, type_name: &str) -> Step {
    let work = Work::Create {
        manager: manager(at),
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
    };
    step(id, needs, &format!("component/{instance}"), work)
}

pub fn activate(id: StepId, needs: &[StepId], at: &str, instance: &str) -> Step {
    let work = Work::Activate {
        manager: manager(at),
        instance: instance.to_owned(),
    };
    step(id, needs, &format!("component/{instance}"), work)
}

pub fn connect(id: StepId, needs: &[StepId], connector: PlacedConnector) -> Step {
    let target = format!("connector/{}", connector.spec.name);
    step(id, needs, &target, Work::Connect { connector })
}

pub fn batch(plan_id: &str, generation: u64, steps: Vec<Step>) -> Batch {
    Batch {
        plan_id: plan_id.to_owned(),
        cluster_uid: "cluster".to_owned(),
        epoch: 1,
        generation,
        steps,
        gates: Vec::new(),
        deadline_ms: 60_000,
        parallelism: 8,
        seen: None,
    }
}

pub fn hello_batch(plan_id: &str, generation: u64) -> Batch {
    batch(
        plan_id,
        generation,
        vec![
            start_manager(1, "main"),
            start_manager(2, "Printer0"),
            load(3, &[1], "main", "Sine"),
            load(4, &[1], "main", "Filter"),
            load(5, &[2], "Printer0", "Printer"),
            create(6, &[3], "main", "Sine0", "Sine"),
            create(7, &[4], "main", "Filter0", "Filter"),
            create(8, &[5], "Printer0", "Printer0", "Printer"),
            connect(9, &[6, 7], connector("Sine0", "main", "Filter0", "main")),
            connect(
                10,
                &[7, 8],
                connector("Filter0", "main", "Printer0", "Printer0"),
            ),
            activate(11, &[10], "Printer0", "Printer0"),
            activate(12, &[9, 11], "main", "Filter0"),
            activate(13, &[12], "main", "Sine0"),
        ],
    )
}

/// True when a process lives and is no zombie.
pub fn lives(pid: u32) -> bool {
    let stat = std::fs::read_to_string(Path::new("/proc").join(pid.to_string()).join("stat"));
    stat.is_ok_and(|s| {
        s.rsplit_once(") ")
            .is_some_and(|(_, rest)| !rest.starts_with('Z'))
    })
}
