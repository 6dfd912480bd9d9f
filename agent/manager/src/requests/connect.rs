//! Connectors, at both of their ends.

use std::path::Path;
use std::sync::Arc;
use std::thread;
use std::time::Instant;

use rts_manager_api::control::{Binding, ConnectRequest, Failure, ResponseBody};
use rts_schemas::connector::{ConnectorSettings, Dataflow, Distance};
use rts_transport::Kind;

use crate::component::Component;
use crate::data::accept::check_types;
use crate::data::binding::End;
use crate::data::choose::choose;
use crate::data::connector::{Connector, Link};
use crate::data::dial::{Target, dial};
use crate::data::sender::Sender;
use crate::data::{Ended, Parting, direct, settings};
use crate::failure::{conflict, internal, invalid};
use crate::manager::Manager;
use crate::slots::Slot;
use crate::sync::lock;

/// Lets a connector come to an in-port.
pub fn bind(manager: &Manager, binding: Binding) -> Result<ResponseBody, Failure> {
    let end = add_end(manager, binding)?;
    Ok(ResponseBody::Bound {
        incarnation: end.incarnation.clone(),
    })
}

fn add_end(manager: &Manager, binding: Binding) -> Result<Arc<End>, Failure> {
    let component = manager.component(&binding.instance)?;
    let port = component.in_port(&binding.port)?;
    let end = End::new(binding, &component.identity.incarnation, port);
    manager
        .bindings
        .add(end, &manager.events, || component.check_stays())
}

/// Removes an in-port end.
pub fn unbind(manager: &Manager, connector: &str) -> ResponseBody {
    if let Some(end) = manager.bindings.remove(connector) {
        end.close(&manager.events, Parting::GoodBye);
    }
    ResponseBody::Done
}

/// Removes an out-port end.
pub fn disconnect(
    manager: &Manager,
    instance: &str,
    connector: &str,
    by_hand: Option<String>,
) -> Result<ResponseBody, Failure> {
    if let Ok(component) = manager.component(instance) {
        let _wiring = lock(&component.wiring);
        component.disconnected_by(connector, by_hand)?;
        for connector in component.take_connectors(|c| c.request.connector == connector) {
            connector.close(Parting::GoodBye);
        }
    }
    Ok(ResponseBody::Done)
}

/// Connects an out-port. The same connector to the same target is left alone, another one is replaced.
pub fn connect(
    manager: &Arc<Manager>,
    request: ConnectRequest,
    deadline: Instant,
) -> Result<ResponseBody, Failure> {
    let component = manager.component(&request.instance)?;
    let settings = settings(&request.properties)?;
    let kinds = choose(settings.interface, distance(&request))
        .map_err(|why| invalid(format!("the connector {}: {why}", request.connector)))?;
    let Some(connector) = add(&component, request)? else {
        return Ok(ResponseBody::Done);
    };
    let connected = establish(manager, &component, &connector, settings, kinds, deadline);
    match (&connected, connector.replaces_lost) {
        (Ok(()), _) => made(&component, &connector),
        // What was lost is still lost.
        (Err(_), true) => {
            connector.close(Parting::Loss);
        }
        (Err(_), false) => {
            connector.close(Parting::GoodBye);
            component.take_connectors(|c| Arc::ptr_eq(c, &connector));
        }
    }
    connected.map(|()| ResponseBody::Done)
}

/// Whether to connect is a matter of this process alone, and waits for nobody.
pub fn is_direct(request: &ConnectRequest) -> bool {
    let interface = settings(&request.properties).map(|settings| settings.interface);
    let kinds = interface.map(|interface| choose(interface, distance(request)));
    matches!(kinds, Ok(Ok([Kind::InProcess])))
}

fn distance(request: &ConnectRequest) -> Distance {
    match &request.target_socket {
        None => Distance::Process,
        Some(_) if request.between_nodes => Distance::Beyond,
        Some(_) => Distance::Node,
    }
}

/// Notes that a connector was made, unless it was removed meanwhile.
fn made(component: &Component, connector: &Arc<Connector>) {
    let _wiring = lock(&component.wiring);
    let name = &connector.request.connector;
    let now = component.connector(name);
    if now.is_some_and(|now| Arc::ptr_eq(&now, connector)) {
        component.connected(name);
    }
}

