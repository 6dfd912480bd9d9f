//! Connectors, at both of their ends: in one process, in two, or on two machines.

use std::path::Path;
use std::time::Duration;

use rts_manager_api::control::{Binding, ConnectRequest, Failure, FailureCode, ResponseBody};
use tokio::time::{Instant, timeout_at};

use super::component::gone;
use super::connection::refuse;
use super::handle::Handle;
use super::request::find;
use super::state::{At, Component, Connector, End, Link, Parting, Run, Source, State};
use crate::truth::{Cause, Happened};

/// Time for dialling and for the other end's answer.
const PATIENCE: Duration = Duration::from_secs(2);

/// Lets a connector come to an in-port.
pub(super) fn bind(handle: &Handle, binding: Binding) -> Result<ResponseBody, Failure> {
    let at = find(handle, &binding.instance)?;
    handle.change(|state| state.bind(&at, binding))?;
    Ok(ResponseBody::Bound {
        incarnation: at.incarnation,
    })
}

/// Removes an in-port end.
pub(super) fn unbind(handle: &Handle, connector: &str) {
    let number = handle.number;
    handle.change(|state| {
        state.close_end(number, connector, Parting::GoodBye, Cause::Asked);
        if let Some(process) = state.living(number) {
            process.ends.remove(connector);
        }
    });
}

/// Removes an out-port end.
pub(super) fn disconnect(handle: &Handle, instance: &str, connector: &str, mark: Option<String>) {
    let Ok(at) = find(handle, instance) else {
        return;
    };
    handle.change(|state| {
        if let Some(component) = state.component(&at) {
            let marks = &mut component.by_hand.disconnected;
            marks.remove(connector);
            marks.extend(mark.map(|mark| (connector.to_owned(), mark)));
        }
        state.remove_connector(&at, connector, Parting::GoodBye, Cause::Asked);
    });
}

/// Connects an out-port. The same connector to the same target is left alone, another one is replaced.
pub(super) async fn connect(
    handle: &Handle,
    request: ConnectRequest,
    deadline: Instant,
) -> Result<(), Failure> {
    let at = find(handle, &request.instance)?;
    let Some(number) = handle.change(|state| state.add_connector(&at, request.clone()))? else {
        return Ok(());
    };
    let made = establish(handle, &at, &request, number, deadline).await;
    if made.is_err() {
        handle.change(|state| state.give_up(&at, &request.connector, number));
    }
    made
}

async fn establish(
    handle: &Handle,
    at: &At,
    request: &ConnectRequest,
    number: u64,
    deadline: Instant,
) -> Result<(), Failure> {
    let Some(socket) = &request.target_socket else {
        let target = find(handle, &request.target_instance)?;
        return handle.change(|state| {
            check_incarnation(request, &target.incarnation)?;
            let binding = Binding {
                connector: request.connector.clone(),
                instance: request.target_instance.clone(),
                port: request.target_port.clone(),
                source: format!("{}.{}", request.instance, request.port),
            };
            state.bind(&target, binding)?;
            state.open(at, request, number, target.process)
        });
    };
    handle.work(100, 2_000).await;
    let failed = |what: &str| {
        let target = &request.target_instance;
        let message = format!("the manager of {target} at {socket} {what}");
        refuse(FailureCode::PeerFailed, message)
    };
    let folder = Path::new(socket).parent().unwrap_or(Path::new(""));
    let owner = handle.shared.owner(folder);
    let peer = owner.change(|state| {
        let process = state.tenant(folder);
        process.map(|process| Handle::new(owner.clone(), process))
    });
    let peer = peer.ok_or_else(|| failed("cannot be reached: connection refused"))?;
    if peer.now() == Run::Hangs {
        let until = deadline.min(Instant::now() + PATIENCE);
        let _ = timeout_at(until, peer.ended()).await;
        return Err(failed("gave no answer"));
    }
    // Nobody else has a turn in between.
    let sent = handle.change(|state| state.offer(at, request, number))?;
    peer.change(|state| state.take(at.process, request, number, peer.number, &sent))?;
    handle.change(|state| state.joined(at, &request.connector, peer.number));
    Ok(())
}

fn check_incarnation(request: &ConnectRequest, found: &str) -> Result<(), Failure> {
    if found == request.target_incarnation {
        return Ok(());
    }
    let message = format!(
        "{} is incarnation {found}, not {}: it was started again; ask for its inventory",
        request.target_instance, request.target_incarnation
    );
    Err(refuse(FailureCode::Conflict, message))
}

impl Component {
    /// Type of a port; `direction` is `in` or `out`.
    fn port(&self, name: &str, direction: &str) -> Result<&str, Failure> {
        let mut ports = self.ports.iter();
        let port = ports.find(|p| p.name == name && p.direction == direction);
        port.map(|port| port.data_type.as_str()).ok_or_else(|| {
            let instance = &self.subject.instance;
            let message = format!("{instance} has no {direction}-port `{name}`");
            refuse(FailureCode::NotFound, message)
        })
    }
}

impl State {
    fn staying(&mut self, at: &At) -> Result<&mut Component, Failure> {
        let component = self.component(at).filter(|c| !c.leaving);
        component.ok_or_else(|| gone(&at.instance))
    }

