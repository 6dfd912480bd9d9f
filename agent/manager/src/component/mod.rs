//! A component: what everyone may see of it, and the execution context that runs it.

mod by_hand;
mod configuration;
mod context;
mod host;
mod instance;
mod lifecycle;
mod loans;
mod loss;
mod member;
mod order;
mod realtime;
mod reply;
mod run;
mod spawn;
mod steps;
mod timing;
mod together;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use std::thread::Thread;
use std::time::{Duration, Instant};

use rts_manager_api::control::{
    self, ByHandInfo, ComponentInfo, ConnectorInfo, Failure, FailureCode, RealtimeInfo,
    RealtimeRequest, SystemId,
};
use rts_schemas::system::OnDisconnect;

pub use self::configuration::Configuration;
use self::context::WantedRate;
pub use self::context::{Contexts, ExecutionContext};
pub use self::lifecycle::State;
use self::loss::Loss;
pub use self::loss::policy;
pub use self::reply::Pending;
use self::reply::{Missing, Reply, reply};
pub use self::spawn::begin;
use self::timing::Timing;
use crate::data::connector::Connector;
use crate::data::in_port::InPort;
use crate::data::out_port::OutPort;
use crate::failure::{failure, list, not_found};
use crate::log_file::LogFile;
use crate::module::{Execution, Module};
use crate::sync::lock;

/// A call into the module that takes this long is shown.
const HANGS: Duration = Duration::from_secs(1);

/// What a component is made from and called; never changes.
#[derive(Debug)]
pub struct Identity {
    /// Instance name.
    pub instance: String,
    /// Unique id of this creation.
    pub incarnation: String,
    /// System that it was created for.
    pub system: Option<SystemId>,
    /// As given at creation.
    pub recreate_hash: String,
    /// As given at creation.
    pub restarts: u32,
    /// Wall-clock creation, RFC 3339.
    pub created: String,
    /// Name of the composite whose members share their state with it.
    pub shared_state: Option<String>,
}

/// A component.
#[derive(Debug)]
pub struct Component {
    /// What it is.
    pub identity: Identity,
    /// Its module.
    pub module: Arc<Module>,
    /// What runs it.
    pub context: Arc<ExecutionContext>,
    /// Its ports, by their index in the ABI.
    pub ports: Vec<PortEnd>,
    status: Mutex<Status>,
    busy: Mutex<Option<Busy>>,
    executions: AtomicU64,
    timing: Timing,
    /// What its execution context has of the machine; empty where nothing was asked for.
    realtime: OnceLock<RealtimeInfo>,
    /// A cycle of it was asked for, of an event-driven execution context.
    woken: AtomicBool,
    /// Its log.
    pub log: LogFile,
    /// The loss of a peer that it has still to act on.
    loss: Mutex<Option<Loss>>,
    /// Held while a connector is exchanged for another of its name; never while anything is waited for.
    pub wiring: Mutex<()>,
}

/// A port of a component.
#[derive(Debug)]
pub enum PortEnd {
    /// Reads.
    In(Arc<InPort>),
    /// Writes.
    Out(OutPort),
}

#[derive(Debug)]
struct Status {
    state: State,
    message: Option<String>,
    configuration: Configuration,
    on_disconnect: OnDisconnect,
    by_hand: ByHandInfo,
    /// Set before its ends are taken away, so that none is added afterwards.
    leaving: bool,
}

/// The call into the module that its thread is in.
#[derive(Debug, Clone, Copy)]
struct Busy {
    call: &'static str,
    since: Instant,
}

/// What wakes the thread of an execution context.
#[derive(Debug)]
pub enum Order {
    /// Run a new component.
    Join(Joining),
    /// Carry out a request.
    Obey(Command),
    /// A peer of one of its components was lost.
    Attend,
    /// A cycle was asked for.
    Wake,
}

impl Order {
    /// Whether somebody waits for an answer.
    fn asks(&self) -> bool {
        matches!(self, Self::Join(_) | Self::Obey(_))
    }
}

/// A component that is to be initialised and run.
#[derive(Debug)]
pub struct Joining {
    component: Arc<Component>,
    rate: WantedRate,
    /// What it is to have of the machine.
    realtime: Option<RealtimeRequest>,
    deadline: Instant,
    reply: Reply,
}

