//! YAML tree → mirror, by the keys that the reference library `rtsprofile` writes.

use super::model::{
    Component, Condition, ConfigurationSet, Connector, ExecutionContext, Group, Order, OrderKind,
    Port, Preceding, Property, RtsProfile, Target,
};
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
        components: reader
            .list(body, "components")
            .iter()
            .map(component)
            .collect(),
        groups: reader.list(body, "groups").iter().map(group).collect(),
        ..RtsProfile::default()
    };
    for node in reader.list(body, "dataPortConnectors") {
        profile.connectors.push(connector(node, PortKind::Data));
    }
    for node in reader.list(body, "servicePortConnectors") {
        profile.connectors.push(connector(node, PortKind::Service));
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
                "this is a deployment overlay: give it with `--overlay`, beside a profile"
            }
            _ => "the root of an RTS Profile in YAML is `rtsProfile:`",
        };
        self.report.push(finding.help(help));
    }

    /// The items under a key; something else than a list there is an error.
    fn list<'n>(&mut self, node: &'n Node, key: &str) -> &'n [Node] {
        match node.get(key) {
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

    fn order(&mut self, node: &Node, kind: OrderKind) -> Order {
        Order {
            span: node.span,
            kind,
            conditions: self.list(node, "targets").iter().map(condition).collect(),
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

fn items<'n>(node: &'n Node, key: &str) -> &'n [Node] {
    node.get(key)
        .or_else(|| node.get(&format!("rtsExt::{key}")))
        .map_or(&[], Node::items)
}

fn property(node: &Node, value: &str) -> Property {
    Property {
        span: node.span,
        name: text(node, "name"),
        value: text(node, value),
    }
}

fn properties(node: &Node) -> Vec<Property> {
    items(node, "properties")
        .iter()
        .map(|item| property(item, "value"))
        .collect()
}

fn component(node: &Node) -> Component {
    Component {
        span: node.span,
        id: text(node, "id"),
        instance_name: text(node, "instanceName"),
        path_uri: text(node, "pathUri"),
        composite_type: text(node, "compositeType"),
        is_required: text(node, "isRequired"),
        active_configuration_set: text(node, "activeConfigurationSet"),
        data_ports: items(node, "dataPorts").iter().map(port).collect(),
        service_ports: items(node, "servicePorts").iter().map(port).collect(),
        configuration_sets: items(node, "configurationSets")
            .iter()
            .map(configuration_set)
            .collect(),
        execution_contexts: items(node, "executionContexts")
            .iter()
            .map(execution_context)
            .collect(),
        participants: items(node, "participants")
            .iter()
            .map(|item| target(item.get("participant").unwrap_or(item)))
            .collect(),
        properties: properties(node),
    }
}

fn port(node: &Node) -> Port {
    Port {
        span: node.span,
        name: text(node, "name"),
        properties: properties(node),
    }
}

fn configuration_set(node: &Node) -> ConfigurationSet {
    ConfigurationSet {
        span: node.span,
        id: text(node, "id"),
        data: items(node, "configurationData")
            .iter()
            .map(|item| property(item, "data"))
            .collect(),
    }
}

fn execution_context(node: &Node) -> ExecutionContext {
    ExecutionContext {
        span: node.span,
        id: text(node, "id"),
        kind: text(node, "kind"),
        rate: text(node, "rate"),
        properties: properties(node),
    }
}

fn target(node: &Node) -> Target {
    Target {
        span: node.span,
        id: text(node, "id"),
        instance_name: text(node, "instanceName"),
        component_id: text(node, "componentId"),
        port_name: text(node, "portName"),
        properties: properties(node),
    }
}

fn group(node: &Node) -> Group {
    Group {
        span: node.span,
        id: text(node, "groupId"),
        members: items(node, "members").iter().map(target).collect(),
    }
}

fn connector(node: &Node, kind: PortKind) -> Connector {
    let (source, target_key) = match kind {
        PortKind::Data => ("sourceDataPort", "targetDataPort"),
        PortKind::Service => ("sourceServicePort", "targetServicePort"),
    };
    Connector {
        span: node.span,
        kind,
        connector_id: text(node, "connectorId"),
        name: text(node, "name"),
        data_type: text(node, "dataType"),
        interface_type: text(node, "interfaceType"),
        dataflow_type: text(node, "dataflowType"),
        subscription_type: text(node, "subscriptionType"),
        push_interval: text(node, "pushInterval"),
        source: node.get(source).map(target),
        target: node.get(target_key).map(target),
        properties: properties(node),
    }
}

fn condition(node: &Node) -> Condition {
    let choice = node.get("condition").unwrap_or(node);
    Condition {
        span: node.span,
        sequence: text(node, "sequence"),
        target: node.get("targetComponent").map(target),
        wait_time: choice
            .get("waitTime")
            .and_then(|wait| wait.text().or_else(|| text(wait, "waitTime"))),
        preceding: choice.get("preceding").map(|preceding| Preceding {
            span: preceding.span,
            sending_timing: text(preceding, "sendingTiming"),
            timeout: text(preceding, "timeout"),
            components: items(preceding, "precedingComponents")
                .iter()
                .map(target)
                .collect(),
        }),
    }
}
