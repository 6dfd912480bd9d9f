//! The mirror of an RTS Profile: what the file says, item by item, with places and without judgement.
//!
//! Every attribute is optional here; the checks say what is missing. Version 0.1 is read into the shape of 0.2.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::span::{Span, Text};
use crate::system::PortKind;

/// `rts:RtsProfile`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RtsProfile {
    /// The root element or key.
    pub span: Span,
    /// `RTSystem:vendor:name:version`, or an older form.
    pub id: Option<Text>,
    /// Version of the schema: `0.2` or `0.1`.
    pub version: Option<Text>,
    /// What the system is for.
    pub abstract_text: Option<Text>,
    /// `rtsExt:comment`.
    pub comment: Option<Text>,
    /// As written.
    pub creation_date: Option<Text>,
    /// As written.
    pub update_date: Option<Text>,
    /// Components in the order of the file.
    pub components: Vec<Component>,
    /// Groups of components, which only editors use.
    pub groups: Vec<Group>,
    /// Data and service connectors in the order of the file.
    pub connectors: Vec<Connector>,
    /// The orders that the file has.
    pub orders: Vec<Order>,
    /// `rtsExt:Properties` of the whole system.
    pub properties: Vec<Property>,
}

/// `rts:Components`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Component {
    /// The element.
    pub span: Span,
    /// `RTC:vendor:category:type:version`.
    pub id: Option<Text>,
    /// Instance name.
    pub instance_name: Option<Text>,
    /// Name server address and naming context path.
    pub path_uri: Option<Text>,
    /// `None`, `PeriodicECShared`, …
    pub composite_type: Option<Text>,
    /// `true` or `false`.
    pub is_required: Option<Text>,
    /// Name of a configuration set.
    pub active_configuration_set: Option<Text>,
    /// Data ports.
    pub data_ports: Vec<Port>,
    /// Service ports.
    pub service_ports: Vec<Port>,
    /// Configuration sets, pseudo sets included.
    pub configuration_sets: Vec<ConfigurationSet>,
    /// Execution contexts.
    pub execution_contexts: Vec<ExecutionContext>,
    /// Members of a composite component.
    pub participants: Vec<Target>,
    /// `rtsExt:Properties`.
    pub properties: Vec<Property>,
}

/// `rts:DataPorts` or `rts:ServicePorts`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Port {
    /// The element.
    pub span: Span,
    /// Bare or with the instance name before it.
    pub name: Option<Text>,
    /// `rtsExt:Properties`.
    pub properties: Vec<Property>,
}

/// `rts:ConfigurationSets`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ConfigurationSet {
    /// The element.
    pub span: Span,
    /// Name of the set.
    pub id: Option<Text>,
    /// `rts:ConfigurationData`: name and value.
    pub data: Vec<Property>,
}

/// `rts:ExecutionContexts`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ExecutionContext {
    /// The element.
    pub span: Span,
    /// Id of the context.
    pub id: Option<Text>,
    /// `PERIODIC`, `PeriodicExecutionContext`, …
    pub kind: Option<Text>,
    /// Hz.
    pub rate: Option<Text>,
    /// `rtsExt:Properties`.
    pub properties: Vec<Property>,
}

/// A name and a value.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Property {
    /// The element.
    pub span: Span,
    /// Name.
    pub name: Option<Text>,
    /// Value; real files leave it away.
    pub value: Option<Text>,
}

/// `rts:DataPortConnectors` or `rts:ServicePortConnectors`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Connector {
    /// The element.
    pub span: Span,
    /// Data or service.
    pub kind: PortKind,
    /// Free text; repeated in real files, so never a key.
    pub connector_id: Option<Text>,
    /// Free text.
    pub name: Option<Text>,
    /// Data type, in any spelling.
    pub data_type: Option<Text>,
    /// `corba_cdr`, …
    pub interface_type: Option<Text>,
    /// `push`, `pull`.
    pub dataflow_type: Option<Text>,
    /// `flush`, `new`, `periodic`, `block`.
    pub subscription_type: Option<Text>,
    /// Seconds.
    pub push_interval: Option<Text>,
    /// The end that the file calls source.
    pub source: Option<Target>,
    /// The end that the file calls target.
    pub target: Option<Target>,
    /// `rtsExt:Properties`.
    pub properties: Vec<Property>,
}

/// A component, or one of its ports, that something refers to.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Target {
    /// The element.
    pub span: Span,
    /// Id of an execution context (orders only).
    pub id: Option<Text>,
    /// Instance name.
    pub instance_name: Option<Text>,
    /// Component id.
    pub component_id: Option<Text>,
    /// Port name (connectors only).
    pub port_name: Option<Text>,
    /// `rtsExt:Properties`.
    pub properties: Vec<Property>,
}

