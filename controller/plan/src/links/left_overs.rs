//! Connectors that are there and that nobody desires, or whose target goes.

use super::{Cut, Links, by_hand};
use crate::decide::{Decisions, Fate};
use crate::index::Facts;
use crate::observed::ConnectorObserved;

/// Cuts them, at components that stay; but for what a person made and is left.
pub(super) fn cut<'a>(facts: &Facts<'a>, decisions: &Decisions<'a>, links: &mut Links<'a>) {
    for (source, live) in facts.lives.iter().enumerate() {
        let acts = live.manager.responsive && facts.nodes.contains(live.node);
        let Some(id) = live.id().filter(|_| acts) else {
            continue;
        };
        if decisions.fates[source] == Fate::Gone {
            continue;
        }
        for connector in &live.component.connectors {
            let key = (id.uid, connector.name.as_str());
            let Some(reason) = reason(facts, decisions, links, source, connector) else {
                continue;
            };
            let cut = Cut {
                source,
                system: live.component.system.as_ref(),
                connector,
                dying_target: dying(facts, decisions, connector),
                reason,
            };
            links.cuts.insert(key, cut);
        }
    }
}

/// Why a connector is cut; none when it is not.
fn reason<'a>(
    facts: &Facts<'a>,
    decisions: &Decisions<'a>,
    links: &mut Links<'a>,
    source: usize,
    connector: &'a ConnectorObserved,
) -> Option<String> {
    let uid = facts.lives[source].id()?.uid;
    let key = (uid, connector.name.as_str());
    if facts.links.contains_key(&key) {
        let name = &connector.target.instance;
        let goes = dying(facts, decisions, connector).is_some();
        return goes.then(|| format!("its target {name} is taken down"));
    }
    let Some(found) = by_hand::extra(facts, decisions, source, connector) else {
        return Some(by_hand::unwanted(connector));
    };
    let reason = format!("{}: disconnected", found.drift.reason);
    let left = found.left();
    links.by_hand.insert(key, found);
    (!left).then_some(reason)
}

/// The component at its other end, when that is taken down.
fn dying<'a>(
    facts: &Facts<'a>,
    decisions: &Decisions<'a>,
    connector: &'a ConnectorObserved,
) -> Option<usize> {
    let target = connector.target_incarnation.as_str();
    let target = facts.by_incarnation.get(target).copied();
    target.filter(|live| decisions.fates[*live] == Fate::Gone)
}
