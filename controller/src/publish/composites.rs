//! Composite components as objects: their state is what their members make of it.

use std::collections::BTreeMap;

use rts_controller_api::objects::{
    Component, ComponentStatus, ComponentView, CompositeView, Kind, Metadata,
};
use rts_schemas::composite::Composites;
use rts_schemas::system::CompositeSpec;

use super::{Scene, object};
use crate::store::SystemRecord;

/// The composites of all systems; `components` are those that they may stand for.
pub fn composites(scene: &Scene<'_>, components: &[Component]) -> Vec<Component> {
    let records = scene.systems.values();
    let records = records.filter(|record| !record.spec.composites.is_empty());
    records
        .flat_map(|record| of_system(record, components))
        .collect()
}

fn of_system(record: &SystemRecord, components: &[Component]) -> Vec<Component> {
    let own = components.iter();
    let own = own.filter(|component| component.spec.system == record.name());
    let own: BTreeMap<&str, &Component> = own.map(|c| (c.metadata.name.as_str(), c)).collect();
    let all = Composites::of(&record.spec.composites);
    let made = record.spec.composites.iter().map(|composite| {
        let leaves = all.leaves(&composite.instance).into_iter();
        let members: Vec<&Component> = leaves.filter_map(|leaf| own.get(leaf).copied()).collect();
        of_composite(record, composite, &members)
    });
    made.collect()
}

fn of_composite(
    record: &SystemRecord,
    composite: &CompositeSpec,
    members: &[&Component],
) -> Component {
    let common = |of: fn(&ComponentStatus) -> &String| {
        let mut all = members.iter().map(|member| of(&member.status));
        let first = all.next().cloned().unwrap_or_default();
        match all.all(|other| *other == first) {
            true => first,
            false => String::new(),
        }
    };
    let names = members.iter().map(|member| member.metadata.name.clone());
    let status = ComponentStatus {
        state: state(members).to_owned(),
        node: common(|status| &status.node),
        manager: common(|status| &status.manager),
        message: message(members),
        rate: composite.execution_context.rate,
        created: members
            .iter()
            .filter_map(|member| member.status.created)
            .max(),
        ..ComponentStatus::default()
    };
    let metadata = Metadata {
        name: composite.instance.clone(),
        uid: format!("{}/{}", record.uid, composite.instance),
        generation: record.generation,
        creation_timestamp: status.created,
        ..Metadata::default()
    };
    let spec = ComponentView {
        system: record.name().to_owned(),
        type_name: composite.type_name.clone(),
        required: composite.required,
        composite: Some(CompositeView {
            kind: composite.kind,
            members: names.collect(),
        }),
        ..ComponentView::default()
    };
    object(Kind::Component, metadata, spec, status)
}

/// An error of one is that of all; it is Active when all are.
fn state(members: &[&Component]) -> &'static str {
    let any = |state: &str| members.iter().any(|member| member.status.state == state);
    let worst = ["Error", "Unknown", "Created", "Inactive"];
    match worst.into_iter().find(|state| any(state)) {
        Some(worst) => worst,
        None if members.is_empty() => "Unknown",
        None => "Active",
    }
}

fn message(members: &[&Component]) -> Option<String> {
    let failed = members
        .iter()
        .find(|member| member.status.state == "Error")?;
    let why = failed.status.message.as_deref().unwrap_or("in Error");
    Some(format!("{}: {why}", failed.metadata.name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_state_of_a_composite_is_the_worst_of_its_members() {
        let member = |state: &str| {
            let mut component: Component = object(
                Kind::Component,
                Metadata::default(),
                ComponentView::default(),
                ComponentStatus::default(),
            );
            state.clone_into(&mut component.status.state);
            component
        };
        let of = |states: &[&str]| {
            let members: Vec<_> = states.iter().map(|state| member(state)).collect();
            state(&members.iter().collect::<Vec<_>>())
        };
        assert_eq!(of(&["Active", "Active"]), "Active");
        assert_eq!(of(&["Active", "Inactive"]), "Inactive");
        assert_eq!(of(&["Inactive", "Unknown"]), "Unknown");
        assert_eq!(of(&["Unknown", "Error"]), "Error");
        assert_eq!(of(&[]), "Unknown");
    }
}
