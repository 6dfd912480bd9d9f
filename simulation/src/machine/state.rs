//! All that there is on a machine.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rts_agent::launch::Exit;
use rts_manager_api::control::{
    Binding, ByHandInfo, Changed, ConnectRequest, ExecutionContextRequest, FromManager, Hello,
    PortInfo, RealtimeInfo, SystemId,
};
use rts_manager_api::files::ManagerFile;
use rts_plan::desired::ManagerKey;
use tokio::sync::{mpsc, watch};
use tokio::time::Instant;

use super::configuration::Configuration;
use super::far::Parted;
use crate::faults::Misbehaviour;
use crate::modules::{Modules, SimModule};
use crate::truth::{Happened, Subject};

/// Everything on the machine.
#[derive(Debug)]
pub(super) struct State {
    pub node: String,
    pub boot_id: String,
    /// Of the process that was started last.
    pub pid: u32,
    /// Numbers processes and connections, never one twice.
    pub numbers: u64,
    pub folders: BTreeMap<PathBuf, Folder>,
    /// By number; one that has ended stays as long as something that it started is left.
    pub processes: BTreeMap<u64, Process>,
    pub logs: BTreeMap<PathBuf, String>,
    pub modules: Modules,
    pub misbehaviours: BTreeMap<String, Misbehaviour>,
    pub fails_to_start: bool,
    /// Probability that a process starts one of its own.
    pub grandchildren: f64,
    /// What has happened and was not told yet.
    pub news: Vec<Happened>,
    /// Losses that components are to act on.
    pub losses: Vec<Loss>,
    /// Ends that were closed, whose other ends are on other machines and were not told yet.
    pub parted: Vec<Parted>,
    /// Until when counters are right.
    pub counted: Instant,
}

/// A run folder.
#[derive(Debug)]
pub(super) struct Folder {
    /// When something in it changed last.
    pub changed: Instant,
    /// Its description.
    pub file: Option<ManagerFile>,
}

/// How a process is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Run {
    Runs,
    /// It is stopped, and answers nobody.
    Hangs,
    Ended(Exit),
}

/// A manager's process.
#[derive(Debug)]
pub(super) struct Process {
    pub number: u64,
    pub key: ManagerKey,
    pub hello: Hello,
    pub start_ticks: u64,
    pub folder: PathBuf,
    /// It has the lock of its folder, and its socket.
    pub serves: bool,
    pub run: watch::Sender<Run>,
    /// It was told to end.
    pub stopping: bool,
    pub grandchildren: u32,
    /// A fault has hit it.
    pub blemished: bool,
    /// Why it has ended, and all that it started is not gone yet.
    pub ended: Option<crate::truth::Cause>,
    /// Open modules by type name.
    pub modules: BTreeMap<String, SimModule>,
    /// Type name → digest, as told.
    pub opened: BTreeMap<String, String>,
    /// Path → digest of the file that was there when it was opened.
    pub stamps: BTreeMap<String, String>,
    pub components: BTreeMap<String, Component>,
    /// In-port ends by connector.
    pub ends: BTreeMap<String, End>,
    /// Control connections.
    pub listeners: Vec<mpsc::Sender<FromManager>>,
}

/// State of a component's life cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LifeCycle {
    Created,
    Inactive,
    Active,
    Error,
}

impl LifeCycle {
    pub fn name(self) -> &'static str {
        match self {
            Self::Created => "Created",
            Self::Inactive => "Inactive",
            Self::Active => "Active",
            Self::Error => "Error",
        }
    }
}

/// A component.
#[derive(Debug)]
pub(super) struct Component {
    pub subject: Subject,
    pub type_name: String,
    pub stand_in: bool,
    pub ports: Vec<PortInfo>,
    pub system: Option<SystemId>,
    pub restarts: u32,
    pub created: String,
    pub state: LifeCycle,
    pub message: Option<String>,
    pub configuration: Configuration,
    pub rate: f64,
    /// `keep`, `deactivate` or `stop`.
    pub on_disconnect: String,
    pub realtime: Option<RealtimeInfo>,
    pub by_hand: ByHandInfo,
    /// It is being deleted: no end is added any more.
    pub leaving: bool,
    /// The callback that runs, and since when.
    pub busy: Option<(&'static str, Instant)>,
    /// Had by whoever makes it do something: its thread.
    pub turn: Arc<tokio::sync::Mutex<()>>,
    /// A peer was lost, and it did not act on that yet.
    pub lost: bool,
    /// The execution context that it shares.
    pub shared: Option<Box<ExecutionContextRequest>>,
    pub executions: f64,
    pub connectors: BTreeMap<String, Connector>,
}

/// The loss of a peer that a component has to act on.
#[derive(Debug)]
pub(super) struct Loss {
    pub at: At,
    /// It is to be deleted for it, not only deactivated.
    pub stops: bool,
    pub reason: String,
    pub cause: crate::truth::Cause,
}

/// How a connection ends at a side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Parting {
    GoodBye,
    Loss,
}

