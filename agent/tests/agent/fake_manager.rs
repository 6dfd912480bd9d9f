//! A process that speaks the control protocol and holds pretended components. It is this very test program, started
//! again through a script.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::os::fd::AsFd;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use rts_manager_api::PROTOCOL_VERSION;
use rts_manager_api::control::{
    Binding, BindingInfo, Busy, ByHandInfo, ComponentInfo, ConnectorInfo, CreateRequest,
    ExecutionContextInfo, Failure, FailureCode, FromManager, Greeting, Hello, ManagerInventory,
    ModuleInfo, PortInfo, RealtimeInfo, Request, RequestBody, Response, ResponseBody, SystemId,
};
use rts_manager_api::files::{CONTROL_SOCKET, LOCK, MANAGER_JSON, ManagerFile};
use rts_manager_api::frame;

/// Writes a script that can be started as a manager program. `behaviour` is empty, `early`, `grandchild`, `old` or
/// `future`.
pub fn program(folder: &Path, behaviour: &str) -> PathBuf {
    use std::os::unix::fs::PermissionsExt;
    let path = folder.join("fake-manager");
    let test = std::env::current_exe().unwrap();
    let before = match behaviour {
        "grandchild" => "sleep 1000 &",
        _ => "",
    };
    let text = format!(
        "#!/bin/sh\n{before}\nexport RTS_FAKE_BEHAVIOUR={behaviour} RTS_FAKE_ARGS=\"$*\"\nexec '{}' --exact fake_manager::process --ignored --nocapture --test-threads=1\n",
        test.display()
    );
    std::fs::write(&path, text).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o700)).unwrap();
    path
}

/// Not a test of its own: what the script runs.
#[test]
#[ignore = "started by other tests as a manager"]
fn process() {
    let args = std::env::var("RTS_FAKE_ARGS").expect("is started by a script");
    if std::env::var("RTS_FAKE_BEHAVIOUR").as_deref() == Ok("early") {
        eprintln!("cannot find my library");
        std::process::exit(3);
    }
    serve(&args);
}

#[derive(Default)]
struct Contents {
    modules: BTreeMap<String, String>,
    components: BTreeMap<String, ComponentInfo>,
}

struct Fake {
    hello: Hello,
    /// Where it notes whom it activates.
    notes: PathBuf,
    contents: Mutex<Contents>,
}

fn serve(args: &str) {
    let args: Vec<&str> = args.split(' ').collect();
    let option = |name: &str| {
        let at = args.iter().position(|a| *a == name)?;
        args.get(at + 1).map(|v| (*v).to_owned())
    };
    let dir = PathBuf::from(option("--dir").unwrap());
    let system = option("--system-name").map(|name| SystemId {
        name,
        uid: option("--system-uid").unwrap(),
    });
    let lock = File::create(dir.join(LOCK)).unwrap();
    rustix::fs::flock(&lock, rustix::fs::FlockOperation::LockExclusive).unwrap();
    let hello = Hello {
        version: version(),
        system,
        name: option("--name").unwrap(),
        incarnation: option("--incarnation").unwrap(),
        pid: std::process::id(),
        started: "2026-01-01T00:00:00Z".to_owned(),
    };
    describe(&dir, &hello);
    let listener = UnixListener::bind(dir.join(CONTROL_SOCKET)).unwrap();
    let fake = Arc::new(Fake {
        hello,
        notes: dir.ancestors().nth(3).unwrap().join("activated"),
        contents: Mutex::default(),
    });
    let stdin = std::io::stdin().as_fd().try_clone_to_owned().unwrap();
    let first = fake.clone();
    std::thread::spawn(move || first.converse(UnixStream::from(stdin)));
    for stream in listener.incoming().flatten() {
        let fake = fake.clone();
        std::thread::spawn(move || fake.converse(stream));
    }
}

/// What it speaks.
fn version() -> u32 {
    match std::env::var("RTS_FAKE_BEHAVIOUR").as_deref() {
        Ok("old") => 1,
        Ok("future") => 9,
        _ => PROTOCOL_VERSION,
    }
}

