//! `rts:Components`.

use super::property;
use crate::names;
use crate::placement::{PREFIX, settings};
use crate::rts_profile::TYPE_KEY;
use crate::system::{
    ComponentSpec, CompositeSpec, Configuration, Direction, ExecutionContextSpec, ExecutionKind,
    PortKind, PortSpec,
};
use crate::xml::Tag;

pub(super) fn component((index, spec): (usize, &ComponentSpec)) -> Tag {
    let by_id = names::type_name(&spec.full_id, &spec.instance);
    let own_type = by_id.as_deref() != Some(&spec.type_name);
    let keys = settings(spec).into_iter();
    let active = spec.configuration.active.as_deref();
    Tag::new("rts:Components")
        .with("xsi:type", "rtsExt:component_ext")
        .with("rts:instanceName", &spec.instance)
        .with("rts:id", &spec.full_id)
        .with("rts:pathUri", path_uri(spec))
        .with_some("rts:activeConfigurationSet", active)
        .with("rts:compositeType", "None")
        .with("rts:isRequired", spec.required.to_string())
        .holding(ports(spec, PortKind::Data))
        .holding(ports(spec, PortKind::Service))
        .holding(configuration_sets(&spec.configuration))
        .holding([execution_context(&spec.execution_context)])
        .holding([location(index)])
        .holding(own_type.then(|| property(TYPE_KEY, &spec.type_name)))
        .holding(keys.map(|(key, value)| property(&format!("{PREFIX}{key}"), &value)))
}

/// A composite: its members by their names, and the ports that it exports.
pub(super) fn composite<'a>(
    (index, spec): (usize, &CompositeSpec),
    id_of: impl Fn(&str) -> Option<&'a str>,
) -> Tag {
    let by_id = names::type_name(&spec.full_id, &spec.instance);
    let own_type = by_id.as_deref() != Some(&spec.type_name);
    let members = spec.members.iter().map(|member| {
        let target = Tag::new("rts:Participant")
            .with("xsi:type", "rtsExt:target_component_ext")
            .with("rts:instanceName", member)
            .with("rts:componentId", id_of(member).unwrap_or_default());
        Tag::new("rts:Participants").holding([target])
    });
    let exported = (!spec.exported_ports.is_empty()).then(|| {
        let data = Tag::new("rts:ConfigurationData")
            .with("rts:name", "exported_ports")
            .with("rts:data", spec.exported_ports.join(","));
        Tag::new("rts:ConfigurationSets")
            .with("rts:id", "default")
            .holding([data])
    });
    Tag::new("rts:Components")
        .with("xsi:type", "rtsExt:component_ext")
        .with("rts:instanceName", &spec.instance)
        .with("rts:id", &spec.full_id)
        .with("rts:pathUri", format!("localhost/{}.rtc", spec.instance))
        .with("rts:compositeType", spec.kind.as_str())
        .with("rts:isRequired", spec.required.to_string())
        .holding(exported)
        .holding([execution_context(&spec.execution_context)])
        .holding(members)
        .holding([location(index)])
        .holding(own_type.then(|| property(TYPE_KEY, &spec.type_name)))
}

/// A name server's address and a path below it. The address says the host; `localhost` says none.
fn path_uri(spec: &ComponentSpec) -> String {
    let instance = &spec.instance;
    let plain = |host: &str| {
        host.chars()
            .all(|c| c.is_alphanumeric() || matches!(c, '-' | '_' | '.'))
    };
    match spec.placement.host.as_deref() {
        None | Some("") => format!("localhost/{instance}.rtc"),
        Some(host) if plain(host) => format!("{host}/{instance}.rtc"),
        Some(address) => format!("[{address}]/{instance}.rtc"),
    }
}

fn ports(spec: &ComponentSpec, kind: PortKind) -> impl Iterator<Item = Tag> {
    let ports = spec.ports.iter().filter(move |port| port.kind == kind);
    ports.map(move |port| {
        let name = format!("{}.{}", spec.instance, port.name);
        match kind {
            PortKind::Data => Tag::new("rts:DataPorts")
                .with("xsi:type", "rtsExt:dataport_ext")
                .with("rts:name", name)
                .holding(data_port_properties(port)),
            PortKind::Service => Tag::new("rts:ServicePorts")
                .with("xsi:type", "rtsExt:serviceport_ext")
                .with("rts:name", name)
                .holding([property("port.port_type", "CorbaPort")]),
        }
    })
}

fn data_port_properties(port: &PortSpec) -> impl Iterator<Item = Tag> {
    let direction = port.direction.map(|direction| match direction {
        Direction::In => property("port.port_type", "DataInPort"),
        Direction::Out => property("port.port_type", "DataOutPort"),
    });
    let data_type = port.data_type.as_ref();
    let data_type = data_type.map(|name| property("dataport.data_type", name));
    direction.into_iter().chain(data_type)
}

fn configuration_sets(configuration: &Configuration) -> impl Iterator<Item = Tag> {
    configuration.sets.iter().map(|(name, values)| {
        let values = values.iter().map(|(name, value)| {
            Tag::new("rts:ConfigurationData")
                .with("rts:name", name)
                .with("rts:data", value)
        });
        Tag::new("rts:ConfigurationSets")
            .with("rts:id", name)
            .holding(values)
    })
}

fn execution_context(spec: &ExecutionContextSpec) -> Tag {
    let kind = match spec.kind {
        ExecutionKind::Periodic => "PERIODIC",
        ExecutionKind::EventDriven => "EVENT_DRIVEN",
        ExecutionKind::Other => "OTHER",
    };
    Tag::new("rts:ExecutionContexts")
        .with("xsi:type", "rtsExt:execution_context_ext")
        .with("rts:id", &spec.id)
        .with("rts:kind", kind)
        .with_some("rts:rate", spec.rate.map(|rate| format!("{rate:?}")))
}

/// A place in the editor's drawing: rows of five, so that no component hides another.
fn location(index: usize) -> Tag {
    let (row, column) = (index / 5, index % 5);
    Tag::new("rtsExt:Location")
        .with("rtsExt:x", (40 + 200 * column).to_string())
        .with("rtsExt:y", (40 + 160 * row).to_string())
        .with("rtsExt:width", "-1")
        .with("rtsExt:height", "-1")
        .with("rtsExt:direction", "RIGHT")
}
