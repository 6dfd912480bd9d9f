//! Connecting by hand.

use std::collections::BTreeMap;
use std::sync::Arc;

use rts_agent_api::messages::Acted;
use rts_http::problem::Problem;
use rts_plan::observed::{ComponentObserved, ConnectorObserved, ConnectorState, Inventory};
use rts_plan::target;
use rts_schemas::names::connector_name_fault;
use rts_schemas::system::{ConnectorSpec, DriftPolicy, PortKind, PortRef};

use super::super::LIMIT;
use super::super::answers::step;
use super::subject::Subject;
use crate::agent::Agent;
use crate::execute::connector::join;
use crate::managers::Manager;

mod far;
mod ports;

/// Longest name of a connector: made of two instances and two ports.
const MAX_NAME: usize = 1024;

/// What a person wants to connect.
pub(super) struct Wish {
    pub source: PortRef,
    pub target: PortRef,
    pub name: Option<String>,
    pub properties: BTreeMap<String, String>,
}

impl Agent {
    pub(super) async fn connect_by_hand(
        self: &Arc<Self>,
        wish: Wish,
        dry_run: bool,
    ) -> Result<Acted, Problem> {
        let inventory = self.observe().await;
        let subject = self.subject_in(&inventory, &wish.source.instance).await?;
        let (peer, end) = match self.find_component(&inventory, &wish.target.instance) {
            Ok(found) => found,
            // It may be on another node.
            Err(missing) if missing.status == 404 => {
                let far = self.connect_far(&subject, &wish, dry_run, missing);
                return far.await;
            }
            Err(silent) => return Err(silent),
        };
        ports::check(&subject.component, &peer, &wish)?;
        let node = &self.config.node;
        let spec = spec(&subject, wish)?;
        let name = target::connector(&spec.name);
        let own = &subject.component.connectors;
        match own.iter().find(|c| c.name == spec.name) {
            Some(found) if is_same(found, &spec) => return Ok(subject.unchanged(node, name)),
            Some(found) if found.state == ConnectorState::Connected => {
                return Err(taken(&spec, found));
            }
            _ => {}
        }
        refuse_bound(self, &inventory, &spec, &end)?;
        let wanted = subject.wanted_connector(&spec.name);
        let is_wanted = wanted.is_some_and(|c| c.spec.properties == spec.properties);
        if !dry_run {
            let digest = || wanted.map(|c| c.digest()).unwrap_or_default();
            let by_hand = subject.mark(|_| digest());
            let _turn = self.wiring.at(&spec.name).await;
            let joined = join(&subject.manager, &end, spec, by_hand, LIMIT).await;
            joined.map_err(step)?;
        }
        if is_wanted {
            return Ok(subject.changed(node, name, dry_run));
        }
        let mut acted = subject.drifted(node, name, dry_run);
        if peer.system != subject.component.system {
            not_adopted(&mut acted, &peer);
        }
        Ok(acted)
    }
}

/// A profile holds no connector to what its system does not have.
fn not_adopted(acted: &mut Acted, peer: &ComponentObserved) {
    let system = acted.system.clone().unwrap_or_default();
    if acted.policy == Some(DriftPolicy::Adopt) {
        acted.policy = Some(DriftPolicy::Ignore);
        acted.notes = vec![format!(
            "{} is not in system {system}, so that the connector is not adopted, but left until it is disconnected or an end is made again",
            peer.instance
        )];
    }
}

/// What is to be made. Without a name it is the desired connector of these ends, if there is one: what was disconnected
/// is connected again as it was.
fn spec(subject: &Subject, wish: Wish) -> Result<ConnectorSpec, Problem> {
    let Wish {
        source,
        target,
        name,
        properties,
    } = wish;
    let mut wanted = subject.wanted.iter().flat_map(|w| &w.connectors);
    let name = name.or_else(|| {
        let same = wanted.find(|c| c.spec.source == source && c.spec.target == target);
        same.map(|c| c.spec.name.clone())
    });
    let name = name.unwrap_or_else(|| format!("{source}-{target}"));
    check_name(&name)?;
    let mut spec = ConnectorSpec {
        name,
        kind: PortKind::Data,
        source,
        target,
        data_type: None,
        properties,
    };
    if let Some(wanted) = subject.wanted_connector(&spec.name) {
        let wanted = &wanted.spec;
        if (&wanted.source, &wanted.target) != (&spec.source, &spec.target) {
            return Err(Problem::conflict(
                "name-taken",
                format!(
                    "{} is the name of the connector from {} to {} in this system; choose another one",
                    spec.name, wanted.source, wanted.target
                ),
            ));
        }
        if spec.properties.is_empty() {
            spec.properties.clone_from(&wanted.properties);
        }
    }
    Ok(spec)
}

fn check_name(name: &str) -> Result<(), Problem> {
    let long = (name.len() > MAX_NAME).then_some("it is longer than 1024 bytes");
    let Some(fault) = connector_name_fault(name).or(long) else {
        return Ok(());
    };
    let detail = format!("{name:?} is no name of a connector: {fault}");
    Err(Problem::invalid("invalid-name", detail))
}

fn is_same(found: &ConnectorObserved, spec: &ConnectorSpec) -> bool {
    found.state == ConnectorState::Connected
        && found.source == spec.source
        && found.target == spec.target
        && found.properties == spec.properties
}

fn taken(spec: &ConnectorSpec, found: &ConnectorObserved) -> Problem {
    let (name, instance) = (&spec.name, &found.source.instance);
    let what = if (&found.source, &found.target) == (&spec.source, &spec.target) {
        "with other properties".to_owned()
    } else {
        format!("from {} to {}", found.source, found.target)
    };
    Problem::conflict(
        "name-taken",
        format!(
            "{instance} has a connector {name} already, {what}; disconnect that first (rtsctl disconnect {name}), or choose another name"
        ),
    )
}

/// A manager knows its in-port ends by the names of their connectors: refuses one that it has from another source.
fn refuse_bound(
    agent: &Agent,
    inventory: &Inventory,
    spec: &ConnectorSpec,
    end: &Manager,
) -> Result<(), Problem> {
    let components = inventory.managers.iter().flat_map(|m| &m.components);
    let others = components.filter(|c| c.instance != spec.source.instance);
    let mut named = others
        .flat_map(|c| &c.connectors)
        .filter(|c| c.name == spec.name);
    let ends_there = |c: &&ConnectorObserved| {
        let found = agent.find_component(inventory, &c.target.instance);
        found.is_ok_and(|(_, manager)| manager.key == end.key)
    };
    match named.find(ends_there) {
        Some(found) => Err(taken(spec, found)),
        None => Ok(()),
    }
}