/// `rts:Groups`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Group {
    /// The element.
    pub span: Span,
    /// Name of the group.
    pub id: Option<Text>,
    /// Members.
    pub members: Vec<Target>,
}

/// One of the seven orders.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Order {
    /// The element.
    pub span: Span,
    /// Which one.
    pub kind: OrderKind,
    /// Its conditions.
    pub conditions: Vec<Condition>,
}

/// The transition that an order is about.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema,
)]
pub enum OrderKind {
    /// `rts:StartUp`.
    StartUp,
    /// `rts:ShutDown`.
    ShutDown,
    /// `rts:Activation`.
    Activation,
    /// `rts:Deactivation`.
    Deactivation,
    /// `rts:Resetting`.
    Resetting,
    /// `rts:Initializing`.
    Initializing,
    /// `rts:Finalizing`.
    Finalizing,
}

impl OrderKind {
    /// All seven, in the order of the schema.
    pub const ALL: [Self; 7] = [
        Self::StartUp,
        Self::ShutDown,
        Self::Activation,
        Self::Deactivation,
        Self::Resetting,
        Self::Initializing,
        Self::Finalizing,
    ];

    /// Name of the XML element (`StartUp`); in YAML the first letter is small.
    pub fn element(self) -> &'static str {
        match self {
            Self::StartUp => "StartUp",
            Self::ShutDown => "ShutDown",
            Self::Activation => "Activation",
            Self::Deactivation => "Deactivation",
            Self::Resetting => "Resetting",
            Self::Initializing => "Initializing",
            Self::Finalizing => "Finalizing",
        }
    }
}

/// `rts:targets`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Condition {
    /// The element.
    pub span: Span,
    /// A whole number; gaps are allowed.
    pub sequence: Option<Text>,
    /// The component that waits.
    pub target: Option<Target>,
    /// `rts:WaitTime`: milliseconds.
    pub wait_time: Option<Text>,
    /// `rts:Preceding`.
    pub preceding: Option<Preceding>,
}

/// `rts:Preceding`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Preceding {
    /// The element.
    pub span: Span,
    /// `SYNC`, `ASYNC` or `NO_SYNC`.
    pub sending_timing: Option<Text>,
    /// Milliseconds.
    pub timeout: Option<Text>,
    /// The components that go before.
    pub components: Vec<Target>,
}

/// The property with this name; of several the last, as in OpenRTM.
pub fn property<'a>(properties: &'a [Property], name: &str) -> Option<&'a Property> {
    properties
        .iter()
        .rev()
        .find(|p| p.name.as_ref().is_some_and(|n| n.trimmed() == name))
}

/// The value of the property with this name, trimmed, if it is not empty.
pub fn property_value<'a>(properties: &'a [Property], name: &str) -> Option<&'a Text> {
    property(properties, name)?
        .value
        .as_ref()
        .filter(|value| !value.trimmed().is_empty())
}

impl Component {
    /// The port name without this component's own instance name before it.
    pub fn bare_port<'a>(&self, port: &'a str) -> &'a str {
        let port = port.trim();
        self.instance_name
            .as_ref()
            .and_then(|instance| port.strip_prefix(instance.trimmed())?.strip_prefix('.'))
            .filter(|bare| !bare.is_empty())
            .unwrap_or(port)
    }

    /// The declared port with this name, and its kind.
    pub fn port(&self, name: &str) -> Option<(PortKind, &Port)> {
        let bare = self.bare_port(name);
        self.ports().find(|(_, port)| {
            port.name
                .as_ref()
                .is_some_and(|n| self.bare_port(&n.value) == bare)
        })
    }

    /// The port with this number among all, when it has a name, and that name.
    pub(super) fn port_name(&self, at: usize) -> Option<((PortKind, &Port), &str)> {
        let port = match at.checked_sub(self.data_ports.len()) {
            None => (PortKind::Data, self.data_ports.get(at)?),
            Some(at) => (PortKind::Service, self.service_ports.get(at)?),
        };
        let name = port.1.name.as_ref()?;
        Some((port, self.bare_port(&name.value)))
    }

    /// All declared ports with their kinds.
    pub fn ports(&self) -> impl Iterator<Item = (PortKind, &Port)> {
        let data = self.data_ports.iter().map(|port| (PortKind::Data, port));
        let service = self.service_ports.iter();
        data.chain(service.map(|port| (PortKind::Service, port)))
    }
}
