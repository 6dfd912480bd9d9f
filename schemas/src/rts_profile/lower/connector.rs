//! Connectors: ends, direction, data type and properties.

use std::collections::{BTreeMap, HashMap};

use super::NAME_KEY;
use crate::diagnostic::{Finding, Report};
use crate::rts_profile::model::{Component, Connector, Port, Target, property_value};
use crate::rts_profile::{ReadProfile, composite};
use crate::system::{ConnectorSpec, Direction, PortKind, PortRef};

pub(super) fn connectors(read: &ReadProfile, report: &mut Report) -> Vec<ConnectorSpec> {
    let mut used = HashMap::new();
    read.profile
        .connectors
        .iter()
        .filter_map(|connector| {
            let mut source = end(read, connector.source.as_ref()?)?;
            let mut target = end(read, connector.target.as_ref()?)?;
            if is_reversed(read, connector) {
                report.push(reversed(read, connector, &source, &target));
                std::mem::swap(&mut source, &mut target);
            }
            let own = property_value(&connector.properties, NAME_KEY);
            let name = own.map_or_else(
                || format!("{source}-{target}"),
                |own| own.trimmed().to_owned(),
            );
            let name = unused_name(name, &mut used);
            Some(ConnectorSpec {
                name,
                kind: connector.kind,
                source,
                target,
                data_type: data_type(read, connector),
                properties: properties(connector),
            })
        })
        .collect()
}

/// The name itself, or with `#2`, `#3`, … when it was given before.
pub(crate) fn unused_name(name: String, used: &mut HashMap<String, usize>) -> String {
    let (unused, count) = free_name(&name, used);
    used.insert(name, count);
    used.entry(unused.clone()).or_insert(1);
    unused
}

/// The name that [`unused_name`] would give, and its number. Numbers up to the last given one are known to be taken.
pub(crate) fn free_name(name: &str, used: &HashMap<String, usize>) -> (String, usize) {
    let Some(last) = used.get(name) else {
        return (name.to_owned(), 1);
    };
    let mut count = *last;
    loop {
        count += 1;
        let unused = format!("{name}#{count}");
        if !used.contains_key(&unused) {
            return (unused, count);
        }
    }
}

fn end(profile: &ReadProfile, target: &Target) -> Option<PortRef> {
    if let Some((member, port)) = of_member(profile, target) {
        let instance = member.instance_name.as_ref()?.trimmed().to_owned();
        return Some(PortRef { instance, port });
    }
    let instance = target.instance_name.as_ref()?.trimmed();
    let port = target.port_name.as_ref()?.trimmed();
    let bare = profile.component(instance).map_or_else(
        || {
            port.strip_prefix(instance)
                .and_then(|rest| rest.strip_prefix('.'))
                .unwrap_or(port)
        },
        |component| component.bare_port(port),
    );
    Some(PortRef {
        instance: instance.to_owned(),
        port: bare.to_owned(),
    })
}

/// The component and bare port that an end at a composite means.
fn of_member<'a>(profile: &'a ReadProfile, target: &Target) -> Option<(&'a Component, String)> {
    let composite = profile.component(target.instance_name.as_ref()?.trimmed())?;
    composite::kind(composite)?;
    composite::member_port(profile, composite, &target.port_name.as_ref()?.value)
}

/// The declared port of an end.
fn declared<'a>(profile: &'a ReadProfile, target: Option<&Target>) -> Option<(PortKind, &'a Port)> {
    let target = target?;
    if let Some((member, port)) = of_member(profile, target) {
        return member.port(&port);
    }
    let instance = &target.instance_name.as_ref()?.value;
    profile.port(instance, &target.port_name.as_ref()?.value)
}

/// The direction that a declared port's `port.port_type` says.
pub(crate) fn direction_of(port: &Port) -> Option<Direction> {
    let kind = property_value(&port.properties, "port.port_type")?;
    match kind.trimmed().to_ascii_lowercase().as_str() {
        "datainport" => Some(Direction::In),
        "dataoutport" => Some(Direction::Out),
        _ => None,
    }
}

/// The data type that a declared port says, as a repository id.
pub(crate) fn data_type_of(port: &Port) -> Option<String> {
    ["dataport.data_type", "data_type"]
        .iter()
        .find_map(|name| normal_data_type(&property_value(&port.properties, name)?.value))
}

/// True when the file starts a data connector from its in-port, as Choreonoid does now and then.
pub(crate) fn is_reversed(profile: &ReadProfile, connector: &Connector) -> bool {
    if connector.kind != PortKind::Data {
        return false;
    }
    let direction = |end: &Option<Target>| {
        declared(profile, end.as_ref()).and_then(|(_, port)| direction_of(port))
    };
    matches!(
        (direction(&connector.source), direction(&connector.target)),
        (Some(Direction::In), Some(Direction::Out) | None) | (None, Some(Direction::Out))
    )
}

fn reversed(
    read: &ReadProfile,
    connector: &Connector,
    source: &PortRef,
    target: &PortRef,
) -> Finding {
    let span = connector.source.as_ref().map_or(connector.span, |end| {
        end.port_name.as_ref().map_or(end.span, |name| name.span)
    });
    Finding::warning(
        "reversed-connector",
        format!("the connector runs from `{source}` to `{target}`, but data flows the other way"),
    )
    .at(read.place(span))
    .help(format!(
        "it is read as `{target}-{source}`; swap its ends to silence this"
    ))
}