    /// Adds an in-port end, unless it is there; another one of the connector is closed and replaced.
    fn bind(&mut self, at: &At, binding: Binding) -> Result<(), Failure> {
        self.staying(at)?.port(&binding.port, "in")?;
        let name = binding.connector.clone();
        let Some(process) = self.living(at.process) else {
            return Err(gone(&at.instance));
        };
        let former = process.ends.get(&name);
        let same = |end: &End| end.binding == binding && end.incarnation == at.incarnation;
        if former.is_some_and(same) {
            return Ok(());
        }
        self.close_end(at.process, &name, Parting::GoodBye, Cause::Asked);
        if let Some(process) = self.living(at.process) {
            let end = End {
                binding,
                incarnation: at.incarnation.clone(),
                source: None,
            };
            process.ends.insert(name, end);
        }
        Ok(())
    }

    /// Adds a connector in the place of a former one of its name, and gives its number; none when that is the same and
    /// connected, which then belongs to who asks now.
    fn add_connector(
        &mut self,
        at: &At,
        mut request: ConnectRequest,
    ) -> Result<Option<u64>, Failure> {
        let component = self.staying(at)?;
        component.port(&request.port, "out")?;
        let (by_hand, name) = (request.by_hand.take(), request.connector.clone());
        let former = component.connectors.get_mut(&name);
        let replaces_lost = former.as_ref().is_some_and(|former| former.is_lost());
        let same = |f: &&mut Connector| f.request == request && f.state() == "Connected";
        if let Some(former) = former.filter(same) {
            former.by_hand = by_hand;
            component.by_hand.disconnected.remove(&name);
            return Ok(None);
        }
        self.remove_connector(at, &name, Parting::GoodBye, Cause::Asked);
        let number = self.number();
        let connector = Connector {
            number,
            request,
            by_hand,
            replaces_lost,
            link: Link::Connecting,
            sent: 0.0,
        };
        self.staying(at)?.connectors.insert(name, connector);
        Ok(Some(number))
    }

    /// A connector could not be made. What was lost before is still lost.
    fn give_up(&mut self, at: &At, name: &str, number: u64) {
        let Some(component) = self.component(at) else {
            return;
        };
        let Some(connector) = component.connectors.get_mut(name) else {
            return;
        };
        if connector.number != number {
            return;
        }
        if connector.replaces_lost {
            connector.link = Link::Closed(Parting::Loss);
        } else {
            component.connectors.remove(name);
        }
    }

    /// Connects both ends, which are on this machine.
    fn open(
        &mut self,
        at: &At,
        request: &ConnectRequest,
        number: u64,
        peer: u64,
    ) -> Result<(), Failure> {
        let sent = self.offer(at, request, number)?;
        self.take(at.process, request, number, peer, &sent)?;
        self.joined(at, &request.connector, peer);
        Ok(())
    }

    /// What the out-port end sends.
    fn offer(&mut self, at: &At, request: &ConnectRequest, number: u64) -> Result<String, Failure> {
        let name = &request.connector;
        let component = self.staying(at)?;
        let waits = |c: &Connector| c.number == number && c.link == Link::Connecting;
        if !component.connectors.get(name).is_some_and(waits) {
            let message = format!("the connector {name} was removed while it was being connected");
            return Err(refuse(FailureCode::Conflict, message));
        }
        Ok(component.port(&request.port, "out")?.to_owned())
    }

    /// The in-port end takes the connector of a process.
    fn take(
        &mut self,
        from_process: u64,
        request: &ConnectRequest,
        number: u64,
        peer: u64,
        sent: &str,
    ) -> Result<(), Failure> {
        let name = &request.connector;
        let conflict = |why: String| Err(refuse(FailureCode::Conflict, why));
        let target = format!("{}.{}", request.target_instance, request.target_port);
        let process = self.living(peer);
        let end = process.as_ref().and_then(|process| process.ends.get(name));
        let Some(end) = end else {
            let message = format!("{target} does not expect the connector {name}: bind it first");
            return Err(refuse(FailureCode::NotFound, message));
        };
        let Binding {
            instance,
            port,
            source,
            ..
        } = &end.binding;
        let from = format!("{}.{}", request.instance, request.port);
        if (instance, port, source) != (&request.target_instance, &request.target_port, &from) {
            return conflict(format!(
                "the connector {name} is bound from {source} to {instance}.{port}, not from {from} to {target}"
            ));
        }
        check_incarnation(request, &end.incarnation)?;
        let owner = process.and_then(|process| process.components.get(&request.target_instance));
        let taken = owner.map(|owner| owner.port(&request.target_port, "in"));
        let taken = taken.transpose()?.unwrap_or_default();
        if taken != sent {
            let message = format!("{from} sends {sent}, but {target} takes {taken}");
            return Err(refuse(FailureCode::Invalid, message));
        }
        // The newest wins.
        self.close_end(peer, name, Parting::GoodBye, Cause::Asked);
        let end = self.living(peer).and_then(|p| p.ends.get_mut(name));
        if let Some(end) = end {
            end.source = Some(Source {
                number,
                process: from_process,
                closed: None,
                received: 0.0,
            });
        }
        Ok(())
    }

    /// Both ends have agreed.
    fn joined(&mut self, at: &At, name: &str, peer: u64) {
        let Some(component) = self.component(at) else {
            return;
        };
        component.by_hand.disconnected.remove(name);
        if let Some(connector) = component.connectors.get_mut(name) {
            connector.link = Link::Open(peer);
        }
        let of = component.subject.clone();
        let connector = name.to_owned();
        self.news.push(Happened::Connected { of, connector });
    }
}
