//! What would be stored and is no step: policies, orders, words of a placement that move nothing. A plan says it all the
//! same, so that nothing is stored that it is silent about. Pure.

mod words;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rts_plan::plan::{Action, Change, FieldChange, Plan};
use rts_plan::render::details;
use rts_schemas::system::SystemSpec;

use self::words::{Words, words};
use crate::publish::drift::short;
use crate::store::SystemRecord;

/// Why such a change is there.
const REASON: &str = "is stored; nothing that runs changes for it";

/// Adds to a plan what differs between the stored record and the one that would replace it, where no change says it yet.
/// A change of the target that is there already gets the fields.
pub fn tell(plan: &mut Plan, old: &SystemRecord, new: &SystemRecord) {
    let mut new = new.clone();
    if old.spec.full_id.is_empty() {
        // Of a system that was taken in from its nodes the id was never known: to learn it changes nothing.
        Arc::make_mut(&mut new.spec).full_id.clear();
    }
    let beside = |record: &SystemRecord| {
        let (digests, places) = (record.digests.clone(), record.places.clone());
        (digests, places, record.stand_ins.clone())
    };
    if new.spec != old.spec || beside(old) != beside(&new) {
        differs(plan, old, &new);
    }
}

fn differs(plan: &mut Plan, old: &SystemRecord, new: &SystemRecord) {
    let name = new.name();
    let mut own = Own { name, plan };
    let (before, now) = (words(&old.spec), words(&new.spec));
    for (target, now) in &now {
        if let Some(before) = before.get(target) {
            own.add(target, differences(before, now));
        }
    }
    let system = format!("system/{name}");
    own.add(&system, own.lists(&old.spec, &new.spec));
    if !own.any() {
        own.add(&system, kept(old, new));
    }
    plan.changes
        .sort_by(|a, b| (&a.target, &a.system, a.action).cmp(&(&b.target, &b.system, b.action)));
}

fn differences(before: &Words, now: &Words) -> Vec<FieldChange> {
    let names: BTreeSet<&String> = before.keys().chain(now.keys()).collect();
    let differs = |name: &&String| before.get(*name) != now.get(*name);
    let names = names.into_iter().filter(differs);
    names
        .map(|name| {
            let text = |words: &Words| words.get(name).map(|word| word.text.clone());
            changed(name, text(before), text(now))
        })
        .collect()
}

/// Of texts that are cut, the new one says that it is another.
fn changed(field: &str, old: Option<String>, new: Option<String>) -> FieldChange {
    let same = old == new;
    FieldChange {
        field: field.to_owned(),
        old,
        new: new.map(|new| if same { format!("{new}, changed") } else { new }),
    }
}

/// What is kept of a system beside its spec: stand-ins, module files and places.
fn kept(old: &SystemRecord, new: &SystemRecord) -> Vec<FieldChange> {
    let differs = |what: &str, old: &BTreeMap<String, String>, new: &BTreeMap<String, String>| {
        let names: BTreeSet<&String> = old.keys().chain(new.keys()).collect();
        let names = names.into_iter().filter(|n| old.get(*n) != new.get(*n));
        names
            .map(|n| {
                changed(
                    &format!("{what}.{n}"),
                    old.get(n).cloned(),
                    new.get(n).cloned(),
                )
            })
            .collect::<Vec<_>>()
    };
    let names = |record: &SystemRecord| {
        let names = record.stand_ins.keys();
        names
            .map(|name| (name.clone(), "true".to_owned()))
            .collect()
    };
    let mut fields = differs("standIns", &names(old), &names(new));
    fields.extend(differs("modules", &old.digests, &new.digests));
    fields.extend(differs("places", &old.places, &new.places));
    if fields.is_empty() && old.spec != new.spec {
        fields.push(changed(
            "spec",
            Some("other words".into()),
            Some("other words".into()),
        ));
    }
    fields
}

/// The changes of one system in a plan.
struct Own<'a> {
    name: &'a str,
    plan: &'a mut Plan,
}

impl Own<'_> {
    fn any(&self) -> bool {
        let mut changes = self.plan.changes.iter();
        changes.any(|change| change.system.as_deref() == Some(self.name))
    }

    fn position(&self, target: &str) -> Option<usize> {
        let own = |c: &Change| c.target == target && c.system.as_deref() == Some(self.name);
        self.plan.changes.iter().position(own)
    }

    fn add(&mut self, target: &str, mut fields: Vec<FieldChange>) {
        let Some(at) = self.position(target) else {
            if !fields.is_empty() {
                self.plan.changes.push(Change {
                    action: Action::Change,
                    target: target.to_owned(),
                    system: Some(self.name.to_owned()),
                    node: None,
                    reason: REASON.to_owned(),
                    fields,
                });
            }
            return;
        };
        fields.retain(|field| !says(&self.plan.changes[at], &field.field));
        if fields.is_empty() {
            return;
        }
        // What is added says its fields in its steps as long as it has none of its own.
        let made = details(self.plan).into_iter().nth(at);
        if let (Some(change), Some(made)) = (self.plan.changes.get_mut(at), made) {
            change.fields = made.fields;
            change.fields.extend(fields);
        }
    }

    /// The names of components and connectors, where some come or go without a change, or stand in another order.
    fn lists(&self, old: &SystemSpec, new: &SystemSpec) -> Vec<FieldChange> {
        let components = |spec: &SystemSpec| -> Vec<String> {
            spec.components.iter().map(|c| c.instance.clone()).collect()
        };
        let connectors = |spec: &SystemSpec| -> Vec<String> {
            spec.connectors.iter().map(|c| c.name.clone()).collect()
        };
        let lists = [
            ("component", components(old), components(new)),
            ("connector", connectors(old), connectors(new)),
        ];
        let lists = lists.into_iter();
        lists
            .filter_map(|(kind, old, new)| self.list(kind, &old, &new))
            .collect()
    }

    fn list(&self, kind: &str, old: &[String], new: &[String]) -> Option<FieldChange> {
        let (there, wanted): (BTreeSet<_>, BTreeSet<_>) =
            (old.iter().collect(), new.iter().collect());
        let told = |name: &&String| self.position(&format!("{kind}/{name}")).is_some();
        let all_told = there.symmetric_difference(&wanted).all(told);
        let stay = |names: &[String], others: &BTreeSet<&String>| -> Vec<String> {
            names
                .iter()
                .filter(|n| others.contains(n))
                .cloned()
                .collect()
        };
        if all_told && stay(old, &wanted) == stay(new, &there) {
            return None;
        }
        let text = |names: &[String]| (!names.is_empty()).then(|| short(&names.join(", ")));
        Some(changed(&format!("{kind}s"), text(old), text(new)))
    }
}

/// True when a change tells of a field, or makes its target with it.
fn says(change: &Change, field: &str) -> bool {
    let placed = |f: &str| f == "manager" || f == "node";
    let mut fields = change.fields.iter().map(|f| f.field.as_str());
    match field.split('.').next() {
        Some("policy" | "required" | "fullId" | "ports") => false,
        _ if change.action != Action::Change => true,
        Some("placement") => fields.any(placed),
        _ => fields.any(|f| f == field),
    }
}

#[cfg(test)]
mod tests;
