//! Element tree → mirror. Names are told by namespace, so any prefix will do.

use super::model::{
    Component, Condition, ConfigurationSet, Connector, ExecutionContext, Group, Order, OrderKind,
    Port, Preceding, Property, RtsProfile, Target,
};
use crate::diagnostic::{Finding, Report, Source};
use crate::span::Text;
use crate::suggest;
use crate::system::PortKind;
use crate::xml::Element;

pub(super) const RTS: &str = "http://www.openrtp.org/namespaces/rts";
pub(super) const RTS_EXT: &str = "http://www.openrtp.org/namespaces/rts_ext";

/// Reads the root element. `None` after an error: then this is another kind of document.
pub(super) fn profile(root: &Element, source: &Source, report: &mut Report) -> Option<RtsProfile> {
    let named = matches!(root.local.as_str(), "RtsProfile" | "RTSystemProfile");
    if !named || root.namespace != RTS {
        report.push(wrong_root(root, named, source));
        return None;
    }
    let mut profile = RtsProfile {
        span: root.span,
        id: attr(root, "id"),
        version: attr(root, "version"),
        abstract_text: attr(root, "abstract"),
        comment: attr(root, "comment"),
        creation_date: attr(root, "creationDate"),
        update_date: attr(root, "updateDate"),
        properties: properties(root),
        ..RtsProfile::default()
    };
    for child in rts_children(root) {
        match child.local.as_str() {
            // `Component` is the name in version 0.1, where connectors lie inside the source's port.
            "Components" | "Component" => {
                let component = component(child);
                nested_connectors(child, &component, &mut profile.connectors);
                profile.components.push(component);
            }
            "Groups" => profile.groups.push(group(child)),
            "DataPortConnectors" | "ServicePortConnectors" => {
                profile.connectors.extend(connectors(child, None));
            }
            name => match OrderKind::ALL
                .into_iter()
                .find(|kind| kind.element() == name)
            {
                Some(kind) => profile.orders.push(order(child, kind)),
                None => report.push(unknown_element(child, source)),
            },
        }
        unknown_inside(child, source, report);
    }
    Some(profile)
}

fn wrong_root(root: &Element, named: bool, source: &Source) -> Finding {
    let place = Some(source.place(root.span.start, root.span.end));
    let finding = if named {
        Finding::error(
            "wrong-namespace",
            format!("`{}` is in the namespace `{}`", root.qname, root.namespace),
        )
        .help(format!("declare `xmlns:rts=\"{RTS}\"` on the root element"))
    } else {
        let finding = Finding::error(
            "wrong-root",
            format!("`<{}>` is not the root of an RTS Profile", root.qname),
        );
        match root.local.as_str() {
            "RtcProfile" => finding.help(
                "this is an RTC Profile, which describes one component; a system is described by an `rts:RtsProfile`",
            ),
            _ => finding.help("the root of an RTS Profile is `<rts:RtsProfile>`"),
        }
    };
    finding.at(place)
}

/// Elements that may lie below a child of the root.
const INNER: [&str; 21] = [
    "DataPorts",
    "ServicePorts",
    "ConfigurationSets",
    "ConfigurationData",
    "ExecutionContexts",
    "Participants",
    "Participant",
    "Members",
    "DataPortConnectors",
    "ServicePortConnectors",
    "sourceDataPort",
    "targetDataPort",
    "sourceServicePort",
    "targetServicePort",
    "targets",
    "TargetComponent",
    "WaitTime",
    "Preceding",
    "PrecedingComponents",
    "Properties",
    "Location",
];

/// A misspelt element would silently lose what is in it.
fn unknown_inside(element: &Element, source: &Source, report: &mut Report) {
    for child in rts_children(element) {
        if !INNER.contains(&child.local.as_str()) {
            report.push(unknown_element(child, source));
        }
        unknown_inside(child, source, report);
    }
}

fn unknown_element(element: &Element, source: &Source) -> Finding {
    let finding = Finding::warning(
        "unknown-element",
        format!("`<{}>` is not known here and was not read", element.qname),
    );
    let orders = OrderKind::ALL.map(OrderKind::element);
    let known = INNER
        .into_iter()
        .chain(orders)
        .chain(["Components", "Groups"]);
    let finding = match suggest::nearest(&element.local, known) {
        Some(near) => finding.help(format!("did you mean `{near}`?")),
        None => finding.help("remove it if it means nothing"),
    };
    finding.at(Some(source.place(element.span.start, element.span.end)))
}

/// Attributes are in one of the two namespaces; some hand-written files leave the prefix away.
fn attr(element: &Element, local: &str) -> Option<Text> {
    element.attribute(&[RTS, RTS_EXT, ""], local)
}

fn rts_children(element: &Element) -> impl Iterator<Item = &Element> {
    element.elements().filter(|child| child.namespace == RTS)
}

fn named<'a>(element: &'a Element, local: &'a str) -> impl Iterator<Item = &'a Element> {
    rts_children(element).filter(move |child| child.local == local)
}

