//! A machine without processes and a disk without files: managers are tasks that speak the control protocol, and hold
//! nothing but what hangs.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use futures_util::future::BoxFuture;
use rts_agent::StartError;
use rts_agent::launch::{Exit, ExitFuture, LaunchError, Start};
use rts_agent::machine::{Control, Family, Found, Launched, Machine, Signal, Tenant};
use rts_agent_api::messages::{ModuleDescription, ModuleFile, ModuleResolution};
use rts_host::disk::Disk;
use rts_manager_api::PROTOCOL_VERSION;
use rts_manager_api::control::{
    Busy, ComponentInfo, FromManager, Greeting, Hello, ManagerInventory, Request, RequestBody,
    Response, ResponseBody, SystemId,
};
use rts_manager_api::files::ManagerFile;
use rts_manager_api::frame;
use serde::de::DeserializeOwned;
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream, duplex};
use tokio::sync::watch;
use tokio::time::{Instant, sleep};

/// Bytes that are on their way at most.
const WAY: usize = 64 * 1024;

/// The managers of a node by run folder.
#[derive(Default)]
pub struct FakeMachine {
    folders: Mutex<BTreeMap<PathBuf, Option<Living>>>,
    started: Mutex<u32>,
    /// What a manager started does not die.
    pub undying: AtomicBool,
    /// Another agent has the node.
    pub taken: AtomicBool,
    hanging: Arc<Mutex<Option<Hanging>>>,
}

/// The component `Sine0` in all managers: a callback of it does not return.
#[derive(Debug, Clone)]
struct Hanging {
    callback: &'static str,
    since: Instant,
}

impl Hanging {
    fn info(&self, system: Option<SystemId>) -> ComponentInfo {
        let mut info: ComponentInfo = serde_json::from_value(serde_json::json!({
            "instance": "Sine0", "typeName": "Sine", "system": null, "incarnation": "s",
            "recreateHash": "h", "restarts": 0, "created": "", "state": "Error", "message": null,
            "sets": {}, "active": "default", "executionKind": "periodic", "rate": 1.0,
            "executions": 0, "ports": [], "connectors": [], "bindings": []
        }))
        .unwrap();
        let running = self.since.elapsed();
        // As the real one, which shows it after a second.
        info.busy = (running >= Duration::from_secs(1)).then(|| Busy {
            callback: self.callback.to_owned(),
            milliseconds: running.as_millis().try_into().unwrap(),
        });
        info.system = system;
        info
    }
}

/// True for what only the thread of a component can answer.
fn is_for_component(body: &RequestBody) -> bool {
    matches!(
        body,
        RequestBody::Activate { .. }
            | RequestBody::Deactivate { .. }
            | RequestBody::Reset { .. }
            | RequestBody::Delete { .. }
    )
}

/// A manager that runs.
#[derive(Debug, Clone)]
pub struct Living {
    pub file: ManagerFile,
    exit: watch::Sender<Option<Exit>>,
    hanging: Arc<Mutex<Option<Hanging>>>,
}

impl Living {
    /// Its process ends.
    pub fn end(&self, exit: Exit) {
        self.exit.send_replace(Some(exit));
    }

    fn exit(&self) -> ExitFuture {
        let mut exit = self.exit.subscribe();
        Box::pin(async move {
            let ended = exit.wait_for(Option::is_some).await;
            ended.ok().and_then(|exit| *exit).unwrap_or(Exit::Unknown)
        })
    }

    fn connect(&self) -> Box<dyn Control> {
        let (ours, theirs) = duplex(WAY);
        let (living, mut exit) = (self.clone(), self.exit.subscribe());
        tokio::spawn(async move {
            tokio::select! {
                biased;
                _ = exit.wait_for(Option::is_some) => {}
                _ = serve(theirs, &living) => {}
            }
        });
        Box::new(ours)
    }
}

impl Family for Living {
    fn pid(&self) -> u32 {
        self.file.pid
    }

    fn has_ended(&self) -> bool {
        self.exit.borrow().is_some()
    }

    fn signal(&self, signal: Signal) -> BoxFuture<'_, ()> {
        Box::pin(async move {
            if signal == Signal::Kill {
                self.end(Exit::Signal(9));
            }
        })
    }

    fn end(&self, _: Duration) -> BoxFuture<'_, bool> {
        Box::pin(async {
            self.signal(Signal::Kill).await;
            true
        })
    }
}

