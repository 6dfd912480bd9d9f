//! The parts of a profile, each from its mapping.

use super::{Reader, text};
use crate::rts_profile::model::{
    Component, Condition, ConfigurationSet, Connector, ExecutionContext, Group, Port, Preceding,
    Property, Target,
};
use crate::system::PortKind;
use crate::yaml::Node;

impl Reader<'_> {
    pub(super) fn properties(&mut self, node: &Node) -> Vec<Property> {
        self.list(node, "properties")
            .iter()
            .map(|item| property(item, "value"))
            .collect()
    }

    pub(super) fn component(&mut self, node: &Node) -> Component {
        Component {
            span: node.span,
            id: text(node, "id"),
            instance_name: text(node, "instanceName"),
            path_uri: text(node, "pathUri"),
            composite_type: text(node, "compositeType"),
            is_required: text(node, "isRequired"),
            active_configuration_set: text(node, "activeConfigurationSet"),
            data_ports: self.all(node, "dataPorts", Self::port),
            service_ports: self.all(node, "servicePorts", Self::port),
            configuration_sets: self.all(node, "configurationSets", Self::configuration_set),
            execution_contexts: self.all(node, "executionContexts", Self::execution_context),
            participants: self
                .list(node, "participants")
                .iter()
                .map(|item| self.target(item.get("participant").unwrap_or(item)))
                .collect(),
            properties: self.properties(node),
        }
    }

    pub(super) fn port(&mut self, node: &Node) -> Port {
        Port {
            span: node.span,
            name: text(node, "name"),
            properties: self.properties(node),
        }
    }

    pub(super) fn configuration_set(&mut self, node: &Node) -> ConfigurationSet {
        ConfigurationSet {
            span: node.span,
            id: text(node, "id"),
            data: self
                .list(node, "configurationData")
                .iter()
                .map(|item| property(item, "data"))
                .collect(),
        }
    }

    pub(super) fn execution_context(&mut self, node: &Node) -> ExecutionContext {
        ExecutionContext {
            span: node.span,
            id: text(node, "id"),
            kind: text(node, "kind"),
            rate: text(node, "rate"),
            properties: self.properties(node),
        }
    }

    pub(super) fn target(&mut self, node: &Node) -> Target {
        Target {
            span: node.span,
            id: text(node, "id"),
            instance_name: text(node, "instanceName"),
            component_id: text(node, "componentId"),
            port_name: text(node, "portName"),
            properties: self.properties(node),
        }
    }

    pub(super) fn group(&mut self, node: &Node) -> Group {
        Group {
            span: node.span,
            id: text(node, "groupId"),
            members: self.all(node, "members", Self::target),
        }
    }

    pub(super) fn connector(&mut self, node: &Node, kind: PortKind) -> Connector {
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
            source: node.get(source).map(|item| self.target(item)),
            target: node.get(target_key).map(|item| self.target(item)),
            properties: self.properties(node),
        }
    }

    pub(super) fn condition(&mut self, node: &Node) -> Condition {
        let choice = node.get("condition").unwrap_or(node);
        Condition {
            span: node.span,
            sequence: text(node, "sequence"),
            target: node.get("targetComponent").map(|item| self.target(item)),
            wait_time: choice
                .get("waitTime")
                .and_then(|wait| wait.text().or_else(|| text(wait, "waitTime"))),
            preceding: choice.get("preceding").map(|preceding| Preceding {
                span: preceding.span,
                sending_timing: text(preceding, "sendingTiming"),
                timeout: text(preceding, "timeout"),
                components: self.all(preceding, "precedingComponents", Self::target),
            }),
        }
    }
}

fn property(node: &Node, value: &str) -> Property {
    Property {
        span: node.span,
        name: text(node, "name"),
        value: text(node, value),
    }
}