fn properties(element: &Element) -> Vec<Property> {
    element
        .elements()
        .filter(|child| child.local == "Properties" && child.namespace == RTS_EXT)
        .map(|child| Property {
            span: child.span,
            name: attr(child, "name"),
            value: attr(child, "value"),
        })
        .collect()
}

fn component(element: &Element) -> Component {
    Component {
        span: element.span,
        id: attr(element, "id"),
        instance_name: attr(element, "instanceName"),
        path_uri: attr(element, "pathUri"),
        composite_type: attr(element, "compositeType"),
        is_required: attr(element, "isRequired"),
        active_configuration_set: attr(element, "activeConfigurationSet"),
        data_ports: named(element, "DataPorts").map(port).collect(),
        service_ports: named(element, "ServicePorts").map(port).collect(),
        configuration_sets: named(element, "ConfigurationSets")
            .map(configuration_set)
            .collect(),
        execution_contexts: named(element, "ExecutionContexts")
            .map(execution_context)
            .collect(),
        participants: named(element, "Participants")
            .flat_map(|outer| {
                let inner: Vec<_> = named(outer, "Participant").map(target).collect();
                if inner.is_empty() {
                    vec![target(outer)]
                } else {
                    inner
                }
            })
            .collect(),
        properties: properties(element),
    }
}

fn port(element: &Element) -> Port {
    Port {
        span: element.span,
        name: attr(element, "name"),
        properties: properties(element),
    }
}

fn configuration_set(element: &Element) -> ConfigurationSet {
    ConfigurationSet {
        span: element.span,
        id: attr(element, "id"),
        data: named(element, "ConfigurationData")
            .map(|data| Property {
                span: data.span,
                name: attr(data, "name"),
                value: attr(data, "data"),
            })
            .collect(),
    }
}

fn execution_context(element: &Element) -> ExecutionContext {
    ExecutionContext {
        span: element.span,
        id: attr(element, "id"),
        kind: attr(element, "kind"),
        rate: attr(element, "rate"),
        properties: properties(element),
    }
}

fn target(element: &Element) -> Target {
    Target {
        span: element.span,
        id: attr(element, "id"),
        instance_name: attr(element, "instanceName"),
        component_id: attr(element, "componentId"),
        port_name: attr(element, "portName"),
        properties: properties(element),
    }
}

fn group(element: &Element) -> Group {
    Group {
        span: element.span,
        id: attr(element, "groupId"),
        members: named(element, "Members").map(target).collect(),
    }
}

/// One connector for each target: version 0.1 and some real files have several in one element.
fn connectors(element: &Element, implied: Option<&Target>) -> Vec<Connector> {
    let (kind, source, target_name) = if element.local == "DataPortConnectors" {
        (PortKind::Data, "sourceDataPort", "targetDataPort")
    } else {
        (PortKind::Service, "sourceServicePort", "targetServicePort")
    };
    let connector = Connector {
        span: element.span,
        kind,
        connector_id: attr(element, "connectorId"),
        name: attr(element, "name"),
        data_type: attr(element, "dataType"),
        interface_type: attr(element, "interfaceType"),
        dataflow_type: attr(element, "dataflowType"),
        subscription_type: attr(element, "subscriptionType"),
        push_interval: attr(element, "pushInterval"),
        source: named(element, source)
            .next()
            .map(target)
            .or_else(|| implied.cloned()),
        target: None,
        properties: properties(element),
    };
    let targets: Vec<Target> = named(element, target_name).map(target).collect();
    if targets.is_empty() {
        return vec![connector];
    }
    targets
        .into_iter()
        .map(|end| Connector {
            target: Some(end),
            ..connector.clone()
        })
        .collect()
}

fn nested_connectors(element: &Element, component: &Component, all: &mut Vec<Connector>) {
    for port in
        rts_children(element).filter(|e| matches!(e.local.as_str(), "DataPorts" | "ServicePorts"))
    {
        let source = Target {
            span: port.span,
            instance_name: component.instance_name.clone(),
            component_id: component.id.clone(),
            port_name: attr(port, "name"),
            ..Target::default()
        };
        for inner in rts_children(port) {
            if matches!(
                inner.local.as_str(),
                "DataPortConnectors" | "ServicePortConnectors"
            ) {
                all.extend(connectors(inner, Some(&source)));
            }
        }
    }
}

fn order(element: &Element, kind: OrderKind) -> Order {
    Order {
        span: element.span,
        kind,
        conditions: named(element, "targets").map(condition).collect(),
    }
}

/// The schema puts the choice first, the reference library's sample the target: both are read.
fn condition(element: &Element) -> Condition {
    Condition {
        span: element.span,
        sequence: attr(element, "sequence"),
        target: named(element, "TargetComponent").next().map(target),
        wait_time: named(element, "WaitTime")
            .next()
            .and_then(|wait| attr(wait, "waitTime")),
        preceding: named(element, "Preceding")
            .next()
            .map(|preceding| Preceding {
                span: preceding.span,
                sending_timing: attr(preceding, "sendingTiming"),
                timeout: attr(preceding, "timeout"),
                components: named(preceding, "PrecedingComponents")
                    .map(target)
                    .collect(),
            }),
    }
}
