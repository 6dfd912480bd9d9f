//! Verbs on connectors: Connect, Disconnect. The in-port end is bound first, by its own agent, then the out-port end dials.

use std::time::Duration;

use rts_agent_api::messages::{BindRequest, Bound};
use rts_manager_api::control::{
    Binding, ConnectRequest, ConnectorInfo, FailureCode, RequestBody, ResponseBody,
};
use rts_manager_api::files::CONTROL_SOCKET;
use rts_plan::desired::{ManagerKey, PlacedConnector};
use rts_schemas::system::{ConnectorSpec, PortKind};

use super::verb::{StepError, Verb, unless};
use crate::agent::Agent;
use crate::events::lock;
use crate::manager_link::LinkError;
use crate::managers::{Manager, Seen};

/// Connects an out-port of this node with an in-port, here or on another node.
pub(super) async fn connect(verb: &Verb, connector: PlacedConnector) -> Result<(), StepError> {
    refuse_unsupported(verb, &connector)?;
    let key = |name: &str| ManagerKey {
        system: verb.system.clone(),
        name: name.to_owned(),
    };
    let source = verb.manager(&key(&connector.source.manager))?;
    if connector.target.node != verb.agent.config.node {
        let system = verb.system.clone();
        let request = system.map(|system| BindRequest { system, connector });
        let request = request.ok_or_else(|| {
            StepError::Refused("a connector between nodes needs a system".to_owned())
        })?;
        return reach(&verb.agent, &source, request, None, verb.limit).await;
    }
    let target = verb.manager(&key(&connector.target.manager))?;
    join(&source, &target, connector.spec, None, verb.limit).await
}

/// Connects two ports of two managers, which may be one. `by_hand` is the mark of the person who does it.
pub(crate) async fn join(
    source: &Manager,
    target: &Manager,
    spec: ConnectorSpec,
    by_hand: Option<String>,
    limit: Duration,
) -> Result<(), StepError> {
    let same = source.key == target.key;
    if same && let Some(incarnation) = known(target, &spec.target.instance) {
        // The manager binds what is its own on the way; of another start of the target it says so.
        lock(&target.seen).bound.insert(spec.name.clone());
        let request = request(spec.clone(), incarnation, None, by_hand.clone());
        match source.link.done(RequestBody::Connect(request), limit).await {
            Err(LinkError::Refused(_)) => {}
            other => return Ok(other?),
        }
    }
    let incarnation = bind(target, &spec, limit).await?;
    let socket = target.folder.join(CONTROL_SOCKET);
    let socket = (!same).then(|| socket.display().to_string());
    dial(source, request(spec, incarnation, socket, by_hand), limit).await
}

/// The incarnation of a component that was made here and not deleted since.
fn known(manager: &Manager, instance: &str) -> Option<String> {
    lock(&manager.seen).incarnations.get(instance).cloned()
}

/// Connects a port of this node with one of another node, whose agent is asked where it is.
pub(crate) async fn reach(
    agent: &Agent,
    source: &Manager,
    wanted: BindRequest,
    by_hand: Option<String>,
    limit: Duration,
) -> Result<(), StepError> {
    let node = &wanted.connector.target.node;
    let bound = agent.inputs.peers.bind(node, &wanted).await;
    let Bound {
        incarnation,
        socket,
    } = bound.map_err(|why| StepError::Peer {
        node: node.clone(),
        why: Box::new(why),
    })?;
    let spec = wanted.connector.spec;
    dial(
        source,
        ConnectRequest {
            between_nodes: true,
            ..request(spec, incarnation, Some(socket), by_hand)
        },
        limit,
    )
    .await
}

/// Lets a connector come to an in-port; gives the incarnation of its component.
pub(crate) async fn bind(
    target: &Manager,
    spec: &ConnectorSpec,
    limit: Duration,
) -> Result<String, StepError> {
    let binding = RequestBody::Bind(Binding {
        connector: spec.name.clone(),
        instance: spec.target.instance.clone(),
        port: spec.target.port.clone(),
        source: spec.source.to_string(),
    });
    lock(&target.seen).bound.insert(spec.name.clone());
    match target.link.call(binding, limit).await? {
        ResponseBody::Bound { incarnation } => Ok(incarnation),
        _ => Err(target.link.unexpected().into()),
    }
}