fn describe(dir: &Path, hello: &Hello) {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap();
    let fields = stat.rsplit_once(") ").unwrap().1;
    let boot_id = std::fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap();
    let file = ManagerFile {
        protocol_version: hello.version,
        system: hello.system.clone(),
        name: hello.name.clone(),
        incarnation: hello.incarnation.clone(),
        pid: hello.pid,
        start_ticks: fields.split(' ').nth(19).unwrap().parse().unwrap(),
        boot_id: boot_id.trim().to_owned(),
        started: hello.started.clone(),
        cgroup: None,
    };
    let path = dir.join(MANAGER_JSON);
    std::fs::write(path, serde_json::to_vec(&file).unwrap()).unwrap();
}

fn refused(code: FailureCode, message: &str) -> Result<ResponseBody, Failure> {
    Err(Failure {
        code,
        message: message.to_owned(),
    })
}

impl Fake {
    fn converse(&self, mut stream: UnixStream) {
        let mut from = stream.try_clone().unwrap();
        if frame::read::<Greeting>(&mut from).is_err() {
            return;
        }
        frame::write(&mut stream, &self.hello).unwrap();
        while let Ok(request) = frame::read::<Request>(&mut from) {
            let last = request.body == RequestBody::Shutdown;
            let response = Response {
                id: request.id,
                result: self.answer(request.body),
            };
            if frame::write(&mut stream, &FromManager::Response(response)).is_err() {
                return;
            }
            if last {
                std::process::exit(0);
            }
        }
    }

