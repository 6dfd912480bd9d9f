//! An observed connector beside the desired one.

use std::collections::BTreeSet;

use rts_schemas::system::ConnectorSpec;

use super::by_hand::target_stays;
use super::{End, Flow, Linker};
use crate::observed::{ConnectorObserved, ConnectorState};
use crate::plan::FieldChange;

/// What stands between an observed connector and the desired one.
pub(super) enum Match {
    Same,
    Pending,
    Differs(String, Vec<FieldChange>),
}

impl<'a> Linker<'_, 'a> {
    pub(super) fn flow(&self) -> Flow {
        if self.unseen(0) {
            return Flow::Unknown;
        }
        let source = self.decisions.present.get(&self.id(0));
        let observed = source.and_then(|live| self.observed(*live));
        match observed.map(|connector| (connector.state, connector)) {
            Some((ConnectorState::Connected, connector)) if self.target_stays(connector) => {
                Flow::Yes
            }
            Some((ConnectorState::Connecting, _)) => Flow::Unknown,
            _ => Flow::No,
        }
    }

    fn target_stays(&self, connector: &'a ConnectorObserved) -> bool {
        target_stays(self.facts, self.decisions, self.key.0, connector)
    }

    pub(super) fn compare(&self, observed: &ConnectorObserved, target: &End) -> Match {
        let fields = self.fields(observed);
        if let Some(first) = fields.first() {
            let reason = format!("{} changed: connected anew", first.field);
            return Match::Differs(reason, fields);
        }
        if let End::Stays(live) = target
            && observed.target_incarnation != self.facts.lives[*live].component.incarnation
        {
            let instance = self.id(1).instance;
            return Match::Differs(format!("its target {instance} was made again"), fields);
        }
        match observed.state {
            ConnectorState::Connected => Match::Same,
            ConnectorState::Connecting => Match::Pending,
            ConnectorState::Disconnected => {
                Match::Differs("it was disconnected".to_owned(), fields)
            }
        }
    }

    pub(super) fn fields(&self, observed: &ConnectorObserved) -> Vec<FieldChange> {
        fields(observed, &self.link.connector.spec)
    }
}

/// What differs between a connector that is there and what it should be.
pub(crate) fn fields(observed: &ConnectorObserved, spec: &ConnectorSpec) -> Vec<FieldChange> {
    let mut fields = Vec::new();
    let mut field = |field: String, old: Option<String>, new: Option<String>| {
        if old != new {
            fields.push(FieldChange { field, old, new });
        }
    };
    let ends = [
        ("source", &observed.source, &spec.source),
        ("target", &observed.target, &spec.target),
    ];
    for (name, old, new) in ends.into_iter().filter(|(_, old, new)| old != new) {
        field(
            name.to_owned(),
            Some(old.to_string()),
            Some(new.to_string()),
        );
    }
    let (old, new) = (&observed.properties, &spec.properties);
    if old == new {
        return fields;
    }
    for key in old.keys().chain(new.keys()).collect::<BTreeSet<_>>() {
        let name = format!("properties.{key}");
        field(name, old.get(key).cloned(), new.get(key).cloned());
    }
    fields
}