/// A request that concerns one component.
#[derive(Debug)]
pub struct Command {
    component: Arc<Component>,
    action: Action,
    deadline: Instant,
    reply: Reply,
}

/// What to do with a component.
#[derive(Debug, Clone)]
pub enum Action {
    /// Activate.
    Activate,
    /// Deactivate.
    Deactivate {
        /// The mark of the person who does it.
        by_hand: Option<String>,
    },
    /// Error → Inactive.
    Reset,
    /// Run cycles, when it is driven from outside.
    Tick {
        /// How many.
        cycles: u32,
    },
    /// Finalise and delete.
    Delete,
    /// Change in place.
    Configure {
        /// What.
        change: Box<Change>,
        /// The mark of the person who does it.
        by_hand: Option<String>,
    },
}

/// What is to be changed in place; what is not named stays.
#[derive(Debug, Clone, Default)]
pub struct Change {
    /// Set → parameter → value.
    pub sets: BTreeMap<String, BTreeMap<String, String>>,
    /// New active set.
    pub active: Option<String>,
    /// New rate in Hz of its execution context.
    pub rate: Option<f64>,
    /// New policy.
    pub on_disconnect: Option<OnDisconnect>,
    /// New place in the order of its execution context.
    pub order: Option<i32>,
}

impl Change {
    /// Whether it sets something that a person may have set.
    fn sets_values(&self) -> bool {
        !self.sets.is_empty() || self.active.is_some()
    }
}

impl Component {
    /// Hands a request to its thread, which unparks the `waker` when it has answered.
    pub fn ask(
        self: &Arc<Self>,
        action: Action,
        deadline: Instant,
        waker: Option<Thread>,
    ) -> Result<Pending, Failure> {
        let (reply, pending) = reply(deadline, waker);
        self.tell(Order::Obey(Command {
            component: Arc::clone(self),
            action,
            deadline,
            reply,
        }))?;
        Ok(pending)
    }

    /// Waits for an answer until the request's deadline.
    pub fn wait(&self, pending: &Pending) -> Result<(), Failure> {
        let missing = |missing| self.unanswered(missing);
        pending.wait().unwrap_or_else(|e| Err(missing(e)))
    }

    /// The answer if there is one by now, or when it is too late for one.
    pub fn look(&self, pending: &Pending) -> Option<Result<(), Failure>> {
        match pending.look() {
            Ok(answer) => Some(answer),
            Err(Missing::Yet) => None,
            Err(missing) => Some(Err(self.unanswered(missing))),
        }
    }

    fn unanswered(&self, missing: Missing) -> Failure {
        match missing {
            Missing::Yet | Missing::Late => self.late("did not answer in time"),
            Missing::Gone => self.gone(),
        }
    }

    /// The answer to a request that has not been carried out in time.
    fn late(&self, otherwise: &str) -> Failure {
        let name = &self.identity.instance;
        let own = (*lock(&self.busy)).map(|Busy { call, since }| {
            let running = since.elapsed().as_secs_f64();
            format!("has been in {call} for {running:.1} s")
        });
        let why = own.or_else(|| self.waits_for_another());
        let message = format!("{name} {}", why.as_deref().unwrap_or(otherwise));
        failure(FailureCode::Deadline, message)
    }

    fn gone(&self) -> Failure {
        not_found(format!("{} was deleted", self.identity.instance))
    }

    /// Refuses when it is being deleted.
    pub fn check_stays(&self) -> Result<(), Failure> {
        if lock(&self.status).leaving {
            Err(self.gone())
        } else {
            Ok(())
        }
    }

    /// Lets no end be added any more.
    pub fn leave(&self) {
        lock(&self.status).leaving = true;
    }

    /// Its in-port with this name.
    pub fn in_port(&self, name: &str) -> Result<&Arc<InPort>, Failure> {
        self.in_ports()
            .find(|port| port.name == name)
            .ok_or_else(|| {
                self.no_port("in", name, &list(self.in_ports().map(|p| p.name.as_str())))
            })
    }

    /// Its in-ports.
    pub fn in_ports(&self) -> impl Iterator<Item = &Arc<InPort>> {
        self.ports.iter().filter_map(|port| match port {
            PortEnd::In(port) => Some(port),
            PortEnd::Out(_) => None,
        })
    }