    fn answer(&self, body: RequestBody) -> Result<ResponseBody, Failure> {
        if self.hello.version == 1 && body != body.clone().for_version(1) {
            return refused(FailureCode::Invalid, "a field that version 1 does not have");
        }
        let mut contents = self.contents.lock().unwrap();
        let Contents {
            modules,
            components,
        } = &mut *contents;
        match body {
            RequestBody::LoadModule {
                type_name, path, ..
            } => {
                modules.insert(type_name.clone(), path.clone());
                return Ok(ResponseBody::Module(Box::new(module(&type_name, &path))));
            }
            RequestBody::UnloadModule { type_name } => {
                if modules.remove(&type_name).is_none() {
                    return refused(FailureCode::NotFound, "no such module");
                }
            }
            RequestBody::Factories => {
                let all = modules.iter().map(|(name, path)| module(name, path));
                return Ok(ResponseBody::Modules(all.collect()));
            }
            RequestBody::Create(request) => {
                if components.contains_key(&request.instance) {
                    return refused(FailureCode::Conflict, "it exists");
                }
                let mut values = request.sets.values().flatten();
                if values.any(|(name, _)| name == "refuse") {
                    return refused(FailureCode::Invalid, "no such parameter");
                }
                if request.type_name == "Crash" {
                    std::process::abort();
                }
                let info = component(request);
                let incarnation = info.incarnation.clone();
                let is_late = has(&info, "late");
                components.insert(info.instance.clone(), info);
                if is_late {
                    return refused(FailureCode::Deadline, "on_initialize still runs");
                }
                return Ok(ResponseBody::Created { incarnation });
            }
            RequestBody::Bind(binding) => {
                let Some(component) = components.get_mut(&binding.instance) else {
                    return refused(FailureCode::NotFound, "no such component");
                };
                component
                    .bindings
                    .retain(|b| b.connector != binding.connector);
                component.bindings.push(bound(binding));
                let incarnation = component.incarnation.clone();
                return Ok(ResponseBody::Bound { incarnation });
            }
            RequestBody::Unbind { connector } => {
                for component in components.values_mut() {
                    component.bindings.retain(|b| b.connector != connector);
                }
            }
            RequestBody::Tick { instance, cycles } => match components.get_mut(&instance) {
                Some(component) => component.executions += u64::from(cycles),
                None => return refused(FailureCode::NotFound, "no such component"),
            },
            RequestBody::Connect(request) => {
                if request.target_socket.is_none()
                    && let Some(target) = components.get_mut(&request.target_instance)
                {
                    if target.incarnation != request.target_incarnation {
                        return refused(FailureCode::Conflict, "another incarnation");
                    }
                    let mut bindings = target.bindings.iter();
                    if !bindings.any(|b| b.connector == request.connector) {
                        target.bindings.push(bound(Binding {
                            connector: request.connector.clone(),
                            instance: request.target_instance.clone(),
                            port: request.target_port.clone(),
                            source: format!("{}.{}", request.instance, request.port),
                        }));
                    }
                }
                let Some(component) = components.get_mut(&request.instance) else {
                    return refused(FailureCode::NotFound, "no such component");
                };
                if component
                    .connectors
                    .iter()
                    .any(|c| c.name == request.connector)
                {
                    return refused(FailureCode::Conflict, "connected already");
                }
                if let Some(marks) = &mut component.by_hand {
                    marks.disconnected.remove(&request.connector);
                }
                component.connectors.push(ConnectorInfo {
                    name: request.connector,
                    port: request.port,
                    target_instance: request.target_instance,
                    target_port: request.target_port,
                    target_incarnation: request.target_incarnation,
                    properties: request.properties,
                    by_hand: request.by_hand,
                    state: "Connected".to_owned(),
                    transport: match &request.target_socket {
                        Some(_) => "uds".to_owned(),
                        None => "direct".to_owned(),
                    },
                    samples_sent: 9,
                    bytes: 0,
                    drops: 0,
                    refused: 0,
                    rate: 0,
                });
            }
            RequestBody::Disconnect {
                instance,
                connector,
                by_hand,
            } => {
                if let Some(component) = components.get_mut(&instance) {
                    component.connectors.retain(|c| c.name != connector);
                    if let Some(marks) = &mut component.by_hand {
                        let mark = by_hand.map(|mark| (connector, mark));
                        marks.disconnected.extend(mark);
                    }
                }
            }
            RequestBody::Configure {
                instance,
                sets,
                active,
                on_disconnect,
                order,
                by_hand,
                ..
            } => match components.get_mut(&instance) {
                Some(component) => {
                    if sets.values().flatten().any(|(name, _)| name == "refuse") {
                        return refused(FailureCode::Invalid, "it is out of range");
                    }
                    // As the real one: what sets no value leaves the mark.
                    let marks_too = !sets.is_empty() || active.is_some() || by_hand.is_some();
                    if let Some(marks) = component.by_hand.as_mut().filter(|_| marks_too) {
                        marks.configured = by_hand;
                    }
                    for (set, values) in sets {
                        component.sets.entry(set).or_default().extend(values);
                    }
                    if let Some(active) = active {
                        component.active = active;
                    }
                    component.busy = busy(component);
                    if let (Some(order), Some(shared)) = (order, &mut component.execution_context) {
                        shared.order = order;
                    }
                    if on_disconnect.is_some() {
                        component.on_disconnect = on_disconnect;
                    }
                }
                None => return refused(FailureCode::NotFound, "no such component"),
            },
            RequestBody::Activate { instance } => {
                note(&self.notes, &instance);
                mark_deactivated(components, &instance, None);
                return turn(components, &instance, "Active");
            }
            RequestBody::Deactivate { instance, by_hand } => {
                mark_deactivated(components, &instance, by_hand);
                return turn(components, &instance, "Inactive");
            }
            RequestBody::Reset { instance } => {
                return turn(components, &instance, "Inactive");
            }
            RequestBody::Delete { instance } => {
                if components.get(&instance).is_some_and(|c| has(c, "stays")) {
                    return refused(FailureCode::Deadline, "on_finalize still runs");
                }
                components.remove(&instance);
            }
            // The real one forgets only what is still so.
            RequestBody::Forget {
                instance,
                by_hand,
                connectors,
            } => {
                if let Some(component) = components.get_mut(&instance) {
                    forget(component, &by_hand, &connectors);
                }
            }
            RequestBody::Inventory => {
                for component in components.values_mut() {
                    component.executions += 1;
                }
                return Ok(ResponseBody::Inventory(ManagerInventory {
                    modules: modules.keys().cloned().collect(),
                    opened: Default::default(),
                    components: components.values().cloned().collect(),
                    taps: Vec::new(),
                }));
            }
            RequestBody::Shutdown => {}
        }
        Ok(ResponseBody::Done)
    }
}

fn forget(
    component: &mut ComponentInfo,
    by_hand: &ByHandInfo,
    connectors: &BTreeMap<String, String>,
) {
    for connector in &mut component.connectors {
        if connectors.contains_key(&connector.name) {
            connector.by_hand = None;
        }
    }
    if let Some(marks) = &mut component.by_hand {
        if by_hand.configured.is_some() {
            marks.configured = None;
        }
        if by_hand.deactivated.is_some() {
            marks.deactivated = None;
        }
        marks
            .disconnected
            .retain(|name, _| !by_hand.disconnected.contains_key(name));
    }
}

