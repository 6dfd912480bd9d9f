//! Connectors go into the port that they start from.

use std::collections::HashMap;

use crate::form::Stray;
use crate::rts_profile::forms::{TargetPort, v01};
use crate::rts_profile::versions::instance;
use crate::rts_profile::versions::kept::{keep, keep_as};
use crate::rts_profile::versions::ports::{Connector, Port};
use crate::span::{Span, Text};

/// Puts the connectors into their ports. One that starts from no component has no place.
pub(super) fn down<P: Port>(
    connectors: Vec<P::Connector>,
    components: &mut [v01::Component],
    index: &HashMap<String, usize>,
) {
    let mut placed = Vec::with_capacity(connectors.len());
    for mut connector in connectors {
        let Some(source) = connector.source().take() else {
            continue;
        };
        let Some(at) = index.get(instance(Some(&source))) else {
            continue;
        };
        if let Some(component) = components.get_mut(*at) {
            let port = into::<P>(&mut connector, *source, component);
            placed.push(((*at, port), connector));
        }
    }
    // Read again, they come in the order of the ports.
    let sorted = placed.is_sorted_by_key(|(port, _)| *port);
    for (number, ((at, port), mut connector)) in placed.into_iter().enumerate() {
        if !sorted {
            let number = Text::new(number.to_string(), Span::default());
            keep(&mut connector.typed(), "position", Some(number));
        }
        let ports = components.get_mut(at).map(P::all);
        if let Some(port) = ports.and_then(|ports| ports.get_mut(port)) {
            port.connectors().push(connector);
        }
    }
}

/// The port that a connector starts from; one that is not declared is. What the source says beyond is kept.
fn into<P: Port>(
    connector: &mut P::Connector,
    mut source: TargetPort,
    component: &mut v01::Component,
) -> usize {
    let instance = instance(Some(&source)).to_owned();
    let (own_name, own_id) = (component.instance_name.clone(), component.id.clone());
    let wanted = bare(&instance, source.port_name.as_ref()).to_owned();
    let ports = P::all(component);
    let same = |port: &mut P| {
        let name = port.name().as_ref();
        name.is_some() && bare(&instance, name) == wanted
    };
    let found = ports.iter_mut().position(same);
    let at = found.unwrap_or(ports.len());
    if found.is_none() {
        let mut port = P::default();
        port.name().clone_from(&source.port_name);
        ports.push(port);
    }
    let port_name = ports.get_mut(at).and_then(|port| port.name().clone());
    if has_more(&mut source, connector) {
        *connector.source() = Some(Box::new(source));
    } else {
        let of = &mut connector.typed();
        for (name, said, known) in [
            ("source.portName", source.port_name, port_name),
            ("source.instanceName", source.instance_name, own_name),
            ("source.componentId", source.component_id, own_id),
        ] {
            let value = |text: &Option<Text>| text.as_ref().map(|text| text.value.clone());
            if value(&said) != value(&known) {
                keep(of, name, said);
            }
        }
        if let Some(xsi_type) = source.xsi_type {
            keep(of, "source.type", Some(xsi_type));
        }
        for property in source.properties {
            let name = match &property.name {
                Some(name) => format!("source.property.{}", name.value),
                None => "source.property".to_owned(),
            };
            keep_as(of, &name, property);
        }
    }
    if found.is_none() {
        keep(&mut connector.typed(), "source.undeclared", None);
    }
    at
}

/// True when the source has what no schema knows, or there is a second one that would be taken for it: then it stays
/// where it is. Its comments go to the connector.
fn has_more(source: &mut TargetPort, connector: &mut impl Connector) -> bool {
    let is_source =
        |stray: &Stray| matches!(stray, Stray::Element(e) if e.local().starts_with("source"));
    if connector.beside().get().strays.iter().any(is_source) {
        return true;
    }
    if source.extra.is_empty() {
        return false;
    }
    let beside = source.extra.get();
    let is_comment = |stray: &Stray| matches!(stray, Stray::Comment(_) | Stray::Instruction(_));
    let declares = |name: &str| name == "xmlns" || name.starts_with("xmlns:");
    if !beside.keys.is_empty()
        || !beside.strays.iter().all(is_comment)
        || !beside.attributes.iter().all(|a| declares(&a.qname))
    {
        return true;
    }
    let mut comments = beside.strays.clone();
    if !comments.is_empty() {
        connector.beside().edit().strays.append(&mut comments);
    }
    false
}

/// The name of a port without that of its instance.
fn bare<'a>(instance: &str, port: Option<&'a Text>) -> &'a str {
    let port = port.map_or("", Text::trimmed);
    let rest = port.strip_prefix(instance);
    rest.and_then(|rest| rest.strip_prefix('.')).unwrap_or(port)
}
