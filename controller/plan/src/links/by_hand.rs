//! Connectors that a person made, took away or made anew.

use super::{Linker, Links};
use crate::decide::{Decisions, Fate};
use crate::drift::Found;
use crate::index::{Facts, Id, LinkId};
use crate::observed::{ConnectorObserved, ConnectorState};
use crate::plan::{Drift, DriftKind, FieldChange};
use crate::target;

impl<'a> Linker<'_, 'a> {
    /// What a person changed in a desired connector, whose source stays.
    pub(super) fn by_hand(
        &self,
        live: usize,
        observed: Option<&'a ConnectorObserved>,
    ) -> Option<Found> {
        let marks = &self.facts.lives[live].component.by_hand;
        let name = &self.link.connector.spec.name;
        let mark = match observed {
            Some(connector) => connector.by_hand.as_ref(),
            None => marks.disconnected.get(name),
        };
        if *mark? != self.link.connector.digest() {
            return None;
        }
        let (kind, reason, fields) = match observed {
            None => (DriftKind::Missing, "was disconnected by hand", Vec::new()),
            Some(connector) => {
                let fields = self.fields(connector);
                let works = works(self.facts, self.decisions, self.key.0, connector);
                if fields.is_empty() || !works {
                    return None;
                }
                (
                    DriftKind::Changed,
                    "was connected otherwise by hand",
                    fields,
                )
            }
        };
        let ends = |field: &FieldChange| field.field == "source" || field.field == "target";
        let obstacle = fields.iter().any(ends);
        let obstacle = obstacle.then_some("its ends are not those of its name");
        let drift = Drift {
            target: target::connector(name),
            system: self.link.system.name.clone(),
            policy: self.facts.wants[&self.id(0)].placed.spec.policy.drift,
            kind,
            reason: reason.to_owned(),
            fields: fields.into_iter().map(turned).collect(),
        };
        Some(Found::new(drift).unless(obstacle))
    }
}

/// Why a connector is made that a person took away or made otherwise.
pub(super) fn repaired(found: &Found) -> String {
    let reason = &found.drift.reason;
    match found.drift.kind {
        DriftKind::Missing => format!("{reason}: connected again"),
        _ => format!("{reason}: connected as written"),
    }
}

/// From a change's direction, found to desired, to a drift's.
fn turned(field: FieldChange) -> FieldChange {
    FieldChange {
        field: field.field,
        old: field.new,
        new: field.old,
    }
}

/// A working connector that a person made where none was desired, at a component that is there as desired.
pub(super) fn extra<'a>(
    facts: &Facts<'a>,
    decisions: &Decisions<'a>,
    source: usize,
    connector: &'a ConnectorObserved,
) -> Option<Found> {
    let id = facts.lives[source].id()?;
    let want = facts.wants.get(&id)?;
    let by_hand = connector.by_hand.as_deref() == Some("");
    let own = decisions.present.get(&id) == Some(&source);
    if !by_hand || !own || !works(facts, decisions, id.uid, connector) {
        return None;
    }
    let ends = [("source", &connector.source), ("target", &connector.target)];
    let ends = ends.map(|(name, end)| (name.to_owned(), end.to_string()));
    let properties = connector.properties.iter();
    let properties = properties.map(|(key, value)| (format!("properties.{key}"), value.clone()));
    let field = |(field, value)| FieldChange {
        field,
        old: None,
        new: Some(value),
    };
    let target = facts.id(id.uid, &connector.target.instance);
    let obstacle = !target.is_some_and(|target| facts.wants.contains_key(&target));
    let drift = Drift {
        target: target::connector(&connector.name),
        system: want.system.name.clone(),
        policy: want.placed.spec.policy.drift,
        kind: DriftKind::Extra,
        reason: "was connected by hand".to_owned(),
        fields: ends.into_iter().chain(properties).map(field).collect(),
    };
    Some(Found::new(drift).unless(obstacle.then_some("its target is not in the system")))
}

/// Why a connector is cut that nobody desires, and that is no drift.
pub(super) fn unwanted(connector: &ConnectorObserved) -> String {
    match connector.by_hand.as_deref() {
        Some("") => "was connected by hand, and lost its other end".to_owned(),
        _ => "is not in the system any more".to_owned(),
    }
}

/// True when samples can flow, now or in a moment, and will after the plan.
fn works<'a>(
    facts: &Facts<'a>,
    decisions: &Decisions<'a>,
    uid: &'a str,
    connector: &'a ConnectorObserved,
) -> bool {
    let lost = connector.state == ConnectorState::Disconnected;
    !lost && target_stays(facts, decisions, uid, connector)
}

/// True when what is at the target end stays, or nobody can say that it does not.
pub(super) fn target_stays<'a>(
    facts: &Facts<'a>,
    decisions: &Decisions<'a>,
    uid: &'a str,
    connector: &'a ConnectorObserved,
) -> bool {
    let target = connector.target_incarnation.as_str();
    if let Some(live) = facts.by_incarnation.get(target) {
        return decisions.fates[*live] == Fate::Keep;
    }
    let id = facts.id(uid, &connector.target.instance);
    let want = id.and_then(|id| facts.wants.get(&id));
    let Some(want) = want else {
        return true;
    };
    facts.unknown.contains_key(want.node) || silent(facts, decisions, want.id())
}

/// True when a component lies in a manager that does not answer, or may do so.
pub(super) fn silent<'a>(facts: &Facts<'a>, decisions: &Decisions<'a>, id: Id<'a>) -> bool {
    if decisions.unseen.contains(&id) {
        return true;
    }
    let live = decisions.present.get(&id);
    live.is_some_and(|live| !facts.lives[*live].manager.responsive)
}

impl<'a> Links<'a> {
    /// True for a connector that a person took away, and that is left so.
    pub fn left_out(&self, key: &LinkId<'a>) -> bool {
        let found = self.by_hand.get(key);
        found.is_some_and(|found| found.drift.kind == DriftKind::Missing && found.left())
    }
}
