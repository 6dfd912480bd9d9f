//! Differences for people: one change for each target, with the fields that differ.

mod details;
mod processes;
mod restarts;

pub(crate) use self::restarts::restarts;

use rts_schemas::system::SharedExecutionContext;

use crate::bring_up::Up;
use crate::decide::{Decisions, Fate};
use crate::drift;
use crate::in_place::{differences, in_place};
use crate::index::{Facts, Id, Live};
use crate::links::Links;
use crate::observed::LifeCycleState;
use crate::plan::{Action, Change, FieldChange};
use crate::render::fields::connector as made_with;
use crate::take_down::Down;
use crate::target;

/// All changes, sorted by target.
pub(crate) fn changes<'a>(
    facts: &Facts<'a>,
    decisions: &Decisions<'a>,
    links: &Links<'a>,
    down: &Down<'a>,
    up: &Up<'a>,
) -> Vec<Change> {
    let mut changes = Vec::new();
    for (id, make) in decisions.makes.iter() {
        changes.push(made(facts, *id, make.old, &make.reason));
    }
    for id in decisions.present.keys() {
        changes.extend(changed(facts, decisions, down, up, *id));
    }
    for (id, reason) in up.waits.iter() {
        changes.extend(waits(facts, decisions, down, up, *id, reason));
    }
    for (ix, live) in facts.lives.iter().enumerate() {
        if decisions.fates[ix] == Fate::Gone {
            let stuck = down.stuck.get(&ix);
            changes.extend(removed(facts, decisions, live).map(|c| blocked(c, stuck)));
        }
    }
    connectors(facts, links, down, &mut changes);
    details::end_with_source(facts, decisions, links, down, &mut changes);
    details::left_ends(facts, down, &mut changes);
    processes::managers(decisions, up, &mut changes);
    changes.sort_by(|a, b| (&a.target, &a.system, a.action).cmp(&(&b.target, &b.system, b.action)));
    changes
}

fn made<'a>(facts: &Facts<'a>, id: Id<'a>, old: Option<usize>, reason: &str) -> Change {
    let want = &facts.wants[&id];
    let spec = &want.placed.spec;
    let mut fields = Vec::new();
    if let Some(live) = old.map(|old| &facts.lives[old]) {
        let component = live.component;
        let kind = spec.execution_context.kind;
        let pairs = [
            ("node", live.node.to_owned(), want.node.to_owned()),
            (
                "manager",
                live.manager.key.name.clone(),
                want.key.name.clone(),
            ),
            ("type", component.type_name.clone(), spec.type_name.clone()),
            (
                "executionKind",
                format!("{:?}", component.execution_kind),
                format!("{kind:?}"),
            ),
            (
                "executionContext",
                context_name(component.execution_context.as_ref()),
                context_name(spec.execution_context.shared().as_ref()),
            ),
            (
                "standIn",
                component.stand_in.to_string(),
                want.placed.stand_in.is_some().to_string(),
            ),
        ];
        for (field, old, new) in pairs {
            if old != new {
                fields.push(FieldChange {
                    field: field.to_owned(),
                    old: Some(old),
                    new: Some(new),
                });
            }
        }
        fields.extend(details::resources(component, want));
        // What changes on the way is worth knowing too.
        fields.extend(differences(spec, component));
    }
    Change {
        action: if old.is_some() {
            Action::Restart
        } else {
            Action::Add
        },
        target: target::component(id.instance),
        system: Some(want.system.name.clone()),
        node: None,
        reason: reason.to_owned(),
        fields,
    }
}

fn context_name(shared: Option<&SharedExecutionContext>) -> String {
    shared.map_or("its own", |shared| &shared.name).to_owned()
}

fn changed<'a>(
    facts: &Facts<'a>,
    decisions: &Decisions<'a>,
    down: &Down<'a>,
    up: &Up<'a>,
    id: Id<'a>,
) -> Option<Change> {
    let live = &facts.lives[decisions.present[&id]];
    let in_place = up.in_place.get(&id);
    let mut fields = in_place.map_or(Vec::new(), |change| change.fields.clone());
    let mut reasons: Vec<String> = in_place.map(|c| c.reason.clone()).into_iter().collect();
    let to = if up.activates.contains_key(&id) {
        Some(LifeCycleState::Active)
    } else {
        let idled = up.resets.contains_key(&id) || down.idled.contains_key(&id);
        idled.then_some(LifeCycleState::Inactive)
    };
    if let Some(to) = to {
        let state = live.component.state;
        let by_hand = drift::deactivated(live.component);
        fields.push(FieldChange {
            field: "state".to_owned(),
            old: Some(format!("{state:?}")),
            new: Some(format!("{to:?}")),
        });
        reasons.push(match state {
            LifeCycleState::Error => "is in Error: reset".to_owned(),
            LifeCycleState::Active => up.waits.get(&id).cloned().unwrap_or_default(),
            _ if by_hand => "was deactivated by hand: activated".to_owned(),
            _ => format!("is {state:?}: activated"),
        });
    }
    if reasons.is_empty() {
        return None;
    }
    Some(Change {
        action: Action::Change,
        target: target::component(id.instance),
        system: live.component.system.as_ref().map(|s| s.name.clone()),
        node: None,
        reason: reasons.join("; "),
        fields,
    })
}

