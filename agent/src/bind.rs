//! Letting a connector of another node come to an in-port of this one.
//!
//! The agent of its out-port asks each time before it dials. What comes is taken only if this node was told of it: another
//! node decides nothing here.

use std::time::Duration;

use rts_agent_api::messages::{BindRequest, Bound};
use rts_http::problem::Problem;
use rts_manager_api::files::CONTROL_SOCKET;
use rts_plan::desired::{ManagerKey, PlacedConnector};

use crate::agent::Agent;
use crate::by_hand::answers::step;
use crate::execute::connector::bind;

/// Longest wait for the manager; less than who asks waits.
const LIMIT: Duration = Duration::from_secs(2);

impl Agent {
    /// Binds the in-port end; the same again changes nothing.
    pub async fn bind_for_peer(&self, request: BindRequest) -> Result<Bound, Problem> {
        let BindRequest { system, connector } = request;
        let node = &self.config.node;
        let name = &connector.spec.name;
        let expects = {
            let ledger = self.ledger.lock().await;
            let parts = ledger.held().map_or(&[][..], |held| &held.spec.systems);
            let mut own = parts.iter().filter(|part| part.system == system);
            own.any(|part| part.connectors.iter().any(|own| is_same(own, &connector)))
        };
        if !expects || connector.target.node != *node {
            return Err(Problem::conflict(
                "not-expected",
                format!(
                    "node {node} was not told of a connector {name} of system {} from {} on node {} to {}; its controller tells both nodes of it",
                    system.name,
                    connector.spec.source,
                    connector.source.node,
                    connector.spec.target
                ),
            ));
        }
        let key = ManagerKey {
            system: Some(system),
            name: connector.target.manager.clone(),
        };
        let manager = self.managers.get(&key).ok_or_else(|| {
            Problem::unavailable(
                "no-manager",
                format!(
                    "manager {}, which is to hold {}, does not run on node {node}",
                    key.display_name(),
                    connector.spec.target.instance
                ),
            )
        })?;
        let incarnation = bind(&manager, &connector.spec, LIMIT).await.map_err(step)?;
        Ok(Bound {
            incarnation,
            socket: manager.folder.join(CONTROL_SOCKET).display().to_string(),
        })
    }
}

/// The same connector between the same places; its properties are the business of its out-port.
fn is_same(own: &PlacedConnector, wanted: &PlacedConnector) -> bool {
    let ends = |c: &PlacedConnector| {
        let spec = &c.spec;
        (spec.kind, spec.source.clone(), spec.target.clone())
    };
    own.spec.name == wanted.spec.name
        && ends(own) == ends(wanted)
        && (&own.source, &own.target) == (&wanted.source, &wanted.target)
}