/// `RTC::TimedLong`, `TimedLong` and `IDL:RTC/TimedLong:1.0` as `IDL:RTC/TimedLong:1.0`; `None` for nothing and `Any`.
pub(crate) fn normal_data_type(text: &str) -> Option<String> {
    let text = text.trim();
    if text.is_empty() || text.eq_ignore_ascii_case("any") {
        return None;
    }
    let (scoped, version) = match text.strip_prefix("IDL:") {
        Some(rest) => match rest
            .rsplit_once(':')
            .filter(|(head, _)| !head.ends_with(':'))
        {
            Some((scoped, version))
                if !version.is_empty() && !version.contains(|c: char| c.is_alphabetic()) =>
            {
                (scoped, version)
            }
            _ => (rest, "1.0"),
        },
        None => (text, "1.0"),
    };
    let path = scoped.replace("::", "/");
    let path = path.trim_matches(['/', ':']);
    if path.is_empty() {
        return None;
    }
    // A bare name is one of the standard types, which live in module RTC.
    let module = if path.contains('/') { "" } else { "RTC/" };
    Some(format!("IDL:{module}{path}:{version}"))
}

/// A property of the connector, else its attribute, else what the declared ports say.
fn data_type(profile: &ReadProfile, connector: &Connector) -> Option<String> {
    if connector.kind == PortKind::Service {
        return None;
    }
    let from_property = [
        "dataport.data_type",
        "dataport.outport.data_type",
        "dataport.inport.data_type",
    ]
    .iter()
    .find_map(|name| normal_data_type(&property_value(&connector.properties, name)?.value));
    let from_port = |end: &Option<Target>| {
        declared(profile, end.as_ref()).and_then(|(_, port)| data_type_of(port))
    };
    from_property
        .or_else(|| normal_data_type(&connector.data_type.as_ref()?.value))
        .or_else(|| from_port(&connector.source))
        .or_else(|| from_port(&connector.target))
}

/// Values that name a choice and come in any case.
pub(crate) const CHOICES: [&str; 3] = [
    "dataport.interface_type",
    "dataport.dataflow_type",
    "dataport.subscription_type",
];

pub(crate) fn properties(connector: &Connector) -> BTreeMap<String, String> {
    let mut all = BTreeMap::new();
    let attributes = [
        &connector.interface_type,
        &connector.dataflow_type,
        &connector.subscription_type,
    ];
    for (name, value) in CHOICES.into_iter().zip(attributes) {
        if let Some(value) = value.as_ref().filter(|value| !value.trimmed().is_empty()) {
            all.insert(name.to_owned(), value.trimmed().to_owned());
        }
    }
    if let Some(interval) = &connector.push_interval
        && interval
            .trimmed()
            .parse::<f64>()
            .is_ok_and(|seconds| seconds > 0.0)
    {
        all.insert(
            "dataport.push_interval".to_owned(),
            interval.trimmed().to_owned(),
        );
    }
    for property in &connector.properties {
        let Some(name) = property.name.as_ref().map(|name| name.trimmed()) else {
            continue;
        };
        let value = property.value.as_ref().map_or("", |value| value.trimmed());
        if !is_transient(name, value) {
            all.insert(name.to_owned(), value.to_owned());
        }
    }
    for name in CHOICES {
        if let Some(value) = all.get_mut(name) {
            *value = value.to_ascii_lowercase();
        }
    }
    all
}

/// What a running system left behind (references), what an editor draws by, what a newer version kept, and the type and
/// the name, which have their own fields.
fn is_transient(name: &str, value: &str) -> bool {
    const NAMES: [&str; 11] = [
        "dataport.corba_cdr.inport_ior",
        "dataport.corba_cdr.inport_ref",
        "dataport.corba_cdr.outport_ior",
        "dataport.corba_cdr.outport_ref",
        "dataport.data_type",
        "dataport.outport.data_type",
        "dataport.inport.data_type",
        "POSITION",
        "BEND_POINT",
        NAME_KEY,
        "",
    ];
    let empty_mark = value.is_empty() && matches!(name, "dataport.inport" | "dataport.outport");
    let kept = name.starts_with(crate::rts_profile::versions::kept::PREFIX);
    NAMES.contains(&name) || empty_mark || kept || value.starts_with("IOR:")
}

#[cfg(test)]
mod tests {
    use super::normal_data_type;

    #[test]
    fn data_types_become_repository_ids() {
        let long = Some("IDL:RTC/TimedLong:1.0".to_owned());
        for spelling in [
            "IDL:RTC/TimedLong:1.0",
            "TimedLong",
            "RTC::TimedLong",
            "::RTC::TimedLong",
            " RTC/TimedLong",
            "IDL:RTC/TimedLong",
        ] {
            assert_eq!(normal_data_type(spelling), long, "{spelling}");
        }
        assert_eq!(
            normal_data_type("IDL:ssr/Frame:2.0").unwrap(),
            "IDL:ssr/Frame:2.0"
        );
        assert_eq!(
            normal_data_type("Img::TimedCameraImage").unwrap(),
            "IDL:Img/TimedCameraImage:1.0"
        );
        assert_eq!(normal_data_type("Any"), None);
        assert_eq!(normal_data_type("::"), None);
    }
}
