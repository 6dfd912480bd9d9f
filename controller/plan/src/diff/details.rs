//! What was, or should be, where no step says it: what goes, and what cannot be made now.

use std::collections::{BTreeMap, BTreeSet};

use rts_schemas::system::Realtime;

use crate::decide::{Decisions, Fate};
use crate::index::{Facts, Live, Want};
use crate::links::compare;
use crate::links::{Join, Links};
use crate::observed::{ComponentObserved, ConnectorObserved};
use crate::plan::{Action, Change, FieldChange};
use crate::render::fields::{self, Made, component};
use crate::take_down::Down;
use crate::target;

/// A component that should be there.
pub(super) fn wanted(want: &Want<'_>) -> Vec<FieldChange> {
    let spec = &want.placed.spec;
    component(&Made {
        node: want.node,
        manager: &want.key.name,
        type_name: &spec.type_name,
        configuration: &spec.configuration,
        execution_kind: spec.execution_context.kind,
        rate: spec.execution_context.rate,
        execution_context: spec.execution_context.shared().as_ref(),
        on_disconnect: spec.policy.on_disconnect,
        stand_in: want.placed.stand_in.is_some(),
        realtime: want.placed.realtime(),
    })
}

/// A component that goes: where it is and what.
pub(super) fn live(live: &Live<'_>) -> Vec<FieldChange> {
    let (component, manager) = (live.component, live.manager.key.name.as_str());
    let of = [
        ("type", component.type_name.as_str()),
        ("node", live.node),
        ("manager", manager),
    ];
    of.map(|(field, old)| was(field, old)).into()
}

/// What differs in what its execution context has of its node, as the overlay says it.
pub(super) fn resources(live: &ComponentObserved, want: &Want<'_>) -> Vec<FieldChange> {
    let said = |asked: Option<&Realtime>| asked.map_or(Vec::new(), fields::resources);
    let old = said(live.realtime.as_ref().map(|found| &found.asked));
    let new = said(want.placed.realtime().as_ref());
    let (old, new) = (BTreeMap::from_iter(old), BTreeMap::from_iter(new));
    let names: BTreeSet<_> = old.keys().chain(new.keys()).copied().collect();
    let changes = names.into_iter().map(|name| FieldChange {
        field: name.to_owned(),
        old: old.get(name).cloned(),
        new: new.get(name).cloned(),
    });
    changes.filter(|change| change.old != change.new).collect()
}

/// A connector that goes.
pub(super) fn connector(observed: &ConnectorObserved) -> Vec<FieldChange> {
    let properties = observed.properties.iter();
    properties
        .map(|(key, old)| was(&format!("properties.{key}"), old))
        .collect()
}

fn was(field: &str, old: &str) -> FieldChange {
    FieldChange {
        field: field.to_owned(),
        old: Some(old.to_owned()),
        new: None,
    }
}

/// What differs in a connector that is made anew; of one whose end is made again what changes on the way.
pub(super) fn joined(facts: &Facts<'_>, join: &Join<'_>) -> Vec<FieldChange> {
    if !join.again || !join.fields.is_empty() {
        return join.fields.clone();
    }
    let instances = facts.instances(join.source).iter();
    let mut connectors = instances.flat_map(|ix| &facts.lives[*ix].component.connectors);
    let old = connectors.find(|c| c.name == join.connector.spec.name);
    old.map_or(Vec::new(), |old| compare::fields(old, &join.connector.spec))
}

/// Connectors that nobody wants and that end with their source: no step of their own takes them away.
pub(super) fn end_with_source<'a>(
    facts: &Facts<'a>,
    decisions: &Decisions<'a>,
    links: &Links<'a>,
    down: &Down<'a>,
    changes: &mut Vec<Change>,
) {
    for (ix, live) in facts.lives.iter().enumerate() {
        let goes = decisions.fates[ix] == Fate::Gone && !down.stuck.contains_key(&ix);
        let Some(id) = live.id().filter(|_| goes) else {
            continue;
        };
        for (key, observed) in facts.connectors(ix) {
            if facts.links.contains_key(&key) || links.cuts.contains_key(&key) {
                continue;
            }
            changes.push(Change {
                action: Action::Remove,
                target: target::connector(&observed.name),
                system: live.component.system.as_ref().map(|s| s.name.clone()),
                node: None,
                reason: format!("ends with its source {}", id.instance),
                fields: connector(observed),
            });
        }
    }
}

/// In-port ends that go, where nothing else is said of their connector.
pub(super) fn left_ends(facts: &Facts<'_>, down: &Down<'_>, changes: &mut Vec<Change>) {
    if down.left_ends.is_empty() {
        return;
    }
    let said = changes.iter().map(|c| (c.target.clone(), c.system.clone()));
    let mut said: BTreeSet<_> = said.collect();
    for end in &down.left_ends {
        let system = facts.lives[end.live].component.system.as_ref();
        let target = target::connector(&end.binding.connector);
        let system = system.map(|system| system.name.clone());
        if !said.insert((target.clone(), system.clone())) {
            continue;
        }
        let change = Change {
            action: Action::Remove,
            target,
            node: None,
            system,
            reason: end.reason.clone(),
            fields: Vec::new(),
        };
        changes.push(super::blocked(change, end.blocked.as_ref()));
    }
}
