mod adopt;
mod connectors;
mod life;
mod misbehaving;

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rts_agent::launch::{Exit, Start};
use rts_agent::machine::{Control, Family, Launched, Machine};
use rts_manager_api::PROTOCOL_VERSION;
use rts_manager_api::control::*;
use rts_manager_api::files::CONTROL_SOCKET;
use rts_manager_api::frame;
use rts_plan::desired::{ManagerKey, SystemRef};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::{Instant, sleep, timeout};

use super::*;
use crate::modules::SimModule;
use crate::truth::{Happened, Witness};

/// Longer than anything takes.
const LONG: Duration = Duration::from_secs(60);

/// A machine, and what has happened on it.
struct Bench {
    machine: SimMachine,
    life: Life,
    grip: Arc<dyn Machine>,
    seen: Arc<Mutex<Vec<Happened>>>,
}

struct Notes(Arc<Mutex<Vec<Happened>>>);

impl Witness for Notes {
    fn see(&mut self, _at: Duration, what: &Happened) {
        self.0.lock().unwrap().push(what.clone());
    }
}

fn bench() -> Bench {
    let truth = Truth::new();
    let seen = Arc::<Mutex<Vec<Happened>>>::default();
    truth.show(Notes(seen.clone()));
    let clock = SimClock::new(Instant::now());
    let machine = SimMachine::new("node1", Seed(1), clock, truth);
    machine.grandchildren(0.0);
    let module = SimModule::new("Relay")
        .port("in", "in", "TimedLong")
        .port("out", "out", "TimedLong")
        .parameter("gain", "1");
    machine.install(module);
    let life = Life::new("node1", 1);
    let grip = machine.grip(life.clone());
    Bench {
        machine,
        life,
        grip,
        seen,
    }
}

impl Bench {
    /// What has happened since this was asked last, a line each.
    fn story(&self) -> String {
        let seen = std::mem::take(&mut *self.seen.lock().unwrap());
        let lines: Vec<String> = seen.iter().map(line).collect();
        lines.join("\n")
    }

    /// Starts a manager, and greets it.
    async fn start(&self, name: &str) -> (Caller, Box<dyn Family>) {
        let start = start(name, name);
        self.grip.make_folder(&start.folder).await.unwrap();
        let launched = self.grip.launch(&start).await;
        let Launched {
            family, control, ..
        } = launched.map_err(|e| e.to_string()).unwrap();
        (Caller::greet(control).await.unwrap(), family)
    }

    /// Starts a manager with a module and components, all Active.
    async fn start_with(&self, name: &str, components: &[&str]) -> (Caller, Box<dyn Family>) {
        let (mut caller, family) = self.start(name).await;
        caller.ok(load()).await;
        for component in components {
            caller.ok(create(component)).await;
            caller.ok(activate(component)).await;
        }
        (caller, family)
    }

    /// A further life of the agent.
    fn next_life(&mut self) {
        self.life.end();
        self.life = Life::new("node1", self.life.number() + 1);
        self.grip = self.machine.grip(self.life.clone());
    }
}

fn line(what: &Happened) -> String {
    use Happened as H;
    match what {
        H::ProcessStarted { process, .. } => format!("{process} started"),
        H::ProcessEnded { process, cause, .. } => format!("{process} ended: {cause:?}"),
        H::Created(of) => format!("{} created", of.instance),
        H::Deleted(of, cause) => format!("{} deleted: {cause:?}", of.instance),
        H::State {
            of,
            from,
            to,
            cause,
        } => format!("{} {from} -> {to}: {cause:?}", of.instance),
        H::Connected { connector, .. } => format!("{connector} connected"),
        H::Disconnected {
            connector, cause, ..
        } => format!("{connector} disconnected: {cause:?}"),
        H::Blemished {
            process,
            instance,
            what,
            ..
        } => format!(
            "{process}/{} blemished: {what}",
            instance.as_deref().unwrap_or("-")
        ),
        other => format!("{other:?}"),
    }
}

fn folder(name: &str) -> PathBuf {
    Path::new("/home/run/node1").join(name)
}

fn start(name: &str, incarnation: &str) -> Start {
    Start {
        key: ManagerKey {
            system: Some(SystemRef {
                name: "hello".to_owned(),
                uid: "1".to_owned(),
            }),
            name: name.to_owned(),
        },
        incarnation: incarnation.to_owned(),
        folder: folder(name),
        log: PathBuf::from(format!("/home/logs/{name}.log")),
    }
}

/// Whoever speaks to a manager.
struct Caller {
    control: Box<dyn Control>,
    hello: Hello,
    id: u64,
    /// What was pushed.
    pushed: Vec<String>,
}

