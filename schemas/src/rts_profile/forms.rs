//! The forms of an RTS Profile 0.2: every element and attribute of its schemas, as text.

mod connectors;
mod orders;
pub mod v01;

pub use connectors::{DataPortConnector, ServicePortConnector, TargetPort};
pub use orders::{Condition, Order, Preceding, TargetExecutionContext, WaitTime};

use crate::form::{Form, Vocabulary, profile_form};

/// Namespace of `rts:`.
pub const RTS: &str = "http://www.openrtp.org/namespaces/rts";
/// Namespace of `rtsExt:`.
pub const RTS_EXT: &str = "http://www.openrtp.org/namespaces/rts_ext";
/// Namespace of `xsi:`.
pub const XSI: &str = "http://www.w3.org/2001/XMLSchema-instance";

/// Names of RTS Profiles.
pub static WORDS: Vocabulary = Vocabulary {
    title: "RTS Profile",
    roots: &["RtsProfile", "RTSystemProfile"],
    namespace: RTS,
    key: "rtsProfile",
    prefixes: &[("rts", RTS), ("rtsExt", RTS_EXT), ("xsi", XSI)],
    others: &[
        (
            "RtcProfile",
            "this is an RTC Profile, which describes one component; a system is described by an `rts:RtsProfile`",
        ),
        (
            "rtcProfile",
            "this is an RTC Profile, which describes one component; a system is described by `rtsProfile:`",
        ),
        (
            "apiVersion",
            "this is a deployment overlay: name the profile first, then this file (`-f PROFILE -f OVERLAY`)",
        ),
        (
            "kind",
            "this is a deployment overlay: name the profile first, then this file (`-f PROFILE -f OVERLAY`)",
        ),
    ],
};

/// A profile in the shape of its version.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Shape {
    /// Version 0.2.
    V02(Box<Profile>),
    /// Version 0.1.
    V01(Box<v01::Profile>),
}

impl Shape {
    /// The form of the root.
    pub fn form(&self) -> &dyn Form {
        match self {
            Self::V02(profile) => &**profile,
            Self::V01(profile) => &**profile,
        }
    }

    /// The same, to change.
    pub fn form_mut(&mut self) -> &mut dyn Form {
        match self {
            Self::V02(profile) => &mut **profile,
            Self::V01(profile) => &mut **profile,
        }
    }
}

profile_form! {
    /// A system: its components, how their ports are connected, and in which order they change state.
    pub struct Profile {
        /// `rtsExt:rts_profile_ext`, when the root has elements or attributes of `rtsExt`.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// `RTSystem:vendor:name:version`.
        id: attribute = RTS "id" "id";
        /// Version of the schema: `0.2`.
        version: attribute = RTS "version" "version";
        /// What the system is for.
        abstract_text: attribute = RTS "abstract" "abstract";
        /// When the profile was made: `2013-08-01T15:23:27`.
        creation_date: date = RTS "creationDate" "creationDate";
        /// When the profile was changed last.
        update_date: date = RTS "updateDate" "updateDate";
        /// Free text.
        comment: attribute = RTS_EXT "comment" "rtsExt::comment";
        /// The components of the system.
        components: many<Component> = RTS "Components" "components";
        /// Groups of components, which editors show as one.
        groups: many<Group> = RTS "Groups" "groups";
        /// Connections between data ports.
        data_port_connectors: many<DataPortConnector> = RTS "DataPortConnectors" "dataPortConnectors";
        /// Connections between service ports.
        service_port_connectors: many<ServicePortConnector> = RTS "ServicePortConnectors" "servicePortConnectors";
        /// Order in which execution contexts are started.
        start_up: some<Order> = RTS "StartUp" "startUp";
        /// Order in which execution contexts are stopped.
        shut_down: some<Order> = RTS "ShutDown" "shutDown";
        /// Order in which components are activated.
        activation: some<Order> = RTS "Activation" "activation";
        /// Order in which components are deactivated.
        deactivation: some<Order> = RTS "Deactivation" "deactivation";
        /// Order in which components are reset.
        resetting: some<Order> = RTS "Resetting" "resetting";
        /// Order in which components are initialized.
        initializing: some<Order> = RTS "Initializing" "initializing";
        /// Order in which components are finalized.
        finalizing: some<Order> = RTS "Finalizing" "finalizing";
        /// What was changed, version by version.
        version_up_logs: texts = RTS_EXT "VersionUpLogs" "rtsExt::versionUpLogs|rtsExt::versionUpLog";
        /// Names and values that no element has a place for.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
        /// Profiles of systems that are parts of this one.
        systems: many<System> = RTS_EXT "Systems" "rtsExt::systems";
    }
}

