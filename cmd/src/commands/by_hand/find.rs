//! Which component, port or connector a person means.

use clap::ValueEnum;
use rts_controller_api::objects::{Component, Connector, Kind};
use rts_schemas::system::PortRef;

use crate::commands::get::{KindName, absent};
use crate::error::CliError;

/// A port of a component that is there.
#[derive(Debug, Clone)]
pub struct End<'a> {
    /// Its component.
    pub component: &'a Component,
    /// Both names.
    pub port: PortRef,
}

impl End<'_> {
    /// True for a connector of this out-port.
    pub fn sends(&self, connector: &Connector) -> bool {
        let spec = &connector.spec;
        // A connector is of the system of its out-port.
        spec.source == self.port.to_string() && spec.system == self.component.spec.system
    }

    /// True for a connector of this in-port.
    pub fn receives(&self, connector: &Connector) -> bool {
        connector.spec.target == self.port.to_string()
    }
}

/// The component of `NAME`, `NODE/NAME` or `component/NAME`.
pub fn component<'a>(text: &str, components: &'a [Component]) -> Result<&'a Component, CliError> {
    let (node, name) = split(text, Kind::Component);
    single(node, name, "", components)
}

/// The port of `NAME.PORT` or `NODE/NAME.PORT`. Names may have dots: the longest one that is there counts.
pub fn end<'a>(text: &str, components: &'a [Component]) -> Result<End<'a>, CliError> {
    let (node, rest) = split(text, Kind::Component);
    let names = components.iter().map(|c| c.metadata.name.as_str());
    let names = names.filter(|name| port_of(rest, name).is_some());
    let name = names.max_by_key(|name| name.len());
    let name = name.or_else(|| rest.rsplit_once('.').map(|(name, _)| name));
    let both = name.and_then(|name| Some((name, port_of(rest, name)?)));
    let Some((name, port)) = both.filter(|(name, _)| !name.is_empty()) else {
        return Err(CliError::usage_help(
            format!("{text:?} names no port"),
            "write INSTANCE.PORT, as in `Sine0.out`",
        ));
    };
    Ok(End {
        component: single(node, name, &format!(".{port}"), components)?,
        port: PortRef {
            instance: name.to_owned(),
            port: port.to_owned(),
        },
    })
}

/// The connectors of `NAME`, `SYSTEM/NAME` or `connector/NAME`: one of each system.
pub fn connectors<'a>(text: &str, connectors: &'a [Connector]) -> Vec<&'a Connector> {
    let (system, name) = split(text, Kind::Connector);
    let meant = |c: &&Connector| {
        c.metadata.name == name && system.is_none_or(|system| c.spec.system == system)
    };
    connectors.iter().filter(meant).collect()
}

/// The component that has the out-port of a connector.
pub fn source<'a>(connector: &Connector, components: &'a [Component]) -> Option<&'a Component> {
    let spec = &connector.spec;
    let own = components.iter().filter(|c| c.spec.system == spec.system);
    let owners = own.filter(|c| port_of(&spec.source, &c.metadata.name).is_some());
    owners.max_by_key(|c| c.metadata.name.len())
}

/// The port of an end (`out` of `Sine0.out`), when this is its component.
fn port_of<'t>(end: &'t str, instance: &str) -> Option<&'t str> {
    let port = end.strip_prefix(instance)?.strip_prefix('.')?;
    (!port.is_empty()).then_some(port)
}

/// What stands before a name, and the name, without its kind. No name of an object has a slash.
fn split(text: &str, kind: Kind) -> (Option<&str>, &str) {
    let rest = match text.split_once('/') {
        Some((word, rest)) if KindName::from_str(word, true) == Ok(KindName(kind)) => rest,
        _ => text,
    };
    match rest.split_once('/') {
        Some((before, name)) => (Some(before), name),
        None => (None, rest),
    }
}

