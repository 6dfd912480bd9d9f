//! Making a component: its visible part first, then it joins its execution context.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64};
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex, OnceLock};
use std::thread::{self, Thread};
use std::time::Instant;

use jiff::Timestamp;
use rts_manager_api::control::{ByHandInfo, CreateRequest, Failure};
use rts_schemas::names::instance_name_problem;
use rts_schemas::system::rate_problem;

use super::context::{NewOrders, WantedRate};
use super::{
    Component, Configuration, Identity, Joining, Order, Pending, PortEnd, State, Status, Timing,
    policy, reply, run,
};
use crate::data::in_port::InPort;
use crate::data::out_port::OutPort;
use crate::failure::{internal, invalid};
use crate::log_file::LogFile;
use crate::manager::Manager;
use crate::module::{Direction, Execution, Module};

/// Makes a component, makes it known under its name, and has its thread initialise it, which unparks the `waker` then.
pub fn begin(
    manager: &Arc<Manager>,
    module: Arc<Module>,
    request: &CreateRequest,
    deadline: Instant,
    waker: Option<Thread>,
) -> Result<(Arc<Component>, Pending), Failure> {
    check(request)?;
    let execution = execution(request, &module)?;
    let configuration = Configuration::new(&module.parameters, &module.limits)
        .updated(&request.sets, request.active.as_deref(), &module.limits)
        .map_err(|e| invalid(format!("{}: {e}", request.instance)))?;
    check_rate(request.rate.unwrap_or(module.default_rate))?;
    let on_disconnect = request.on_disconnect.as_deref().map(policy).transpose()?;
    let log = LogFile::open(Path::new(&request.log_path)).map_err(|e| {
        internal(format!(
            "the log {} of {} cannot be opened: {e}",
            request.log_path, request.instance
        ))
    })?;
    let wanted = WantedRate {
        said: request.rate,
        default: module.default_rate,
    };
    let shared = request.execution_context.as_deref();
    let (component, orders) = manager
        .contexts
        .seat(shared, execution, wanted, |context| Component {
            identity: identity(request),
            context,
            ports: module.ports.iter().map(port_end).collect(),
            module,
            status: Mutex::new(Status {
                state: State::Created,
                message: None,
                configuration,
                on_disconnect: on_disconnect.unwrap_or_default(),
                by_hand: ByHandInfo::default(),
                leaving: false,
            }),
            busy: Mutex::default(),
            executions: AtomicU64::new(0),
            timing: Timing::default(),
            realtime: OnceLock::new(),
            woken: AtomicBool::new(false),
            log,
            loss: Mutex::default(),
            wiring: Mutex::default(),
        })?;
    if execution == Execution::EventDriven {
        for port in component.in_ports() {
            let component = Arc::downgrade(&component);
            port.on_arrival(move || {
                if let Some(component) = component.upgrade() {
                    component.wake();
                }
            });
        }
    }
    let (reply, pending) = reply(deadline, waker);
    let joining = Joining {
        component: Arc::clone(&component),
        rate: wanted,
        realtime: request.realtime.clone(),
        deadline,
        reply,
    };
    join(manager, joining, orders)?;
    Ok((component, pending))
}

/// Makes a component known and hands it to its execution context, which gets its thread with the first one.
fn join(manager: &Arc<Manager>, joining: Joining, orders: NewOrders) -> Result<(), Failure> {
    let component = &Arc::clone(&joining.component);
    let handed = manager
        .add_component(component)
        .and_then(|()| component.tell(Order::Join(joining)));
    let was_last = handed.is_err() && manager.contexts.leave(component);
    // Another one may have joined a new execution context meanwhile: it needs its thread whatever became of this one.
    let started = match orders.filter(|_| !was_last) {
        Some(orders) => start(manager, component, orders),
        None => Ok(()),
    };
    if let Err(failure) = handed.and(started) {
        manager.remove_component(component);
        manager.contexts.leave(component);
        return Err(failure);
    }
    Ok(())
}

/// Starts the thread of an execution context: the only place where one is started.
fn start(
    manager: &Arc<Manager>,
    component: &Arc<Component>,
    orders: Receiver<Order>,
) -> Result<(), Failure> {
    let context = Arc::clone(&component.context);
    let instance = &component.identity.instance;
    let name = context.name.as_ref().unwrap_or(instance).clone();
    let manager = Arc::clone(manager);
    let run = move || run::run(&manager, &context, &orders);
    let spawned = thread::Builder::new().name(name).spawn(run);
    spawned
        .map(drop)
        .map_err(|e| internal(format!("no thread for {instance}: {e}")))
}

fn check(request: &CreateRequest) -> Result<(), Failure> {
    let name = &request.instance;
    if let Some(problem) = instance_name_problem(name) {
        return Err(invalid(format!(
            "the instance name {name:?} is refused: {problem}"
        )));
    }
    if !Path::new(&request.log_path).is_absolute() {
        return Err(invalid(format!(
            "{name}: the log path `{}` is not absolute",
            request.log_path
        )));
    }
    Ok(())
}

/// What drives it: as it is asked for, or, when nothing is, as its module wants it.
fn execution(request: &CreateRequest, module: &Module) -> Result<Execution, Failure> {
    if request.execution_kind.is_empty() {
        return Ok(module.execution);
    }
    Execution::of(&request.execution_kind).ok_or_else(|| {
        invalid(format!(
            "{}: the execution context kind `{}` is not known; use periodic, eventDriven or other",
            request.instance, request.execution_kind
        ))
    })
}

/// Refuses what is no rate. One that no thread can keep is run as fast as it goes.
pub fn check_rate(rate: f64) -> Result<(), Failure> {
    rate_problem(rate).map_or(Ok(()), |problem| {
        Err(invalid(format!("the rate {rate} Hz is refused: {problem}")))
    })
}

fn identity(request: &CreateRequest) -> Identity {
    Identity {
        instance: request.instance.clone(),
        incarnation: uuid::Uuid::new_v4().to_string(),
        system: request.system.clone(),
        recreate_hash: request.recreate_hash.clone(),
        restarts: request.restarts,
        created: format!("{:.3}", Timestamp::now()),
        shared_state: request
            .execution_context
            .as_ref()
            .and_then(|shared| shared.shared_state.clone()),
    }
}

fn port_end(port: &crate::module::Port) -> PortEnd {
    match port.direction {
        Direction::In => PortEnd::In(Arc::new(InPort::new(&port.name, &port.data_type))),
        Direction::Out => PortEnd::Out(OutPort::new(&port.name, &port.data_type)),
    }
}