fn removed<'a>(facts: &Facts<'a>, decisions: &Decisions<'a>, live: &Live<'a>) -> Option<Change> {
    let reason = match live.id() {
        None => "was made by hand and ends with its process".to_owned(),
        Some(id) => match (decisions.makes.get(&id), decisions.waits.get(&id)) {
            (Some(make), _) if make.old.is_some_and(|old| is(&facts.lives[old], live)) => {
                return None;
            }
            (None, Some(why)) if stops_for_a_peer(facts, decisions, id) => why.clone(),
            (None, Some(why)) if !decisions.present.contains_key(&id) => {
                format!("ends with its process, and cannot be made again now: {why}")
            }
            _ if facts.wants.contains_key(&id) => {
                let manager = live.manager.key.display_name();
                format!("a second instance, in manager {manager} on {}", live.node)
            }
            _ if facts.has_members(id.uid) => "is not in the system any more".to_owned(),
            _ => "its system is torn down".to_owned(),
        },
    };
    Some(Change {
        action: Action::Remove,
        target: target::component(&live.component.instance),
        system: live.component.system.as_ref().map(|s| s.name.clone()),
        node: None,
        reason,
        fields: details::live(live),
    })
}

/// A change that cannot be made now.
fn blocked(mut change: Change, why: Option<&String>) -> Change {
    if let Some(why) = why {
        change.reason = format!("{}; blocked: {why}", change.reason);
    }
    change
}

/// The change of a desired component that has no steps now. None where its node or process cannot be seen.
fn waits<'a>(
    facts: &Facts<'a>,
    decisions: &Decisions<'a>,
    down: &Down<'a>,
    up: &Up<'a>,
    id: Id<'a>,
    why: &String,
) -> Option<Change> {
    let want = &facts.wants[&id];
    let live = decisions.present.get(&id).map(|live| &facts.lives[*live]);
    let here = facts.processes.get(&want.seat()).copied();
    let here = here.filter(|_| !decisions.stops.contains_key(&want.seat()));
    let there = live.map(|live| live.manager);
    let unseen = decisions.unseen.contains(&id);
    let silent = unseen || here.into_iter().chain(there).any(|m| !m.responsive);
    let shown = up.in_place.contains_key(&id)
        || up.resets.contains_key(&id)
        || down.idled.contains_key(&id)
        || stops_for_a_peer(facts, decisions, id);
    if silent || shown || decisions.makes.contains_key(&id) || facts.unknown.contains_key(want.node)
    {
        return None;
    }
    let mut fields = Vec::new();
    let (action, reason) = match live {
        None => {
            fields = details::wanted(want);
            (Action::Add, "is not there yet".to_owned())
        }
        Some(live) => {
            let state = live.component.state;
            let change = in_place(want.placed, live.component);
            fields.extend(change.map_or(Vec::new(), |change| change.fields));
            let left = drift::left_inactive(want.placed, live.component);
            if state != LifeCycleState::Active && !left {
                fields.push(FieldChange {
                    field: "state".to_owned(),
                    old: Some(format!("{state:?}")),
                    new: Some("Active".to_owned()),
                });
            }
            let reason = match state {
                LifeCycleState::Active => "is not as written".to_owned(),
                _ => format!("is {state:?}"),
            };
            (Action::Change, reason)
        }
    };
    let change = Change {
        action,
        target: target::component(id.instance),
        system: Some(want.system.name.clone()),
        node: None,
        reason,
        fields,
    };
    Some(blocked(change, Some(why)))
}

/// True when it goes though its process stays: its end is shown.
fn stops_for_a_peer<'a>(facts: &Facts<'a>, decisions: &Decisions<'a>, id: Id<'a>) -> bool {
    let gone = |ix: &usize| {
        let stays = !decisions.stops.contains_key(&facts.lives[*ix].seat());
        stays && decisions.fates[*ix] == Fate::Gone
    };
    !decisions.present.contains_key(&id) && facts.instances(id).iter().any(gone)
}

fn is(one: &Live<'_>, other: &Live<'_>) -> bool {
    std::ptr::eq(one.component, other.component)
}

fn connectors(facts: &Facts<'_>, links: &Links<'_>, down: &Down<'_>, changes: &mut Vec<Change>) {
    for (key, wait) in links.waits.iter().filter(|(_, wait)| wait.missing) {
        let change = Change {
            action: Action::Add,
            target: target::connector(key.1),
            system: Some(wait.system.name.clone()),
            node: None,
            reason: "is not connected".to_owned(),
            fields: facts
                .links
                .get(key)
                .map_or(Vec::new(), |link| made_with(&link.connector.spec)),
        };
        changes.push(blocked(change, Some(&wait.reason)));
    }
    for join in links.joins.values() {
        changes.push(Change {
            action: if join.again {
                Action::Change
            } else {
                Action::Add
            },
            target: target::connector(&join.connector.spec.name),
            system: Some(join.system.name.clone()),
            node: None,
            reason: join.reason.clone(),
            fields: details::joined(facts, join),
        });
    }
    for (key, cut) in links.cuts.iter() {
        if !links.joins.contains_key(key) {
            let change = Change {
                action: Action::Remove,
                target: target::connector(&cut.connector.name),
                system: cut.system.map(|system| system.name.clone()),
                node: None,
                reason: cut.reason.clone(),
                fields: details::connector(cut.connector),
            };
            changes.push(blocked(change, down.stuck_cuts.get(key)));
        }
    }
}
