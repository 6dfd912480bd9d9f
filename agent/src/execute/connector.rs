//! Verbs on connectors: Connect, Disconnect. The in-port end is bound first, then the out-port end dials.

use rts_manager_api::control::{
    Binding, ConnectRequest, ConnectorInfo, FailureCode, RequestBody, ResponseBody,
};
use rts_manager_api::files::CONTROL_SOCKET;
use rts_plan::desired::{ManagerKey, PlacedConnector};
use rts_schemas::system::PortKind;

use super::verb::{StepError, Verb, unless};
use crate::events::lock;
use crate::managers::Manager;

/// Connects two ports of this node.
pub(super) async fn connect(verb: &Verb, connector: PlacedConnector) -> Result<(), StepError> {
    refuse_unsupported(verb, &connector)?;
    let key = |name: &str| ManagerKey {
        system: verb.system.clone(),
        name: name.to_owned(),
    };
    let source = verb.manager(&key(&connector.source.manager))?;
    let target = verb.manager(&key(&connector.target.manager))?;
    let spec = connector.spec;
    let binding = RequestBody::Bind(Binding {
        connector: spec.name.clone(),
        instance: spec.target.instance.clone(),
        port: spec.target.port.clone(),
        source: spec.source.to_string(),
    });
    let ResponseBody::Bound { incarnation } = target.link.call(binding, verb.limit).await? else {
        return Err(target.link.unexpected().into());
    };
    let same = source.key == target.key;
    let socket = target.folder.join(CONTROL_SOCKET);
    let request = ConnectRequest {
        connector: spec.name,
        instance: spec.source.instance,
        port: spec.source.port,
        target_instance: spec.target.instance,
        target_port: spec.target.port,
        target_socket: (!same).then(|| socket.display().to_string()),
        target_incarnation: incarnation,
        properties: spec.properties,
        by_hand: None,
    };
    dial(verb, &source, request).await
}

async fn dial(verb: &Verb, source: &Manager, request: ConnectRequest) -> Result<(), StepError> {
    let connect = || {
        source
            .link
            .done(RequestBody::Connect(request.clone()), verb.limit)
    };
    let error = match connect().await {
        Ok(()) => return Ok(()),
        Err(e) => StepError::from(e),
    };
    if !error.is(FailureCode::Conflict) {
        return Err(error);
    }
    match present(verb, source, &request).await? {
        Some(found) if is_same(&found, &request) => Ok(()),
        // A connector to an end that was restarted or lost: made anew.
        Some(_) => {
            let request = RequestBody::Disconnect {
                instance: request.instance.clone(),
                connector: request.connector.clone(),
                by_hand: None,
            };
            source.link.done(request, verb.limit).await?;
            Ok(connect().await?)
        }
        None => Err(error),
    }
}

async fn present(
    verb: &Verb,
    source: &Manager,
    request: &ConnectRequest,
) -> Result<Option<ConnectorInfo>, StepError> {
    let answer = source.link.call(RequestBody::Inventory, verb.limit).await?;
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
    if connector.target.node != *node {
        return refused(format!(
            "the target of {name} is on node {}: connections between nodes come with the network transport; place both ends on one node",
            connector.target.node
        ));
    }
    if connector.spec.kind == PortKind::Service {
        return refused(format!(
            "{name} connects service ports, which managers of this version do not have"
        ));
    }
    Ok(())
}

/// Removes a connector at its source, and the binding at its target if that is on this node.
pub(super) async fn disconnect(
    verb: &Verb,
    key: &ManagerKey,
    instance: String,
    connector: String,
) -> Result<(), StepError> {
    if let Some(source) = verb.manager_if_any(key) {
        let request = RequestBody::Disconnect {
            instance,
            connector: connector.clone(),
            by_hand: None,
        };
        let result = source.link.done(request, verb.limit).await;
        unless(FailureCode::NotFound, result)?;
    }
    let ends = verb.agent.managers.of_system(key.system.as_ref());
    // A manager that hangs keeps its binding; it does no harm without a source, and must not hold up the rest.
    let ends = ends.iter().filter(|m| lock(&m.seen).responsive);
    let unbound = ends.map(|manager| {
        let connector = connector.clone();
        async move {
            let request = RequestBody::Unbind { connector };
            if let Err(e) = manager.link.done(request, verb.limit).await {
                tracing::debug!(manager = manager.key.display_name(), "cannot unbind: {e}");
            }
        }
    });
    futures_util::future::join_all(unbound).await;
    Ok(())
}
