//! Connectors that are there and that nobody desires, or whose target goes.

use super::{Cut, Links, by_hand};
use crate::decide::{Decisions, Fate};
use crate::index::{Facts, LinkId};
use crate::observed::ConnectorObserved;
use crate::plan::Blocked;
use crate::target;

/// Cuts them, at components that stay; but for what a person made and is left.
pub(super) fn cut<'a>(
    facts: &Facts<'a>,
    decisions: &Decisions<'a>,
    blocked: &Blocked,
    links: &mut Links<'a>,
) {
    for (source, live) in facts.lives.iter().enumerate() {
        let acts = live.manager.responsive && facts.nodes.contains(live.node);
        let own = || target::component(&live.component.instance);
        // One that does not let itself be deleted is still there.
        let stuck = !decisions.stops.contains_key(&live.seat())
            && target::why_blocked(blocked, live.node, own).is_some();
        let goes = decisions.fates[source] == Fate::Gone && !stuck;
        if live.id().is_none() || !acts || goes {
            continue;
        }
        for (key, connector) in facts.connectors(source) {
            let Some(reason) = reason(facts, decisions, links, source, key, connector) else {
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
    key: LinkId<'a>,
    connector: &'a ConnectorObserved,
) -> Option<String> {
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
