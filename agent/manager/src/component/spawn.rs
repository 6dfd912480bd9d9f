//! Making a component: its visible part first, then its thread.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64};
use std::sync::mpsc::sync_channel;
use std::sync::{Arc, Mutex, OnceLock};
use std::thread;
use std::time::Instant;

use jiff::Timestamp;
use rts_manager_api::control::{ByHandInfo, CreateRequest, Failure};
use rts_schemas::names::instance_name_problem;
use rts_schemas::system::rate_problem;

use super::{
    Component, Configuration, Identity, Pending, PortEnd, State, Status, Timing, policy, run,
};
use crate::data::in_port::InPort;
use crate::data::out_port::OutPort;
use crate::failure::{internal, invalid};
use crate::log_file::LogFile;
use crate::manager::Manager;
use crate::module::{Direction, Execution, Module};

/// Requests that may wait for one component.
const COMMANDS: usize = 128;

/// Makes a component, makes it known under its name, and waits until it is initialised.
pub fn spawn(
    manager: &Arc<Manager>,
    module: Arc<Module>,
    request: &CreateRequest,
    deadline: Instant,
) -> Result<String, Failure> {
    check(request)?;
    let execution = execution(request, &module)?;
    let configuration = Configuration::new(&module.parameters)
        .updated(&request.sets, request.active.as_deref(), &module.limits)
        .map_err(|e| invalid(format!("{}: {e}", request.instance)))?;
    let rate = request.rate.unwrap_or(module.default_rate);
    check_rate(rate)?;
    let on_disconnect = request.on_disconnect.as_deref().map(policy).transpose()?;
    let log = LogFile::open(Path::new(&request.log_path)).map_err(|e| {
        internal(format!(
            "the log {} of {} cannot be opened: {e}",
            request.log_path, request.instance
        ))
    })?;
    let (commands, received) = sync_channel(COMMANDS);
    let component = Arc::new(Component {
        identity: identity(request),
        execution,
        ports: module.ports.iter().map(port_end).collect(),
        module,
        status: Mutex::new(Status {
            state: State::Created,
            message: None,
            configuration,
            rate,
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
        commands,
        loss: Mutex::default(),
        wiring: Mutex::default(),
    });
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
    manager.add_component(&component)?;

    let (reply, answer) = sync_channel(1);
    let spawned = thread::Builder::new()
        .name(request.instance.clone())
        .spawn({
            let (manager, component) = (Arc::clone(manager), Arc::clone(&component));
            let asked = request.realtime.clone();
            move || run::run(&manager, &component, asked.as_ref(), &received, &reply)
        });
    if let Err(error) = spawned {
        manager.remove_component(&component);
        return Err(internal(format!(
            "no thread for {}: {error}",
            request.instance
        )));
    }
    component.wait(&Pending { answer, deadline })?;
    Ok(component.identity.incarnation.clone())
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
    }
}

fn port_end(port: &crate::module::Port) -> PortEnd {
    match port.direction {
        Direction::In => PortEnd::In(Arc::new(InPort::new(&port.name, &port.data_type))),
        Direction::Out => PortEnd::Out(OutPort::new(&port.name, &port.data_type)),
    }
}