impl Caller {
    /// None when there is no answer.
    async fn greet(mut control: Box<dyn Control>) -> Option<Self> {
        let greeting = Greeting::Control {
            version: PROTOCOL_VERSION,
        };
        let bytes = frame::encode(&greeting).unwrap();
        control.write_all(&bytes).await.ok()?;
        let hello: Hello = read(&mut control).await?;
        Some(Self {
            control,
            hello,
            id: 0,
            pushed: Vec::new(),
        })
    }

    async fn call_within(
        &mut self,
        body: RequestBody,
        seconds: u64,
    ) -> Option<Result<ResponseBody, Failure>> {
        self.id += 1;
        let request = Request {
            id: self.id,
            deadline_ms: seconds * 1000,
            body,
        };
        let bytes = frame::encode(&request).unwrap();
        let written = timeout(LONG, self.control.write_all(&bytes)).await;
        written.ok()?.ok()?;
        loop {
            match read(&mut self.control).await? {
                FromManager::Response(response) if response.id == self.id => {
                    return Some(response.result);
                }
                FromManager::Response(_) => {}
                FromManager::Changed(changed) => {
                    let reason = changed.reason.unwrap_or_default();
                    let (target, message) = (changed.target, changed.message);
                    self.pushed.push(format!("{target} {reason}: {message}"));
                }
            }
        }
    }

    async fn call(&mut self, body: RequestBody) -> Result<ResponseBody, Failure> {
        self.call_within(body, 10).await.unwrap()
    }

    async fn ok(&mut self, body: RequestBody) -> ResponseBody {
        self.call(body).await.unwrap()
    }

    async fn refused(&mut self, body: RequestBody) -> String {
        let failure = self.call(body).await.unwrap_err();
        format!("{:?}: {}", failure.code, failure.message)
    }

    async fn inventory(&mut self) -> ManagerInventory {
        match self.ok(RequestBody::Inventory).await {
            ResponseBody::Inventory(inventory) => inventory,
            other => panic!("{other:?}"),
        }
    }

    async fn component(&mut self, instance: &str) -> ComponentInfo {
        let components = self.inventory().await.components;
        let found = components.into_iter().find(|c| c.instance == instance);
        found.unwrap_or_else(|| panic!("no {instance}"))
    }
}

async fn read<T: serde::de::DeserializeOwned>(control: &mut Box<dyn Control>) -> Option<T> {
    let read = async {
        let mut header = [0; 4];
        control.read_exact(&mut header).await.ok()?;
        let mut body = vec![0; frame::length(header).unwrap()];
        control.read_exact(&mut body).await.ok()?;
        Some(frame::decode(&body).unwrap())
    };
    timeout(LONG, read).await.ok().flatten()
}

fn load() -> RequestBody {
    RequestBody::LoadModule {
        type_name: "Relay".to_owned(),
        path: SimModule::new("Relay").path(),
        digest: Some("as told".to_owned()),
    }
}

fn create(instance: &str) -> RequestBody {
    create_with(instance, None)
}

fn create_with(instance: &str, on_disconnect: Option<&str>) -> RequestBody {
    RequestBody::Create(CreateRequest {
        instance: instance.to_owned(),
        type_name: "Relay".to_owned(),
        system: None,
        recreate_hash: "h".to_owned(),
        restarts: 0,
        sets: Default::default(),
        active: None,
        execution_kind: "periodic".to_owned(),
        rate: Some(10.0),
        log_path: "/home/logs/x.log".to_owned(),
        on_disconnect: on_disconnect.map(str::to_owned),
        stand_in: None,
        realtime: None,
        execution_context: None,
    })
}

fn activate(instance: &str) -> RequestBody {
    RequestBody::Activate {
        instance: instance.to_owned(),
    }
}

fn deactivate(instance: &str) -> RequestBody {
    RequestBody::Deactivate {
        instance: instance.to_owned(),
        by_hand: None,
    }
}

fn delete(instance: &str) -> RequestBody {
    RequestBody::Delete {
        instance: instance.to_owned(),
    }
}

fn bind(connector: &str, from: &str, to: &str) -> RequestBody {
    RequestBody::Bind(Binding {
        connector: connector.to_owned(),
        instance: to.to_owned(),
        port: "in".to_owned(),
        source: format!("{from}.out"),
    })
}

fn connect(connector: &str, from: &str, to: &str, incarnation: &str) -> ConnectRequest {
    ConnectRequest {
        connector: connector.to_owned(),
        instance: from.to_owned(),
        port: "out".to_owned(),
        target_instance: to.to_owned(),
        target_port: "in".to_owned(),
        target_socket: None,
        between_nodes: false,
        target_incarnation: incarnation.to_owned(),
        properties: Default::default(),
        by_hand: None,
    }
}

fn socket(name: &str) -> Option<String> {
    Some(folder(name).join(CONTROL_SOCKET).display().to_string())
}