async fn serve(mut stream: DuplexStream, living: &Living) -> Option<()> {
    let Greeting::Control { .. } = read(&mut stream).await? else {
        return None;
    };
    let file = &living.file;
    let hello = Hello {
        version: PROTOCOL_VERSION,
        system: file.system.clone(),
        name: file.name.clone(),
        incarnation: file.incarnation.clone(),
        pid: file.pid,
        started: file.started.clone(),
    };
    stream.write_all(&frame::encode(&hello).ok()?).await.ok()?;
    loop {
        let request: Request = read(&mut stream).await?;
        let hanging = living.hanging.lock().unwrap().clone();
        let answer = match &request.body {
            RequestBody::Inventory => ResponseBody::Inventory(ManagerInventory {
                modules: BTreeSet::new(),
                opened: BTreeMap::new(),
                components: hanging
                    .map(|h| h.info(file.system.clone()))
                    .into_iter()
                    .collect(),
                taps: Vec::new(),
            }),
            RequestBody::Shutdown if hanging.is_some() => {
                sleep(Duration::from_millis(request.deadline_ms * 9 / 10)).await;
                ResponseBody::Done
            }
            body if hanging.is_some() && is_for_component(body) => continue,
            _ => ResponseBody::Done,
        };
        let response = FromManager::Response(Response {
            id: request.id,
            result: Ok(answer),
        });
        stream
            .write_all(&frame::encode(&response).ok()?)
            .await
            .ok()?;
        if request.body == RequestBody::Shutdown {
            living.end(Exit::Code(0));
        }
    }
}

async fn read<T: DeserializeOwned>(from: &mut DuplexStream) -> Option<T> {
    let mut header = [0; 4];
    from.read_exact(&mut header).await.ok()?;
    let mut body = vec![0; frame::length(header).ok()?];
    from.read_exact(&mut body).await.ok()?;
    frame::decode(&body).ok()
}

impl FakeMachine {
    /// From now on all managers have the component `Sine0`, which is in a callback.
    pub fn hang(&self, callback: &'static str) {
        let since = Instant::now();
        *self.hanging.lock().unwrap() = Some(Hanging { callback, since });
    }

    /// The manager of a run folder.
    pub fn living(&self, folder: &Path) -> Option<Living> {
        self.folders.lock().unwrap().get(folder).cloned().flatten()
    }

    /// All run folders.
    pub fn run_folders_now(&self) -> Vec<PathBuf> {
        self.folders.lock().unwrap().keys().cloned().collect()
    }

    fn launch_now(&self, start: &Start) -> Launched {
        let mut started = self.started.lock().unwrap();
        *started += 1;
        let living = Living {
            file: ManagerFile {
                protocol_version: PROTOCOL_VERSION,
                system: start.key.system.as_ref().map(|system| SystemId {
                    name: system.name.clone(),
                    uid: system.uid.clone(),
                }),
                name: start.key.name.clone(),
                incarnation: start.incarnation.clone(),
                pid: 1000 + *started,
                start_ticks: 0,
                boot_id: "boot".to_owned(),
                started: String::new(),
                cgroup: None,
            },
            exit: watch::Sender::new(None),
            hanging: self.hanging.clone(),
        };
        let mut folders = self.folders.lock().unwrap();
        folders.insert(start.folder.clone(), Some(living.clone()));
        Launched {
            control: living.connect(),
            exit: living.exit(),
            family: Box::new(living),
            log_start: 0,
        }
    }
}

impl Machine for FakeMachine {
    fn boot_id(&self) -> Option<String> {
        Some("boot".to_owned())
    }