    /// Its out-port with this name.
    pub fn out_port(&self, name: &str) -> Result<&OutPort, Failure> {
        self.out_ports()
            .find(|port| port.name == name)
            .ok_or_else(|| {
                self.no_port(
                    "out",
                    name,
                    &list(self.out_ports().map(|p| p.name.as_str())),
                )
            })
    }

    /// Its out-ports.
    pub fn out_ports(&self) -> impl Iterator<Item = &OutPort> {
        self.ports.iter().filter_map(|port| match port {
            PortEnd::Out(port) => Some(port),
            PortEnd::In(_) => None,
        })
    }

    fn no_port(&self, direction: &str, name: &str, known: &str) -> Failure {
        not_found(format!(
            "{} has no {direction}-port `{name}`; its {direction}-ports are: {known}",
            self.identity.instance
        ))
    }

    /// Its connector with this name.
    pub fn connector(&self, name: &str) -> Option<Arc<Connector>> {
        self.out_ports()
            .flat_map(OutPort::connectors)
            .find(|connector| connector.request.connector == name)
    }

    /// The name of a connector of it that lost its other end.
    fn lost_connector(&self) -> Option<String> {
        self.out_ports()
            .flat_map(OutPort::connectors)
            .find(|connector| connector.is_lost())
            .map(|connector| connector.request.connector.clone())
    }

    /// Takes out the connectors that `which` names.
    pub fn take_connectors(&self, which: impl Fn(&Arc<Connector>) -> bool) -> Vec<Arc<Connector>> {
        self.out_ports()
            .flat_map(|port| port.take(&which))
            .collect()
    }

    /// What the inventory shows of its connectors.
    pub fn connector_infos(&self) -> Vec<ConnectorInfo> {
        self.out_ports()
            .flat_map(OutPort::connectors)
            .map(|connector| connector.info())
            .collect()
    }

    /// What the inventory shows, without both kinds of ends.
    pub fn info(&self) -> ComponentInfo {
        let status = lock(&self.status);
        let identity = &self.identity;
        ComponentInfo {
            defaults: self.module.parameters.clone(),
            busy: self.hangs(),
            on_disconnect: Some(loss::name(status.on_disconnect).to_owned()),
            instance: identity.instance.clone(),
            type_name: self.module.type_name.clone(),
            system: identity.system.clone(),
            incarnation: identity.incarnation.clone(),
            recreate_hash: identity.recreate_hash.clone(),
            stand_in: self.module.is_stand_in(),
            restarts: identity.restarts,
            created: identity.created.clone(),
            state: status.state.name().to_owned(),
            message: status.message.clone(),
            sets: status.configuration.sets.clone(),
            active: status.configuration.active.clone(),
            execution_kind: self.context.kind.name().to_owned(),
            execution_context: self.context.info(self),
            timing: self.timing.info(),
            realtime: self.realtime.get().cloned(),
            rate: self.context.rate(),
            executions: self.executions.load(Ordering::Relaxed),
            ports: self.module.port_infos(),
            connectors: Vec::new(),
            bindings: Vec::new(),
            by_hand: Some(status.by_hand.clone()),
        }
    }

    /// The call that has not returned for so long that somebody should know.
    fn hangs(&self) -> Option<control::Busy> {
        let Busy { call, since } = (*lock(&self.busy))?;
        let running = since.elapsed();
        (running >= HANGS).then(|| control::Busy {
            callback: call.to_owned(),
            milliseconds: running.as_millis().try_into().unwrap_or(u64::MAX),
        })
    }

    /// Asks its execution context for a cycle. False when that is not event-driven.
    pub fn wake(&self) -> bool {
        if self.context.kind != Execution::EventDriven {
            return false;
        }
        if !self.woken.swap(true, Ordering::AcqRel) {
            // Without room its thread has requests to obey, and looks after each.
            let _ = self.context.tell(Order::Wake);
        }
        true
    }

    fn is_woken(&self) -> bool {
        self.woken.load(Ordering::Acquire)
    }

    /// Whether a cycle was asked for; what is asked from now on is another one.
    fn take_wake(&self) -> bool {
        self.woken.swap(false, Ordering::AcqRel)
    }

    fn state(&self) -> State {
        lock(&self.status).state
    }

    fn target(&self) -> String {
        format!("component/{}", self.identity.instance)
    }
}
