//! Connecting by hand with an in-port of another node: only as its system has it.

use std::sync::Arc;

use rts_agent_api::messages::{Acted, BindRequest};
use rts_http::problem::Problem;
use rts_plan::desired::PlacedConnector;
use rts_plan::target;

use super::super::super::LIMIT;
use super::super::super::answers::step;
use super::super::subject::Subject;
use super::{Wish, is_same};
use crate::agent::Agent;
use crate::execute::connector::reach;

impl Agent {
    /// Connects again what was disconnected by hand, or was lost. `missing` says that this node has no such target.
    pub(super) async fn connect_far(
        self: &Arc<Self>,
        subject: &Subject,
        wish: &Wish,
        dry_run: bool,
        missing: Problem,
    ) -> Result<Acted, Problem> {
        let node = &self.config.node;
        let Some(wanted) = wanted(subject, wish, node) else {
            return Err(refused(missing));
        };
        let name = target::connector(&wanted.spec.name);
        let mut own = subject.component.connectors.iter();
        if own.any(|c| is_same(c, &wanted.spec)) {
            return Ok(subject.unchanged(node, name));
        }
        let system = subject.component.system.clone();
        if let (Some(system), false) = (system, dry_run) {
            let request = BindRequest {
                system,
                connector: wanted.clone(),
            };
            let by_hand = subject.mark(|_| wanted.digest());
            let _turn = self.wiring.at(&wanted.spec.name).await;
            let reached = reach(self, &subject.manager, request, by_hand, LIMIT).await;
            reached.map_err(step)?;
        }
        Ok(subject.changed(node, name, dry_run))
    }
}

/// The desired connector that is meant, if its target is on another node.
fn wanted<'a>(subject: &'a Subject, wish: &Wish, node: &str) -> Option<&'a PlacedConnector> {
    let mut wanted = subject.wanted.iter().flat_map(|w| &w.connectors);
    wanted.find(|c| {
        let spec = &c.spec;
        c.target.node != node
            && (&spec.source, &spec.target) == (&wish.source, &wish.target)
            && wish.name.as_ref().is_none_or(|name| *name == spec.name)
            && (wish.properties.is_empty() || wish.properties == spec.properties)
    })
}

fn refused(mut problem: Problem) -> Problem {
    problem.detail += "; both ends of a connector that no system has must be on one node: put one between nodes into the profile and apply it";
    problem
}