    fn keep(&self) -> BoxFuture<'_, Result<(), StartError>> {
        Box::pin(async {
            if self.taken.load(Ordering::SeqCst) {
                let (node, lock) = ("local".to_owned(), "agent.lock".into());
                return Err(StartError::Running { node, lock });
            }
            Ok(())
        })
    }

    fn run_folders(&self) -> BoxFuture<'_, Vec<PathBuf>> {
        Box::pin(async { self.run_folders_now() })
    }

    fn look<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, io::Result<Tenant>> {
        Box::pin(async move {
            Ok(match self.folders.lock().unwrap().get(folder) {
                None => Tenant::None,
                Some(None) => Tenant::Gone(None),
                Some(Some(living)) if living.has_ended() => Tenant::Gone(Some(living.file.clone())),
                Some(Some(living)) => Tenant::Lives(living.file.clone()),
            })
        })
    }

    fn make_folder<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, io::Result<()>> {
        Box::pin(async move {
            self.folders.lock().unwrap().insert(folder.to_owned(), None);
            Ok(())
        })
    }

    fn remove_folder<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, ()> {
        Box::pin(async move {
            self.folders.lock().unwrap().remove(folder);
        })
    }

    fn bury<'a>(
        &'a self,
        folder: &'a Path,
        _: Option<ManagerFile>,
    ) -> BoxFuture<'a, io::Result<()>> {
        Box::pin(async move {
            self.remove_folder(folder).await;
            Ok(())
        })
    }

    fn bury_orphans(&self, _: Vec<PathBuf>) -> BoxFuture<'_, ()> {
        Box::pin(async {})
    }

    fn launch<'a>(&'a self, start: &'a Start) -> BoxFuture<'a, Result<Launched, LaunchError>> {
        Box::pin(async move {
            if self.undying.load(Ordering::SeqCst) {
                return Err(LaunchError::ending());
            }
            Ok(self.launch_now(start))
        })
    }

    fn find<'a>(
        &'a self,
        folder: &'a Path,
        _: &'a ManagerFile,
    ) -> BoxFuture<'a, io::Result<Found>> {
        Box::pin(async move {
            let living = self.living(folder);
            let living = living.ok_or(io::Error::from(io::ErrorKind::NotFound))?;
            Ok(Found {
                exit: living.exit(),
                family: Box::new(living),
            })
        })
    }

    fn connect<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, io::Result<Box<dyn Control>>> {
        Box::pin(async move {
            let living = self.living(folder).filter(|living| !living.has_ended());
            let refused = io::Error::from(io::ErrorKind::ConnectionRefused);
            Ok(living.ok_or(refused)?.connect())
        })
    }

    fn log_end<'a>(&'a self, _: &'a Start, _: u64, _: usize) -> BoxFuture<'a, String> {
        Box::pin(async { String::new() })
    }

    fn resolve<'a>(&'a self, type_name: &'a str) -> BoxFuture<'a, io::Result<ModuleResolution>> {
        Box::pin(async move {
            let module = (type_name == "Sine").then(|| ModuleFile {
                path: "/libsine.so".to_owned(),
                digest: "1".to_owned(),
                description: None,
            });
            Ok(ModuleResolution {
                type_name: type_name.to_owned(),
                module,
                searched: vec!["/libsine.so".to_owned()],
            })
        })
    }

    fn describe<'a>(
        &'a self,
        _: &'a ModuleFile,
        _: &'a str,
    ) -> BoxFuture<'a, Option<ModuleDescription>> {
        Box::pin(async {
            Some(ModuleDescription {
                ports: Vec::new(),
                parameters: BTreeMap::from([("gain".to_owned(), "1".to_owned())]),
                limits: BTreeMap::new(),
            })
        })
    }
}

/// Files in memory.
#[derive(Default)]
pub struct FakeDisk(pub Mutex<BTreeMap<PathBuf, Vec<u8>>>);

impl Disk for FakeDisk {
    fn read<'a>(&'a self, path: &'a Path, _: u64) -> BoxFuture<'a, io::Result<Option<Vec<u8>>>> {
        Box::pin(async move { Ok(self.0.lock().unwrap().get(path).cloned()) })
    }

    fn write<'a>(&'a self, path: &'a Path, bytes: Vec<u8>) -> BoxFuture<'a, io::Result<()>> {
        Box::pin(async move {
            self.0.lock().unwrap().insert(path.to_owned(), bytes);
            Ok(())
        })
    }

    fn sync<'a>(&'a self, _: &'a Path) -> BoxFuture<'a, io::Result<()>> {
        Box::pin(async { Ok(()) })
    }

    fn write_over<'a>(&'a self, path: &'a Path, bytes: Vec<u8>) -> BoxFuture<'a, io::Result<()>> {
        Box::pin(async move {
            let mut files = self.0.lock().unwrap();
            let old = files.get(path).ok_or(io::ErrorKind::NotFound)?;
            let behind = old.get(bytes.len()..).unwrap_or_default();
            let new = [&bytes, behind].concat();
            files.insert(path.to_owned(), new);
            Ok(())
        })
    }

    fn rename<'a>(&'a self, from: &'a Path, to: &'a Path) -> BoxFuture<'a, io::Result<()>> {
        Box::pin(async move {
            let mut files = self.0.lock().unwrap();
            let bytes = files.remove(from);
            let bytes = bytes.ok_or(io::Error::from(io::ErrorKind::NotFound))?;
            files.insert(to.to_owned(), bytes);
            Ok(())
        })
    }

    fn sync_folder<'a>(&'a self, _: &'a Path) -> BoxFuture<'a, io::Result<()>> {
        Box::pin(async { Ok(()) })
    }
}

/// Shared by the agents of a node, one after the other.
#[derive(Clone, Default)]
pub struct FakeNode {
    pub machine: Arc<FakeMachine>,
    pub disk: Arc<FakeDisk>,
}
