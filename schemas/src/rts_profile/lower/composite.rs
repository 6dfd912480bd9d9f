//! Composite components: of the model, not among its components, since nothing of their own runs.

use std::collections::HashSet;

use super::component;
use crate::rts_profile::ReadProfile;
use crate::rts_profile::composite::{exported, kind, members};
use crate::system::CompositeSpec;

pub(super) fn composites(read: &ReadProfile) -> Vec<CompositeSpec> {
    let mut seen = HashSet::new();
    let all = read.profile.components.iter();
    all.filter_map(|component| {
        let instance = component.instance_name.as_ref()?.trimmed().to_owned();
        let kind = kind(component)?;
        seen.insert(instance.clone()).then_some(())?;
        Some(CompositeSpec {
            instance,
            type_name: component::type_name(component)?,
            full_id: component
                .id
                .as_ref()
                .map_or_else(String::new, |id| id.trimmed().to_owned()),
            required: component::required(component),
            kind,
            members: members(component).into_iter().map(|one| one.name).collect(),
            exported_ports: exported(component)
                .into_iter()
                .map(|one| one.name)
                .collect(),
            execution_context: component::execution_context(component),
        })
    })
    .collect()
}
