//! The one model → an RTS Profile 0.2 in XML, which RT System Editor and rtshell read, and this crate as the same model.
//!
//! What a profile has no place for is said in properties `rtsctl.*`.

mod component;
mod connector;
mod order;
mod sayable;

pub use sayable::sayable;

use std::collections::HashMap;

use super::NAME_KEY;
use crate::names;
use crate::system::{ComponentSpec, SystemSpec};
use crate::xml::{self, Tag};

/// What a profile says besides the system.
#[derive(Debug, Clone, Copy)]
pub struct WriteOptions<'a> {
    /// `rts:creationDate`: a time as XML Schema has it (`2026-01-15T10:00:00`).
    pub created: &'a str,
    /// `rts:updateDate`, in the same form.
    pub updated: &'a str,
    /// `rts:abstract`: what the system is for; may be empty.
    pub abstract_text: &'a str,
}

/// Writes a system as an RTS Profile 0.2: XML in UTF-8, indented, one element a line.
///
/// Reading and lowering it gives [`sayable`] of the system, which is the system itself when it came from a profile.
pub fn write(spec: &SystemSpec, options: &WriteOptions<'_>) -> String {
    let spec = sayable(spec);
    let components: HashMap<&str, &ComponentSpec> = spec
        .components
        .iter()
        .map(|component| (component.instance.as_str(), component))
        .collect();
    let name = names::system_name(&spec.full_id, None);
    let own_name = (name.as_deref() != Some(&spec.name)).then(|| property(NAME_KEY, &spec.name));
    let root = Tag::new("rts:RtsProfile")
        .with("xmlns:rts", super::forms::RTS)
        .with("xmlns:rtsExt", super::forms::RTS_EXT)
        .with("xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance")
        .with_some(
            "xsi:type",
            own_name.is_some().then_some("rtsExt:rts_profile_ext"),
        )
        .with("rts:id", &spec.full_id)
        .with("rts:version", "0.2")
        .with("rts:abstract", options.abstract_text)
        .with("rts:creationDate", options.created)
        .with("rts:updateDate", options.updated)
        .holding(spec.components.iter().enumerate().map(component::component))
        .holding(composites(&spec, &components))
        .holding(connector::connectors(&spec.connectors, &components))
        .holding(order::orders(&spec.orders, &components))
        .holding(own_name);
    xml::write(&root)
}

/// Composites stand after the components that they stand for.
fn composites<'a>(
    spec: &'a SystemSpec,
    components: &'a HashMap<&str, &ComponentSpec>,
) -> impl Iterator<Item = Tag> + 'a {
    let first = spec.components.len();
    let all = spec.composites.iter().enumerate();
    all.map(move |(index, composite)| {
        component::composite((first + index, composite), |member| {
            let component = components.get(member).map(|found| found.full_id.as_str());
            let mut composites = spec.composites.iter();
            let of_composite = composites.find(|other| other.instance == member);
            component.or(of_composite.map(|found| found.full_id.as_str()))
        })
    })
}

/// `rtsExt:Properties`.
fn property(name: &str, value: &str) -> Tag {
    Tag::new("rtsExt:Properties")
        .with("rtsExt:name", name)
        .with("rtsExt:value", value)
}

/// An element that refers to a component.
fn target(tag: Tag, component: Option<&ComponentSpec>, instance: &str) -> Tag {
    tag.with("rts:instanceName", instance).with(
        "rts:componentId",
        component.map_or("", |found| &found.full_id),
    )
}
