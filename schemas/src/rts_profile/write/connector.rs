//! `rts:DataPortConnectors` and `rts:ServicePortConnectors`.

use std::collections::HashMap;

use super::{property, target};
use crate::rts_profile::NAME_KEY;
use crate::rts_profile::lower::{CHOICES, free_name, unused_name};
use crate::system::{ComponentSpec, ConnectorSpec, PortKind, PortRef};
use crate::xml::Tag;

type Components<'a> = HashMap<&'a str, &'a ComponentSpec>;

/// The connectors. The name of one is written where a reader would make another from its ends.
pub(super) fn connectors(specs: &[ConnectorSpec], components: &Components<'_>) -> Vec<Tag> {
    let mut used = HashMap::new();
    let tag = |spec: &ConnectorSpec| {
        let ends = format!("{}-{}", spec.source, spec.target);
        let own = free_name(&ends, &used).0 != spec.name;
        unused_name(if own { spec.name.clone() } else { ends }, &mut used);
        connector(spec, own, components)
    };
    specs.iter().map(tag).collect()
}

fn connector(spec: &ConnectorSpec, own_name: bool, components: &Components<'_>) -> Tag {
    let others = spec.properties.iter().filter(|(key, value)| {
        let choice = CHOICES.contains(&key.as_str()) && !value.is_empty();
        let interval = *key == INTERVAL && push_interval(spec).is_some();
        spec.kind == PortKind::Service || !(choice || interval)
    });
    let (element, type_name, source, target) = match spec.kind {
        PortKind::Data => (
            "rts:DataPortConnectors",
            "rtsExt:dataport_connector_ext",
            "rts:sourceDataPort",
            "rts:targetDataPort",
        ),
        PortKind::Service => (
            "rts:ServicePortConnectors",
            "rtsExt:serviceport_connector_ext",
            "rts:sourceServicePort",
            "rts:targetServicePort",
        ),
    };
    let tag = Tag::new(element)
        .with("xsi:type", type_name)
        .with("rts:connectorId", &spec.name)
        .with("rts:name", &spec.name);
    let tag = match spec.kind {
        PortKind::Data => data_attributes(tag, spec),
        PortKind::Service => tag,
    };
    tag.holding([
        end(source, &spec.source, components),
        end(target, &spec.target, components),
    ])
    .holding(own_name.then(|| property(NAME_KEY, &spec.name)))
    .holding(others.map(|(name, value)| property(name, value)))
}

/// The schema requires a data type, an interface type and a data-flow type; what nobody said is empty or `Any`.
fn data_attributes(tag: Tag, spec: &ConnectorSpec) -> Tag {
    let [interface, dataflow, subscription] = CHOICES.map(|name| spec.properties.get(name));
    tag.with("rts:dataType", spec.data_type.as_deref().unwrap_or("Any"))
        .with("rts:interfaceType", interface.map_or("", String::as_str))
        .with("rts:dataflowType", dataflow.map_or("", String::as_str))
        .with_some(
            "rts:subscriptionType",
            subscription.filter(|s| !s.is_empty()),
        )
        .with_some("rts:pushInterval", push_interval(spec))
}

const INTERVAL: &str = "dataport.push_interval";

/// Seconds between samples; what is no such number stays a property.
fn push_interval(spec: &ConnectorSpec) -> Option<&String> {
    let interval = spec.properties.get(INTERVAL)?;
    let seconds = interval.parse::<f64>().ok()?;
    (seconds > 0.0 && seconds.is_finite()).then_some(interval)
}

fn end(element: &'static str, end: &PortRef, components: &Components<'_>) -> Tag {
    let component = components.get(end.instance.as_str()).copied();
    let tag = Tag::new(element)
        .with("xsi:type", "rtsExt:target_port_ext")
        .with("rts:portName", end.to_string());
    target(tag, component, &end.instance)
}
