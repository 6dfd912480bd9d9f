//! YAML tree → mirror, by the keys that the reference library `rtsprofile` writes.

mod items;

use super::model::{Order, OrderKind, RtsProfile};
use crate::diagnostic::{Finding, Report, Source};
use crate::span::{Span, Text};
use crate::suggest;
use crate::system::PortKind;
use crate::yaml::{Node, Value};

/// Reads the root mapping. `None` after an error: then this is another kind of document.
pub(super) fn profile(root: &Node, source: &Source, report: &mut Report) -> Option<RtsProfile> {
    let mut reader = Reader { source, report };
    let Some((key, body)) = root
        .entries()
        .iter()
        .find(|(key, _)| key.value == "rtsProfile")
    else {
        reader.wrong_root(root);
        return None;
    };
    let mut profile = RtsProfile {
        span: key.span,
        id: text(body, "id"),
        version: text(body, "version"),
        abstract_text: text(body, "abstract"),
        comment: text(body, "comment"),
        creation_date: date(body, "creationDate"),
        update_date: date(body, "updateDate"),
        components: reader.all(body, "components", Reader::component),
        groups: reader.all(body, "groups", Reader::group),
        properties: reader.properties(body),
        ..RtsProfile::default()
    };
    for node in reader.list(body, "dataPortConnectors") {
        profile
            .connectors
            .push(reader.connector(node, PortKind::Data));
    }
    for node in reader.list(body, "servicePortConnectors") {
        profile
            .connectors
            .push(reader.connector(node, PortKind::Service));
    }
    for kind in OrderKind::ALL {
        if let Some(node) = body.get(&key_of(kind)) {
            profile.orders.push(reader.order(node, kind));
        }
    }
    reader.unknown_keys(body);
    Some(profile)
}

struct Reader<'a> {
    source: &'a Source,
    report: &'a mut Report,
}

impl Reader<'_> {
    fn place(&self, span: Span) -> Option<crate::diagnostic::Place> {
        (!span.is_unknown()).then(|| self.source.place(span.start, span.end))
    }

    fn wrong_root(&mut self, root: &Node) {
        let key = root.entries().first().map(|(key, _)| key);
        let finding = match key {
            Some(key) => Finding::error(
                "wrong-root",
                format!("`{}:` is not the root of an RTS Profile", key.value),
            )
            .at(self.place(key.span)),
            None => Finding::error(
                "wrong-root",
                format!("an RTS Profile is a mapping, this is {}", root.kind()),
            )
            .at(self.place(root.span)),
        };
        let help = match key.map(|key| key.value.as_str()) {
            Some("rtcProfile") => {
                "this is an RTC Profile, which describes one component; a system is described by `rtsProfile:`"
            }
            Some("apiVersion" | "kind") => {
                "this is a deployment overlay: name the profile first, then this file (`-f PROFILE -f OVERLAY`)"
            }
            _ => "the root of an RTS Profile in YAML is `rtsProfile:`",
        };
        self.report.push(finding.help(help));
    }

    /// The items under a key; something else than a list there is an error.
    fn list<'n>(&mut self, node: &'n Node, key: &str) -> &'n [Node] {
        match node
            .get(key)
            .or_else(|| node.get(&format!("rtsExt::{key}")))
        {
            Some(Node {
                value: Value::Sequence(items),
                ..
            }) => items,
            None
            | Some(Node {
                value: Value::Null, ..
            }) => &[],
            Some(other) => {
                let message = format!("`{key}` must be a list, this is {}", other.kind());
                let place = self.place(other.span);
                self.report.push(
                    Finding::error("wrong-shape", message)
                        .at(place)
                        .help("write each item on a line that starts with `- `"),
                );
                &[]
            }
        }
    }

    /// The items under a key, each read by `item`.
    fn all<T>(&mut self, node: &Node, key: &str, item: impl Fn(&mut Self, &Node) -> T) -> Vec<T> {
        let nodes = self.list(node, key);
        nodes.iter().map(|node| item(self, node)).collect()
    }

    fn order(&mut self, node: &Node, kind: OrderKind) -> Order {
        Order {
            span: node.span,
            kind,
            conditions: self.all(node, "targets", Reader::condition),
        }
    }

    fn unknown_keys(&mut self, body: &Node) {
        const KNOWN: [&str; 18] = [
            "id",
            "version",
            "abstract",
            "comment",
            "creationDate",
            "updateDate",
            "components",
            "groups",
            "dataPortConnectors",
            "servicePortConnectors",
            "startUp",
            "shutDown",
            "activation",
            "deactivation",
            "resetting",
            "initializing",
            "finalizing",
            "versionUpLogs",
        ];
        for (key, _) in body.entries() {
            let name = key.value.trim_start_matches("rtsExt::");
            if KNOWN.contains(&name)
                || name == "properties"
                || name.starts_with("x-")
                || name == "versionUpLog"
            {
                continue;
            }
            let place = self.place(key.span);
            self.report.push(
                Finding::warning(
                    "unknown-element",
                    format!("`{}` is not known here and was not read", key.value),
                )
                .at(place)
                .help(suggest::advice(name, "keys", &KNOWN)),
            );
        }
    }
}

fn key_of(kind: OrderKind) -> String {
    let name = kind.element();
    name[..1].to_lowercase() + &name[1..]
}

/// The scalar under `key`, or under its extension form `rtsExt::key`.
fn text(node: &Node, key: &str) -> Option<Text> {
    node.get(key)
        .or_else(|| node.get(&format!("rtsExt::{key}")))
        .and_then(Node::text)
}

/// A date is a text or a mapping of its fields; it is only shown, so it need not be valid.
fn date(node: &Node, key: &str) -> Option<Text> {
    let date = node.get(key)?;
    if let Some(text) = date.text() {
        return Some(text);
    }
    let field = |name: &str| text(date, name).map_or_else(|| "0".to_owned(), |t| t.value);
    Some(Text::new(
        format!(
            "{}-{:0>2}-{:0>2}T{:0>2}:{:0>2}:{:0>2}",
            field("year"),
            field("month"),
            field("day"),
            field("hour"),
            field("minute"),
            field("second")
        ),
        date.span,
    ))
}