/// The one component of a name. `port` follows the name where the ways to name it are listed.
fn single<'a>(
    node: Option<&str>,
    name: &str,
    port: &str,
    components: &'a [Component],
) -> Result<&'a Component, CliError> {
    let all: Vec<_> = components
        .iter()
        .filter(|c| c.metadata.name == name)
        .collect();
    let places = || {
        let places = all
            .iter()
            .map(|c| format!("{}/{name}{port}", c.status.node));
        format!("there are: {}", places.collect::<Vec<_>>().join(", "))
    };
    let on = |c: &&&Component| node.is_none_or(|node| c.status.node == node);
    let found: Vec<_> = all.iter().filter(on).collect();
    match (found.as_slice(), all.as_slice(), node) {
        ([component], ..) => Ok(component),
        (_, [], _) => {
            let known: Vec<_> = components.iter().map(|c| &c.metadata.name).collect();
            Err(absent(Kind::Component, name, &known))
        }
        ([], _, Some(node)) => Err(CliError::usage_help(
            format!("component/{name} is not on node/{node}"),
            places(),
        )),
        _ => Err(CliError::usage_help(
            format!("component/{name} is on several nodes"),
            places(),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::show::{lists::typed, samples};
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    fn known(names: &[(&str, &str)]) -> Vec<Component> {
        let sample: Vec<Component> =
            typed(Kind::Component, &samples::values(Kind::Component)).unwrap();
        let named = names.iter().map(|(node, name)| {
            let mut component = sample[0].clone();
            component.metadata.name = (*name).to_owned();
            component.status.node = (*node).to_owned();
            component
        });
        named.collect()
    }

    fn error(error: CliError) -> String {
        assert_eq!(error.exit().code(), 2);
        format!("{}; {}", error.line(), error.help().unwrap_or_default())
    }

    #[test]
    fn a_component_is_named_alone_or_with_its_node_or_kind() {
        let known = known(&[("local", "Sine0"), ("local", "Filter0"), ("arm", "Filter0")]);
        let node = |text| component(text, &known).map(|c| c.status.node.clone());
        for text in [
            "Sine0",
            "local/Sine0",
            "component/Sine0",
            "comp/local/Sine0",
        ] {
            assert_eq!(node(text).unwrap(), "local", "{text}");
        }
        assert_eq!(node("arm/Filter0").unwrap(), "arm");
        let error = |text| error(node(text).unwrap_err());
        assert_eq!(
            error("Filter0"),
            "component/Filter0 is on several nodes; there are: local/Filter0, arm/Filter0"
        );
        assert_eq!(
            error("leg/Filter0"),
            "component/Filter0 is not on node/leg; there are: local/Filter0, arm/Filter0"
        );
        assert_eq!(
            error("sine0"),
            "component/sine0 is not there; did you mean `Sine0`? there are: Sine0, Filter0, Filter0"
        );
    }

    #[test]
    fn the_longest_component_that_is_there_has_the_port() {
        let known = known(&[("local", "A"), ("local", "A.b"), ("arm", "B"), ("leg", "B")]);
        let port = |text| {
            let end = end(text, &known).unwrap().port;
            (end.instance, end.port)
        };
        let both = |a: &str, b: &str| (a.to_owned(), b.to_owned());
        assert_eq!(port("A.out"), both("A", "out"));
        assert_eq!(port("A.b.out"), both("A.b", "out"));
        assert_eq!(port("A.b"), both("A", "b"));
        assert_eq!(port("arm/B.in"), both("B", "in"));
        let error = |text| error(end(text, &known).unwrap_err());
        assert_eq!(
            error("B.in"),
            "component/B is on several nodes; there are: arm/B.in, leg/B.in"
        );
        assert_eq!(
            error("C.d.in"),
            "component/C.d is not there; there are: A, A.b, B, B"
        );
        for none in ["A", "A.", ".out", "arm/", ""] {
            assert!(error(none).contains("names no port"), "{none}");
        }
    }

    proptest! {
        #[test]
        fn what_is_found_is_there_and_says_the_same(
            names in proptest::collection::vec("[ab.]{1,4}", 1..5),
            text in "[ab.]{0,8}",
        ) {
            let names: BTreeSet<_> = names.iter().map(String::as_str).collect();
            let all: Vec<_> = names.iter().map(|name| ("local", *name)).collect();
            let known = known(&all);
            let owned = names.iter().any(|name| port_of(&text, name).is_some());
            match end(&text, &known) {
                Ok(end) => {
                    prop_assert_eq!(end.port.to_string(), text);
                    prop_assert!(names.contains(end.port.instance.as_str()));
                    prop_assert!(!end.port.port.is_empty());
                }
                Err(error) => {
                    prop_assert!(!owned, "{}", error);
                    prop_assert_eq!(error.exit().code(), 2);
                }
            }
        }
    }

    #[test]
    fn a_connector_is_of_the_system_of_its_source() {
        let connectors: Vec<Connector> =
            typed(Kind::Connector, &samples::values(Kind::Connector)).unwrap();
        let name = "Sine0.out-Filter0.in";
        for text in [
            name,
            "hello/Sine0.out-Filter0.in",
            "conn/Sine0.out-Filter0.in",
        ] {
            assert_eq!(super::connectors(text, &connectors).len(), 1, "{text}");
        }
        assert!(super::connectors("world/Sine0.out-Filter0.in", &connectors).is_empty());

        let mut known = known(&[("arm", "Sine0"), ("local", "Sine0"), ("local", "Filter0")]);
        known[0].spec.system = "world".to_owned();
        let source = source(&connectors[0], &known).unwrap();
        assert_eq!(source.status.node, "local");
        let sends = |text| end(text, &known).unwrap().sends(&connectors[0]);
        assert!(sends("local/Sine0.out") && !sends("arm/Sine0.out"));
        assert!(end("Filter0.in", &known).unwrap().receives(&connectors[0]));
    }
}
