//! Items of the lists that say what a manager makes and connects.

use crate::span::{Span, Text};

/// Most ports of one connection.
const PORTS: usize = 100;

/// A component to make: `Type?instance_name=X&key=value`, or with its whole id before the `?`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Precreate {
    /// Where it stands.
    pub span: Span,
    /// Type of the component.
    pub type_name: String,
    /// Vendor, category and version, when the whole id is given.
    pub id: Option<[String; 3]>,
    /// Arguments, in their order.
    pub arguments: Vec<(String, String)>,
}

/// Ports to connect: `A0.out?port=B0.in&key=value`, or as before version 2: `A0.out:B0.in(key=value)`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Preconnect {
    /// Where it stands.
    pub span: Span,
    /// The first port.
    pub port: Port,
    /// The ports that it is connected with.
    pub peers: Vec<Port>,
    /// Properties of the connection.
    pub properties: Vec<(String, String)>,
}

/// A port of a component.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Port {
    /// Instance name; behind `rtcloc://` with the category and a dot before it.
    pub instance: String,
    /// Name of the port.
    pub port: String,
}

/// An item that cannot be understood: why, and how it is written.
pub(super) type Fault = (String, &'static str);

impl Precreate {
    pub(super) fn of(item: &Text) -> Result<Self, Fault> {
        const FORM: &str = "write `Type`, `Type?instance_name=NAME&key=value` or `RTC:vendor:category:Type:version`";
        let (head, query) = split_query(&item.value)
            .ok_or_else(|| (format!("`{}` has more than one `?`", item.value), FORM))?;
        let fields: Vec<&str> = head.split(':').map(str::trim).collect();
        let (type_name, id) = match fields.as_slice() {
            [name] => (*name, None),
            ["RTC", vendor, category, name] => (*name, Some([vendor, category, &""])),
            ["RTC", vendor, category, name, version]
            | ["RTC", vendor, category, name, _, version] => {
                (*name, Some([vendor, category, version]))
            }
            _ => return Err((format!("`{head}` is no id of a component"), FORM)),
        };
        if type_name.is_empty() {
            return Err((format!("`{}` names no type", item.value), FORM));
        }
        Ok(Self {
            span: item.span,
            type_name: type_name.to_owned(),
            id: id.map(|id| id.map(|field| (*field).to_owned())),
            arguments: arguments(query),
        })
    }

    /// The value of an argument.
    pub fn argument(&self, name: &str) -> Option<&str> {
        let found = self.arguments.iter().rev().find(|(key, _)| key == name);
        found.map(|(_, value)| value.as_str())
    }
}

impl Preconnect {
    pub(super) fn of(item: &Text) -> Result<Self, Fault> {
        const FORM: &str = "write `A0.out?port=B0.in&dataflow_type=push&interface_type=corba_cdr`";
        let text = item.value.as_str();
        let (ports, arguments) = match older(text) {
            Some((ports, query)) => (ports, arguments(query)),
            None => {
                let (head, query) = split_query(text)
                    .ok_or_else(|| (format!("`{text}` has more than one `?`"), FORM))?;
                let (peers, others) = arguments(query)
                    .into_iter()
                    .partition(|(key, _)| is_port(key));
                let peers: Vec<(String, String)> = peers;
                let first = head.trim().to_owned();
                let ports = std::iter::once(first).chain(peers.into_iter().map(|(_, port)| port));
                (ports.collect(), others)
            }
        };
        let mut read = Vec::with_capacity(ports.len());
        for port in &ports {
            let port = Port::of(port)
                .ok_or_else(|| (format!("`{port}` names no port of a component"), FORM))?;
            read.push(port);
        }
        if read.len() > PORTS {
            return Err((
                format!("it connects {} ports, more than {PORTS}", read.len()),
                FORM,
            ));
        }
        let peers = read.split_off(1.min(read.len()));
        let port = read
            .pop()
            .ok_or_else(|| (format!("`{text}` names no port"), FORM))?;
        Ok(Self {
            span: item.span,
            port,
            peers,
            properties: arguments,
        })
    }
}

impl Port {
    /// `Instance.port`, maybe behind the address of a name server or a manager.
    fn of(text: &str) -> Option<Self> {
        let (instance, port) = local_name(text).rsplit_once('.')?;
        let (instance, port) = (instance.trim(), port.trim());
        (!instance.is_empty() && !port.is_empty()).then(|| Self {
            instance: instance.to_owned(),
            port: port.to_owned(),
        })
    }
}

/// `rtcname://host:2809/X0` names `X0`.
pub(super) fn local_name(text: &str) -> &str {
    let text = text.trim();
    match text.split_once("://") {
        Some((_, path)) => path.rsplit('/').next().unwrap_or(path),
        None => text,
    }
}

/// `A0.out:B0.in(key=value)`, which names no address and has no `?`.
fn older(text: &str) -> Option<(Vec<String>, &str)> {
    if text.contains(['?']) || text.contains("://") {
        return None;
    }
    let (ports, query) = match text.split_once('(') {
        Some((ports, query)) => (ports, query.trim_end().strip_suffix(')')?),
        None => (text, ""),
    };
    let ports: Vec<String> = ports
        .split(':')
        .map(|port| port.trim().to_owned())
        .collect();
    (ports.len() > 1).then_some((ports, query))
}

fn split_query(text: &str) -> Option<(&str, &str)> {
    let (head, query) = text.split_once('?').unwrap_or((text, ""));
    (!query.contains('?')).then_some((head.trim(), query))
}

/// `key=value&key=value`; what has no `=` says nothing.
fn arguments(query: &str) -> Vec<(String, String)> {
    let pairs = query.split('&').filter_map(|pair| pair.split_once('='));
    pairs
        .map(|(key, value)| (key.trim().to_owned(), value.trim().to_owned()))
        .filter(|(key, _)| !key.is_empty())
        .collect()
}

/// `port`, `port0`, `port1`, …
fn is_port(key: &str) -> bool {
    key.strip_prefix("port")
        .is_some_and(|rest| rest.bytes().all(|b| b.is_ascii_digit()))
}

#[cfg(test)]
mod tests {
    use super::*;

    type Connected = (String, Vec<String>, Vec<(String, String)>);

    fn connect(text: &str) -> Result<Connected, String> {
        let read = Preconnect::of(&Text::new(text, Span::new(0, 1))).map_err(|fault| fault.0)?;
        let shown = |port: &Port| format!("{}/{}", port.instance, port.port);
        let peers = read.peers.iter().map(shown).collect();
        Ok((shown(&read.port), peers, read.properties))
    }

    #[test]
    fn connections_in_both_spellings() {
        let new = connect("A0.out?port=B0.in&dataflow_type=push&interface_type=direct");
        let old = connect("A0.out:B0.in(dataflow_type=push&&interface_type=direct)");
        assert_eq!(new, old);
        let (port, peers, properties) = new.unwrap();
        assert_eq!((port.as_str(), peers), ("A0/out", vec!["B0/in".to_owned()]));
        assert_eq!(properties.len(), 2);
        assert_eq!(connect("A0.out:B0.in").unwrap().1, ["B0/in"]);
        let many = connect("A0.out?port0=B0.in&port1=C0.in").unwrap();
        assert_eq!(many.1, ["B0/in", "C0/in"]);
        let open = connect("A0.out?interface_type=ros&ros.roscore.port=11311").unwrap();
        assert_eq!((open.1.len(), open.2.len()), (0, 2));
        let far = connect("A0.out?port=rtcname.ssliop://localhost:2809/ConsoleOut0.in").unwrap();
        assert_eq!(far.1, ["ConsoleOut0/in"]);
        let located = connect("A0.out?port=rtcloc://localhost:2810/example.B0.in").unwrap();
        assert_eq!(located.1, ["example.B0/in"]);
        for wrong in [
            "A0",
            "A0.out?port=B0",
            "a.b?c?d",
            "?port=a.b",
            ".out?port=B0.in",
        ] {
            assert!(connect(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn components_with_and_without_their_id() {
        let of = |text: &str| Precreate::of(&Text::new(text, Span::new(0, 1)));
        let made = of("Comp?&instance_name=X&conf.default.a=1").unwrap();
        assert_eq!(made.type_name, "Comp");
        assert_eq!(made.argument("instance_name"), Some("X"));
        assert_eq!(made.argument("conf.default.a"), Some("1"));
        let full = of("RTC:AIST:example:Motor:1.2").unwrap();
        assert_eq!(full.type_name, "Motor");
        assert_eq!(full.id, Some(["AIST", "example", "1.2"].map(str::to_owned)));
        let language = of("RTC:AIST:example:Motor:Python:1.2").unwrap();
        assert_eq!(language.id, full.id);
        for wrong in ["", "?a=b", "a:b", "RTX:a:b:c:d", "a?b?c"] {
            assert!(of(wrong).is_err(), "{wrong}");
        }
    }
}