fn request(
    spec: ConnectorSpec,
    target_incarnation: String,
    target_socket: Option<String>,
    by_hand: Option<String>,
) -> ConnectRequest {
    ConnectRequest {
        connector: spec.name,
        instance: spec.source.instance,
        port: spec.source.port,
        target_instance: spec.target.instance,
        target_port: spec.target.port,
        target_socket,
        target_incarnation,
        between_nodes: false,
        properties: spec.properties,
        by_hand,
    }
}

async fn dial(source: &Manager, request: ConnectRequest, limit: Duration) -> Result<(), StepError> {
    let connect = || {
        source
            .link
            .done(RequestBody::Connect(request.clone()), limit)
    };
    let error = match connect().await {
        Ok(()) => return Ok(()),
        Err(e) => StepError::from(e),
    };
    if !error.is(FailureCode::Conflict) {
        return Err(error);
    }
    match present(source, &request, limit).await? {
        Some(found) if is_same(&found, &request) => Ok(()),
        // A connector to an end that was restarted or lost: made anew.
        Some(_) => {
            let request = RequestBody::Disconnect {
                instance: request.instance.clone(),
                connector: request.connector.clone(),
                by_hand: None,
            };
            source.link.done(request, limit).await?;
            Ok(connect().await?)
        }
        None => Err(error),
    }
}

async fn present(
    source: &Manager,
    request: &ConnectRequest,
    limit: Duration,
) -> Result<Option<ConnectorInfo>, StepError> {
    let answer = source.link.call(RequestBody::Inventory, limit).await?;
    let ResponseBody::Inventory(inventory) = answer else {
        return Err(source.link.unexpected().into());
    };
    Ok(inventory
        .components
        .into_iter()
        .filter(|c| c.instance == request.instance)
        .flat_map(|c| c.connectors)
        .find(|c| c.name == request.connector))
}

fn is_same(found: &ConnectorInfo, wanted: &ConnectRequest) -> bool {
    found.state == "Connected"
        && found.port == wanted.port
        && found.target_instance == wanted.target_instance
        && found.target_port == wanted.target_port
        && found.target_incarnation == wanted.target_incarnation
        && found.properties == wanted.properties
}

fn refuse_unsupported(verb: &Verb, connector: &PlacedConnector) -> Result<(), StepError> {
    let node = &verb.agent.config.node;
    let name = &connector.spec.name;
    let refused = |why: String| Err(StepError::Refused(why));
    if connector.source.node != *node {
        return refused(format!(
            "the source of {name} is on node {}, this is node {node}: the batch went to the wrong node",
            connector.source.node
        ));
    }
    if connector.spec.kind == PortKind::Service {
        return refused(format!(
            "{name} connects service ports, which managers of this version do not have"
        ));
    }
    Ok(())
}

/// Removes a connector at its source, and the binding at its target if that is on this node. On another one it stays for
/// as long as that node is told of it; the next plan sees one that nobody wants any more.
pub(super) async fn disconnect(
    verb: &Verb,
    key: &ManagerKey,
    instance: String,
    connector: String,
) -> Result<(), StepError> {
    let limit = verb.limit;
    if let Some(source) = verb.manager_if_any(key) {
        part(&source, instance, connector.clone(), None, limit).await?;
    }
    let ends = verb.agent.managers.of_system(key.system.as_ref());
    // A manager that hangs keeps its binding; it does no harm without a source, and must not hold up the rest.
    let may = |seen: &Seen| seen.responsive && seen.may_bind(&connector);
    let ends = ends.iter().filter(|m| may(&lock(&m.seen)));
    let unbound = ends.map(|manager| unbind(manager, connector.clone(), limit));
    futures_util::future::join_all(unbound).await;
    Ok(())
}

/// Removes a connector at its source; what is gone already is fine. `by_hand` is the mark of the person who does it.
pub(crate) async fn part(
    source: &Manager,
    instance: String,
    connector: String,
    by_hand: Option<String>,
    limit: Duration,
) -> Result<(), StepError> {
    let request = RequestBody::Disconnect {
        instance,
        connector,
        by_hand,
    };
    let result = source.link.done(request, limit).await;
    unless(FailureCode::NotFound, result)
}

/// Removes a binding, if that can be done.
pub(crate) async fn unbind(manager: &Manager, connector: String, limit: Duration) {
    let request = RequestBody::Unbind {
        connector: connector.clone(),
    };
    match manager.link.done(request, limit).await {
        Ok(()) => drop(lock(&manager.seen).bound.remove(&connector)),
        Err(e) => tracing::debug!(manager = manager.key.display_name(), "cannot unbind: {e}"),
    }
}