profile_form! {
    /// A component of the system.
    pub struct Component {
        /// `rtsExt:component_ext`, when it has elements or attributes of `rtsExt`.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// `RTC:vendor:category:type:version`.
        id: attribute = RTS "id" "id";
        /// Its name, which is its alone in the system.
        instance_name: attribute = RTS "instanceName" "instanceName";
        /// Address of the name server, and the path of the component in it: `localhost/Motor0.rtc`.
        path_uri: attribute = RTS "pathUri" "pathUri";
        /// Name of the configuration set that is in use.
        active_configuration_set: attribute = RTS "activeConfigurationSet" "activeConfigurationSet";
        /// `None`, or how a composite component shares: `PeriodicECShared`, `PeriodicStateShared`, `Grouping`, `FsmECShared`, `FsmStateShared`.
        composite_type: attribute = RTS "compositeType" "compositeType";
        /// `false` if the system works without it.
        is_required: boolean = RTS "isRequired" "isRequired";
        /// Free text.
        comment: attribute = RTS_EXT "comment" "rtsExt::comment";
        /// `false` if editors hide it.
        visible: boolean = RTS_EXT "visible" "rtsExt::visible";
        /// Data ports.
        data_ports: many<DataPort> = RTS "DataPorts" "dataPorts";
        /// Service ports.
        service_ports: many<ServicePort> = RTS "ServicePorts" "servicePorts";
        /// Sets of configuration values; names like `__widget__` say how editors show them.
        configuration_sets: many<ConfigurationSet> = RTS "ConfigurationSets" "configurationSets";
        /// Execution contexts.
        execution_contexts: many<ExecutionContext> = RTS "ExecutionContexts" "executionContexts";
        /// Members of a composite component.
        participants: many<Participants> = RTS "Participants" "participants";
        /// Where editors draw it.
        location: one<Location> = RTS_EXT "Location" "rtsExt::location";
        /// Properties of the component.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// A data port of a component.
    pub struct DataPort {
        /// `rtsExt:dataport_ext`, when it has elements or attributes of `rtsExt`.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Its name, bare or with the instance name and a dot before it.
        name: attribute = RTS "name" "name";
        /// `DataInPort` or `DataOutPort` (version 0.1; later the property `port.port_type`).
        port_type: attribute = RTS "port_type" "portType";
        /// Free text.
        comment: attribute = RTS_EXT "comment" "rtsExt::comment";
        /// `false` if editors hide it.
        visible: boolean = RTS_EXT "visible" "rtsExt::visible";
        /// Connections that start here (version 0.1).
        connectors: many<DataPortConnector> = RTS "DataPortConnectors" "dataPortConnectors";
        /// `port.port_type`, `dataport.data_type` and others.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// A service port of a component.
    pub struct ServicePort {
        /// `rtsExt:serviceport_ext`, when it has elements or attributes of `rtsExt`.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Its name, bare or with the instance name and a dot before it.
        name: attribute = RTS "name" "name";
        /// Free text.
        comment: attribute = RTS_EXT "comment" "rtsExt::comment";
        /// `false` if editors hide it.
        visible: boolean = RTS_EXT "visible" "rtsExt::visible";
        /// Connections that start here (version 0.1).
        connectors: many<ServicePortConnector> = RTS "ServicePortConnectors" "servicePortConnectors";
        /// Properties of the port.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// A named set of configuration values.
    pub struct ConfigurationSet {
        /// Name of the set.
        id: attribute = RTS "id" "id";
        /// Its values.
        data: many<ConfigurationData> = RTS "ConfigurationData" "configurationData";
    }
}

profile_form! {
    /// One configuration value.
    pub struct ConfigurationData {
        /// Name of the parameter.
        name: attribute = RTS "name" "name";
        /// Its value.
        data: attribute = RTS "data" "data";
    }
}

profile_form! {
    /// An execution context of a component.
    pub struct ExecutionContext {
        /// `rtsExt:execution_context_ext`, when it has properties.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Id of the context; orders name it.
        id: attribute = RTS "id" "id";
        /// `PERIODIC`, `EVENT_DRIVEN` or `OTHER`.
        kind: attribute = RTS "kind" "kind";
        /// Cycles in a second.
        rate: number = RTS "rate" "rate";
        /// Components that run in it.
        participants: many<Participants> = RTS "Participants" "participants";
        /// Properties of the context.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// Members of a composite component, or of an execution context.
    pub struct Participants {
        /// `rtsExt:target_component_ext`, when it has properties.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Id of the member, in an execution context.
        component_id: attribute = RTS "componentId" "componentId";
        /// Instance name of the member, in an execution context.
        instance_name: attribute = RTS "instanceName" "instanceName";
        /// The member of a composite component.
        participant: some<TargetComponent> = RTS "Participant" "participant";
        /// Properties of the member.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// A component that something refers to.
    pub struct TargetComponent {
        /// `rtsExt:target_component_ext`, when it has properties.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Id of the component.
        component_id: attribute = RTS "componentId" "componentId";
        /// Instance name of the component.
        instance_name: attribute = RTS "instanceName" "instanceName";
        /// Properties of the reference.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// Components that editors show as one.
    pub struct Group {
        /// Name of the group.
        group_id: attribute = RTS "groupId" "groupId";
        /// Its members.
        members: many<TargetComponent> = RTS "Members" "members";
    }
}

profile_form! {
    /// Where editors draw a component.
    pub struct Location {
        /// From the left, in pixels.
        x: number = RTS_EXT "x" "x";
        /// From the top, in pixels.
        y: number = RTS_EXT "y" "y";
        /// In pixels; `-1` leaves it to the editor.
        height: number = RTS_EXT "height" "height";
        /// In pixels; `-1` leaves it to the editor.
        width: number = RTS_EXT "width" "width";
        /// `RIGHT`, `LEFT`, `UP` or `DOWN`.
        direction: attribute = RTS_EXT "direction" "direction";
    }
}

profile_form! {
    /// A name and a value.
    pub struct Property {
        /// Name.
        name: attribute = RTS_EXT "name" "name";
        /// Value.
        value: attribute = RTS_EXT "value" "value";
    }
}

profile_form! {
    /// A profile of a system that is part of this one.
    pub struct System {
        /// Where the profile lies.
        path: attribute = RTS_EXT "path" "path";
    }
}
