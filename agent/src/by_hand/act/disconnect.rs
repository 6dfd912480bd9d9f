//! Disconnecting by hand.

use std::sync::Arc;

use rts_agent_api::messages::Acted;
use rts_http::problem::Problem;
use rts_plan::desired::{PlacedConnector, SystemRef};
use rts_plan::target;
use rts_schemas::system::{DriftPolicy, OnDisconnect};

use super::super::LIMIT;
use super::super::answers::step;
use super::subject::advised;
use crate::agent::Agent;
use crate::execute::connector::{part, unbind};

impl Agent {
    pub(super) async fn disconnect_by_hand(
        self: &Arc<Self>,
        instance: &str,
        connector: String,
        dry_run: bool,
    ) -> Result<Acted, Problem> {
        let inventory = self.observe().await;
        let subject = self.subject_in(&inventory, instance).await?;
        let connectors = subject.component.connectors.iter();
        let found = connectors.clone().find(|c| c.name == connector);
        let wanted = subject.wanted_connector(&connector).cloned();
        if found.is_none() && wanted.is_none() {
            let names: Vec<&str> = connectors.map(|c| c.name.as_str()).collect();
            return Err(Problem::not_found(format!(
                "{instance} has no connector {connector}; {}",
                advised(&connector, "connectors", names)
            )));
        }
        let node = &self.config.node;
        let target = target::connector(&connector);
        let mark = subject.component.by_hand.disconnected.get(&connector);
        let digest = wanted.as_ref().map(PlacedConnector::digest);
        if found.is_none() && mark.is_some() && mark == digest.as_ref() {
            return Ok(subject.unchanged(node, target));
        }
        if !dry_run {
            // Of one that nobody desires nothing is left to be told apart.
            let by_hand = wanted
                .as_ref()
                .and_then(|wanted| subject.mark(|_| wanted.digest()));
            let (source, name) = (instance.to_owned(), connector.clone());
            let parted = part(&subject.manager, source, name, by_hand, LIMIT).await;
            parted.map_err(step)?;
            // A target that is gone, or hangs, keeps a binding that does no harm.
            let end = found.map(|found| self.find_component(&inventory, &found.target.instance));
            if let Some(Ok((_, end))) = end {
                unbind(&end, connector, LIMIT).await;
            }
        }
        let Some(wanted) = wanted else {
            return Ok(subject.changed(node, target, dry_run));
        };
        let mut acted = subject.drifted(node, target, dry_run);
        if let (Some(policy), Some(system)) = (acted.policy, &subject.component.system) {
            acted
                .notes
                .extend(self.idled(policy, system, &wanted).await);
        }
        Ok(acted)
    }

    /// Notes on the ends that must not be Active without it.
    async fn idled(
        &self,
        policy: DriftPolicy,
        system: &SystemRef,
        connector: &PlacedConnector,
    ) -> Vec<String> {
        let lasts = match policy {
            // It is connected again at once.
            DriftPolicy::Repair => return Vec::new(),
            DriftPolicy::Ignore => "",
            DriftPolicy::Adopt => " until that is taken over",
        };
        let mut notes = Vec::new();
        for end in [&connector.spec.source, &connector.spec.target] {
            let name = &end.instance;
            let wanted = self.wanted(system, name).await;
            let policy = wanted.map(|wanted| wanted.component.spec.policy.on_disconnect);
            if let Some(policy) = policy.filter(|policy| *policy != OnDisconnect::Keep) {
                let policy = policy.as_str();
                notes.push(format!(
                    "{name} is deactivated without it{lasts} (rtsctl.onDisconnect of {name} is {policy})"
                ));
            }
        }
        notes
    }
}