/// A connector at its out-port end.
#[derive(Debug)]
pub(super) struct Connector {
    /// Names this one of all of its name.
    pub number: u64,
    /// As given, without the mark.
    pub request: ConnectRequest,
    pub by_hand: Option<String>,
    /// The one whose place it takes was lost.
    pub replaces_lost: bool,
    pub link: Link,
    pub sent: f64,
}

/// How a connector is connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Link {
    Connecting,
    /// With the in-port end in this process, which may be on another machine.
    Open(u64),
    Closed(Parting),
}

impl Connector {
    pub fn state(&self) -> &'static str {
        match self.link {
            Link::Connecting => "Connecting",
            Link::Open(_) => "Connected",
            Link::Closed(_) => "Disconnected",
        }
    }

    pub fn is_lost(&self) -> bool {
        match self.link {
            Link::Connecting => self.replaces_lost,
            Link::Open(_) => false,
            Link::Closed(parting) => parting == Parting::Loss,
        }
    }
}

/// An in-port end.
#[derive(Debug)]
pub(super) struct End {
    pub binding: Binding,
    /// Of the component with the in-port.
    pub incarnation: String,
    pub source: Option<Source>,
}

/// What an in-port end is, or was, connected to.
#[derive(Debug)]
pub(super) struct Source {
    /// Number of the connector.
    pub number: u64,
    /// Process of the out-port end, which may be on another machine.
    pub process: u64,
    /// How it ended; none while it is open.
    pub closed: Option<Parting>,
    pub received: f64,
}

impl Process {
    pub fn lives(&self) -> bool {
        !matches!(*self.run.borrow(), Run::Ended(_))
    }

    pub fn runs(&self) -> bool {
        *self.run.borrow() == Run::Runs
    }

    /// Tells all control connections that something changed. One that takes nothing asks for the inventory anyway.
    pub fn changed(&mut self, target: String, message: String, reason: Option<&str>) {
        let changed = FromManager::Changed(Changed {
            target,
            message,
            reason: reason.map(str::to_owned),
        });
        self.listeners.retain(|listener| !listener.is_closed());
        for listener in &self.listeners {
            let _ = listener.try_send(changed.clone());
        }
    }

    /// True for the process that a description speaks of.
    pub fn is(&self, file: &ManagerFile, boot_id: &str) -> bool {
        self.hello.pid == file.pid
            && self.start_ticks == file.start_ticks
            && file.boot_id == boot_id
    }
}

impl State {
    pub fn number(&mut self) -> u64 {
        self.numbers += 1;
        self.numbers
    }

    /// The live process that has a folder's lock.
    pub fn tenant(&self, folder: &Path) -> Option<&Process> {
        let mut all = self.processes.values();
        all.find(|p| p.serves && p.lives() && p.folder == folder)
    }

    /// A live process.
    pub fn living(&mut self, number: u64) -> Option<&mut Process> {
        self.processes.get_mut(&number).filter(|p| p.lives())
    }

    /// A component of a live process, by its name and incarnation.
    pub fn component(&mut self, at: &At) -> Option<&mut Component> {
        let process = self.living(at.process)?;
        let component = process.components.get_mut(&at.instance)?;
        (component.subject.incarnation == at.incarnation).then_some(component)
    }

    /// Tells that a fault hit a process, or a component in it.
    pub fn blemish(&mut self, number: u64, instance: Option<&str>, what: String) {
        let Some(process) = self.processes.get_mut(&number) else {
            return;
        };
        process.blemished |= instance.is_none();
        let (node, process) = (self.node.clone(), process.hello.incarnation.clone());
        self.news.push(Happened::Blemished {
            node,
            process,
            instance: instance.map(str::to_owned),
            what,
        });
    }
}

impl Component {
    /// Names it.
    pub fn at(&self, process: u64) -> At {
        At {
            process,
            instance: self.subject.instance.clone(),
            incarnation: self.subject.incarnation.clone(),
        }
    }
}

/// The callback of each tick.
pub(super) const EXECUTE: &str = "on_execute";

/// Names a component for as long as it lives.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct At {
    pub process: u64,
    pub instance: String,
    pub incarnation: String,
}

/// Processes have greater numbers; after each boot the same ones again.
pub(super) const FIRST_PID: u32 = 1000;