fn mark_deactivated(
    components: &mut BTreeMap<String, ComponentInfo>,
    instance: &str,
    mark: Option<String>,
) {
    let component = components.get_mut(instance);
    if let Some(marks) = component.and_then(|c| c.by_hand.as_mut()) {
        marks.deactivated = mark;
    }
}

fn turn(
    components: &mut BTreeMap<String, ComponentInfo>,
    instance: &str,
    state: &str,
) -> Result<ResponseBody, Failure> {
    match components.get_mut(instance) {
        Some(component) => {
            component.state = state.to_owned();
            Ok(ResponseBody::Done)
        }
        None => refused(FailureCode::NotFound, "no such component"),
    }
}

fn note(notes: &Path, instance: &str) {
    let file = File::options().append(true).create(true).open(notes);
    writeln!(file.unwrap(), "{instance}").unwrap();
}

/// True when it has this parameter.
fn has(component: &ComponentInfo, parameter: &str) -> bool {
    let mut sets = component.sets.values();
    sets.any(|set| set.contains_key(parameter))
}

/// What its parameter `busy` pretends: `on_execute 11900`.
fn busy(component: &ComponentInfo) -> Option<Busy> {
    let mut values = component.sets.values();
    let (callback, milliseconds) = values.find_map(|set| set.get("busy"))?.split_once(' ')?;
    Some(Busy {
        callback: callback.to_owned(),
        milliseconds: milliseconds.parse().unwrap(),
    })
}

fn bound(binding: Binding) -> BindingInfo {
    BindingInfo {
        connector: binding.connector,
        port: binding.port,
        source: Some(binding.source),
        connected: true,
        samples_received: 7,
        drops: 0,
        gaps: 0,
        latency: None,
    }
}

fn component(request: CreateRequest) -> ComponentInfo {
    let mut log = File::options()
        .append(true)
        .create(true)
        .open(&request.log_path)
        .unwrap();
    writeln!(log, "created {}", request.instance).unwrap();
    let mut info = ComponentInfo {
        incarnation: uuid::Uuid::new_v4().to_string(),
        recreate_hash: request.recreate_hash,
        stand_in: request.stand_in.is_some(),
        on_disconnect: request.on_disconnect,
        restarts: request.restarts,
        created: "2026-01-01T00:00:00Z".to_owned(),
        state: "Inactive".to_owned(),
        message: None,
        defaults: BTreeMap::new(),
        busy: None,
        sets: request.sets,
        active: request.active.unwrap_or("default".to_owned()),
        // Its modules all want the same.
        execution_kind: match request.execution_kind.as_str() {
            "" => "eventDriven".to_owned(),
            kind => kind.to_owned(),
        },
        execution_context: request
            .execution_context
            .map(|shared| ExecutionContextInfo {
                name: shared.name,
                order: shared.order,
                shared_state: shared.shared_state,
                members: Vec::new(),
            }),
        rate: request.rate.unwrap_or(1000.0),
        executions: 0,
        timing: None,
        realtime: request.realtime.map(|asked| RealtimeInfo {
            asked,
            ..RealtimeInfo::default()
        }),
        ports: vec![
            PortInfo {
                name: "in".to_owned(),
                direction: "in".to_owned(),
                data_type: "IDL:RTC/TimedDouble:1.0".to_owned(),
            },
            PortInfo {
                name: "out".to_owned(),
                direction: "out".to_owned(),
                data_type: "IDL:RTC/TimedDouble:1.0".to_owned(),
            },
        ],
        connectors: Vec::new(),
        bindings: Vec::new(),
        by_hand: (version() > 1).then(ByHandInfo::default),
        instance: request.instance,
        type_name: request.type_name,
        system: request.system,
    };
    info.busy = busy(&info);
    info
}

fn module(type_name: &str, path: &str) -> ModuleInfo {
    ModuleInfo {
        type_name: type_name.to_owned(),
        vendor: "test".to_owned(),
        category: "test".to_owned(),
        version: "1.0".to_owned(),
        description: "pretends".to_owned(),
        path: path.to_owned(),
        ports: vec![PortInfo {
            name: "out".to_owned(),
            direction: "out".to_owned(),
            data_type: "IDL:RTC/TimedDouble:1.0".to_owned(),
        }],
        ..ModuleInfo::default()
    }
}