/// Adds a connector in the place of a former one of its name; none when that is the same and connected, which then
/// belongs to who asks now.
fn add(
    component: &Component,
    mut request: ConnectRequest,
) -> Result<Option<Arc<Connector>>, Failure> {
    let _wiring = lock(&component.wiring);
    let port = component.out_port(&request.port)?;
    let by_hand = request.by_hand.take();
    let former = component.connector(&request.connector);
    if let Some(former) = former.filter(|f| f.request == request && f.state() == "Connected") {
        former.mark(by_hand);
        component.connected(&request.connector);
        return Ok(None);
    }
    let mut lost = false;
    for former in component.take_connectors(|c| c.request.connector == request.connector) {
        lost |= former.is_lost();
        former.close(Parting::GoodBye);
    }
    let connector = Arc::new(Connector::new(request, by_hand, lost));
    port.add(&connector, || component.check_stays())?;
    Ok(Some(connector))
}

fn establish(
    manager: &Arc<Manager>,
    component: &Arc<Component>,
    connector: &Arc<Connector>,
    settings: ConnectorSettings,
    kinds: &[Kind],
    deadline: Instant,
) -> Result<(), Failure> {
    let request = &connector.request;
    let port = component.out_port(&request.port)?;
    if kinds == [Kind::InProcess] {
        let end = here(manager, request, &port.data_type)?;
        let link = direct::link(&end, settings, &manager.outgoing, &manager.events)?;
        return agreed(connector.establish(link), request);
    }
    let socket = match &request.target_socket {
        Some(socket) => Path::new(socket),
        // Both are here, and yet a transport is asked for: this manager is its own peer.
        None => {
            here(manager, request, &port.data_type)?;
            &manager.socket
        }
    };
    let slot = manager
        .outgoing
        .take()
        .ok_or_else(|| conflict("there are too many connections to other managers already"))?;
    let target = Target {
        socket,
        request,
        data_type: &port.data_type,
        pulls: settings.dataflow == Dataflow::Pull,
        endian: settings.endian,
        idl: component.module.idl(),
    };
    let sender = Sender::new(dial(target, kinds, deadline)?, &settings)
        .map_err(|e| internal(format!("connector {}: {e}", request.connector)))?;
    let sender = Arc::new(sender);
    agreed(
        connector.establish(Link::Between(Arc::clone(&sender))),
        request,
    )?;
    send(manager, connector, sender, slot)
}

fn agreed(established: bool, request: &ConnectRequest) -> Result<(), Failure> {
    if established {
        Ok(())
    } else {
        Err(conflict(format!(
            "the connector {} was removed while it was being connected",
            request.connector
        )))
    }
}

/// An in-port end of this process. It is bound on the way when it is not yet: who asks for this controls both.
fn here(manager: &Manager, request: &ConnectRequest, data_type: &str) -> Result<Arc<End>, Failure> {
    let target = manager.component(&request.target_instance)?;
    if target.identity.incarnation != request.target_incarnation {
        return Err(conflict(format!(
            "{} is incarnation {}, not {}: it was started again; ask for its inventory",
            request.target_instance, target.identity.incarnation, request.target_incarnation
        )));
    }
    let source = format!("{}.{}", request.instance, request.port);
    let port = target.in_port(&request.target_port)?;
    check_types(
        &source,
        data_type,
        &format!("{}.{}", request.target_instance, request.target_port),
        &port.data_type,
    )?;
    add_end(
        manager,
        Binding {
            connector: request.connector.clone(),
            instance: request.target_instance.clone(),
            port: request.target_port.clone(),
            source,
        },
    )
}

/// Tells of a connection that this side did not close.
fn report(manager: &Manager, request: &ConnectRequest, ended: &Ended) {
    let name = &request.connector;
    let message = format!("disconnected: {ended}");
    manager.events.changed(format!("connector/{name}"), message);
    if matches!(ended, Ended::Lost(_)) {
        manager.lose(&request.instance, name);
    }
}

/// Starts the thread that sends. A connection that breaks is reported, not dialled again.
fn send(
    manager: &Arc<Manager>,
    connector: &Arc<Connector>,
    sender: Arc<Sender>,
    slot: Slot,
) -> Result<(), Failure> {
    let spawned = thread::Builder::new().name("sender".to_owned()).spawn({
        let mut sending = Sending {
            manager: Arc::clone(manager),
            connector: Arc::clone(connector),
            ended: Ended::Lost("the thread that sends has failed".to_owned()),
        };
        move || {
            sending.ended = sender.send();
            drop(sending);
            drop(slot);
        }
    });
    spawned
        .map(drop)
        .map_err(|e| internal(format!("no thread to send: {e}")))
}

/// A thread that sends. However it ends, nobody takes its connector for one that works.
struct Sending {
    manager: Arc<Manager>,
    connector: Arc<Connector>,
    ended: Ended,
}

impl Drop for Sending {
    fn drop(&mut self) {
        if self.connector.close(self.ended.parting()) {
            report(&self.manager, &self.connector.request, &self.ended);
        }
    }
}
