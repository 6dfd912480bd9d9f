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
        /// Type of the element in the schema: `rtsExt:rts_profile_ext`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Identity of the system: `RTSystem:vendor:name:version`. The third field names the system in `rtsctl`, unless
        /// `--name` is given; a system of another vendor or name does not replace this one.
        ///
        /// - Required: by the schema
        id: attribute = RTS "id" "id";
        /// Version of the schema. Files of version 0.1 are told by their elements, since many say a wrong one.
        ///
        /// - Values: `0.2`
        /// - Required: by the schema
        version: attribute = RTS "version" "version";
        /// What the system is for, in a few words. Editors show it; it has no effect.
        abstract_text: attribute = RTS "abstract" "abstract";
        /// When the profile was made: `2013-08-01T15:23:27`, with a time zone or without. Choreonoid leaves it away. In
        /// YAML it is a mapping of `year`, `month`, `day`, `hour`, `minute` and `second`.
        ///
        /// - Required: by the schema
        creation_date: date = RTS "creationDate" "creationDate";
        /// When the profile was changed last, written as `creationDate`. It has no effect.
        ///
        /// - Required: by the schema
        update_date: date = RTS "updateDate" "updateDate";
        /// Free text for people. It is kept and shown, and has no effect.
        comment: attribute = RTS_EXT "comment" "rtsExt::comment";
        /// The components of the system, each an instance of some type. `rtsctl apply` creates those that are missing.
        components: many<Component> = RTS "Components" "components";
        /// Groups of components, which editors show as one. They do not change how the components run.
        ///
        /// - Versions: since 0.2
        groups: many<Group> = RTS "Groups" "groups";
        /// Connections between data ports: one for each pair of an out-port and an in-port.
        data_port_connectors: many<DataPortConnector> = RTS "DataPortConnectors" "dataPortConnectors";
        /// Connections between service ports: one for each pair of a required and a provided interface.
        service_port_connectors: many<ServicePortConnector> = RTS "ServicePortConnectors" "servicePortConnectors";
        /// In which order execution contexts are started. What has no place in the order starts at once.
        ///
        /// - Versions: since 0.2; before, in each component
        start_up: some<Order> = RTS "StartUp" "startUp";
        /// In which order execution contexts are stopped when the system is taken down.
        ///
        /// - Versions: since 0.2
        shut_down: some<Order> = RTS "ShutDown" "shutDown";
        /// In which order components are activated: from Inactive to Active. `rtsctl plan` shows the order that
        /// results.
        ///
        /// - Versions: since 0.2
        activation: some<Order> = RTS "Activation" "activation";
        /// In which order components are deactivated: from Active to Inactive, before the system is taken down.
        ///
        /// - Versions: since 0.2
        deactivation: some<Order> = RTS "Deactivation" "deactivation";
        /// In which order components leave the state Error when they are reset.
        ///
        /// - Versions: since 0.2
        resetting: some<Order> = RTS "Resetting" "resetting";
        /// In which order components are initialized after they were created.
        ///
        /// - Versions: since 0.2
        initializing: some<Order> = RTS "Initializing" "initializing";
        /// In which order components are finalized before they are removed.
        ///
        /// - Versions: since 0.2
        finalizing: some<Order> = RTS "Finalizing" "finalizing";
        /// What was changed, version by version: one text for each. Editors add to it.
        version_up_logs: texts = RTS_EXT "VersionUpLogs" "rtsExt::versionUpLogs|rtsExt::versionUpLog";
        /// Names and values that no element has a place for. `rtsctl.name` is the name of the system.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
        /// Profiles of systems that are parts of this one. They are kept, and not read.
        ///
        /// - Versions: since 0.2
        systems: many<System> = RTS_EXT "Systems" "rtsExt::systems";
    }
}

profile_form! {
    /// A component of the system.
    pub struct Component {
        /// Type of the element in the schema: `rtsExt:component_ext`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// What the component is: `RTC:vendor:category:type:version`. The fourth field is the type, by which its module
        /// is found.
        ///
        /// - Required: by the schema
        id: attribute = RTS "id" "id";
        /// Name of the instance, without a `/`. No other component of the system has it. Connectors
        /// and orders refer to it.
        ///
        /// - Required: by the schema
        instance_name: attribute = RTS "instanceName" "instanceName";
        /// Address of the name server, and the path of the component in it: `localhost:2809/Motor0.rtc`. Unless it is
        /// this machine, the host is also a hint for the node.
        ///
        /// - Required: by the schema
        path_uri: attribute = RTS "pathUri" "pathUri";
        /// Name of the configuration set that is in use. It is one of `configurationSets`.
        active_configuration_set: attribute = RTS "activeConfigurationSet" "activeConfigurationSet";
        /// How a composite component treats its members: whether they share its execution context, its state, or
        /// nothing.
        ///
        /// - Values: `None`, `PeriodicECShared`, `PeriodicStateShared`, `Grouping`, `FsmECShared`, `FsmStateShared`
        /// - Default: `None`
        composite_type: attribute = RTS "compositeType" "compositeType";
        /// Whether the system is of no use without it: a required component that is missing makes `apply` fail, another
        /// one is skipped.
        ///
        /// - Values: `true`, `false`
        /// - Required: by the schema
        is_required: boolean = RTS "isRequired" "isRequired";
        /// Free text for people. It is kept and shown, and has no effect.
        comment: attribute = RTS_EXT "comment" "rtsExt::comment";
        /// Whether editors show it. It has no effect on the system.
        ///
        /// - Values: `true`, `false`
        /// - Default: `true`
        visible: boolean = RTS_EXT "visible" "rtsExt::visible";
        /// Its data ports. Only ports that are declared can be checked; a module may have more.
        data_ports: many<DataPort> = RTS "DataPorts" "dataPorts";
        /// Its service ports, each with interfaces that it provides or requires.
        service_ports: many<ServicePort> = RTS "ServicePorts" "servicePorts";
        /// Sets of configuration values. Sets with names as `__widget__` and `__constraints__` hold no values: they say
        /// how editors show the others.
        configuration_sets: many<ConfigurationSet> = RTS "ConfigurationSets" "configurationSets";
        /// Execution contexts that run the component; the first one is its own.
        execution_contexts: many<ExecutionContext> = RTS "ExecutionContexts" "executionContexts";
        /// Members of a composite component, by reference. The members are components of the system too.
        participants: many<Participants> = RTS "Participants" "participants";
        /// Where editors draw it in their diagram. It has no effect on the system.
        location: one<Location> = RTS_EXT "Location" "rtsExt::location";
        /// Names and values besides: `rtsctl.node`, `rtsctl.manager` and `rtsctl.isolated` place the component; `IOR`
        /// is a hint for its host; `conf.*` and others are kept.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// A data port of a component.
    pub struct DataPort {
        /// Type of the element in the schema: `rtsExt:dataport_ext`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Name of the port, alone (`out`) or after the instance name and a dot (`Motor0.out`): both mean the same.
        ///
        /// - Required: by the schema
        name: attribute = RTS "name" "name";
        /// Direction of the port. Since version 0.2 it is said by the property `port.port_type`.
        ///
        /// - Values: `DataInPort`, `DataOutPort`
        /// - Versions: only 0.1
        port_type: attribute = RTS "port_type" "portType";
        /// Free text for people. It is kept and shown, and has no effect.
        comment: attribute = RTS_EXT "comment" "rtsExt::comment";
        /// Whether editors show it. It has no effect on the system.
        ///
        /// - Values: `true`, `false`
        /// - Default: `true`
        visible: boolean = RTS_EXT "visible" "rtsExt::visible";
        /// Connections that start at this port. Since version 0.2 they stand at the top of the profile.
        ///
        /// - Versions: only 0.1
        connectors: many<DataPortConnector> = RTS "DataPortConnectors" "dataPortConnectors";
        /// What the port says of itself: `port.port_type` (`DataInPort`, `DataOutPort`), `dataport.data_type`
        /// (`IDL:RTC/TimedLong:1.0`), and which interface, data flow and subscription types it offers.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// A service port of a component.
    pub struct ServicePort {
        /// Type of the element in the schema: `rtsExt:serviceport_ext`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Name of the port, alone or after the instance name and a dot: both mean the same.
        ///
        /// - Required: by the schema
        name: attribute = RTS "name" "name";
        /// Free text for people. It is kept and shown, and has no effect.
        comment: attribute = RTS_EXT "comment" "rtsExt::comment";
        /// Whether editors show it. It has no effect on the system.
        ///
        /// - Values: `true`, `false`
        /// - Default: `true`
        visible: boolean = RTS_EXT "visible" "rtsExt::visible";
        /// Connections that start at this port. Since version 0.2 they stand at the top of the profile.
        ///
        /// - Versions: only 0.1
        connectors: many<ServicePortConnector> = RTS "ServicePortConnectors" "servicePortConnectors";
        /// Properties of the port as its component told them to the editor. They are kept.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// A named set of configuration values.
    pub struct ConfigurationSet {
        /// Name of the set: usually `default`. Names between `__` hold no values, but say how editors show those of
        /// other sets.
        ///
        /// - Required: by the schema
        id: attribute = RTS "id" "id";
        /// The values of the set. A parameter that is missing keeps the default of the component.
        data: many<ConfigurationData> = RTS "ConfigurationData" "configurationData";
    }
}

profile_form! {
    /// One configuration value.
    pub struct ConfigurationData {
        /// Name of the parameter, as the component declares it.
        ///
        /// - Required: by the schema
        name: attribute = RTS "name" "name";
        /// Its value as text: `1.0`, `true`, or `1,2,3` for a list. `rtsctl conf` changes it while the component runs.
        data: attribute = RTS "data" "data";
    }
}

profile_form! {
    /// An execution context of a component.
    pub struct ExecutionContext {
        /// Type of the element in the schema: `rtsExt:execution_context_ext`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Id of the context within its component: usually `0`. Orders name it.
        ///
        /// - Required: by the schema
        id: attribute = RTS "id" "id";
        /// What drives the context: time, events, or something else. Many files write `PeriodicExecutionContext`, which
        /// is understood.
        ///
        /// - Values: `PERIODIC`, `EVENT_DRIVEN`, `OTHER`
        /// - Required: by the schema
        kind: attribute = RTS "kind" "kind";
        /// How often a periodic context runs its components. `1000` and `1000.0` are the same.
        ///
        /// - Unit: cycles in a second (Hz)
        rate: number = RTS "rate" "rate";
        /// Other components that run in this context, besides the one that owns it.
        participants: many<Participants> = RTS "Participants" "participants";
        /// Properties of the context, as `sync_transition` and `transition_timeout`. They are kept.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// Members of a composite component, or of an execution context.
    pub struct Participants {
        /// Type of the element in the schema: `rtsExt:target_component_ext`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Id of the member: `RTC:vendor:category:type:version`. Only in an execution context.
        component_id: attribute = RTS "componentId" "componentId";
        /// Instance name of the member. Only in an execution context.
        instance_name: attribute = RTS "instanceName" "instanceName";
        /// The member of a composite component. Only in a component.
        participant: some<TargetComponent> = RTS "Participant" "participant";
        /// Properties of the member. They are kept, and have no effect.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// A component that something refers to.
    pub struct TargetComponent {
        /// Type of the element in the schema: `rtsExt:target_component_ext`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Id of the component that is meant: `RTC:vendor:category:type:version`.
        ///
        /// - Required: by the schema
        component_id: attribute = RTS "componentId" "componentId";
        /// Instance name of the component that is meant.
        ///
        /// - Required: by the schema
        instance_name: attribute = RTS "instanceName" "instanceName";
        /// Properties of the reference, as `COMPONENT_PATH_ID`. They are kept.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// Components that editors show as one.
    pub struct Group {
        /// Name of the group, which editors show.
        ///
        /// - Required: by the schema
        group_id: attribute = RTS "groupId" "groupId";
        /// The components that belong to the group, by reference.
        ///
        /// - Required: by the schema
        members: many<TargetComponent> = RTS "Members" "members";
    }
}

profile_form! {
    /// Where editors draw a component.
    pub struct Location {
        /// How far from the left edge of the diagram.
        ///
        /// - Unit: pixels
        /// - Required: by the schema
        x: number = RTS_EXT "x" "x";
        /// How far from the upper edge of the diagram.
        ///
        /// - Unit: pixels
        /// - Required: by the schema
        y: number = RTS_EXT "y" "y";
        /// Height of the box; `-1` leaves it to the editor.
        ///
        /// - Unit: pixels
        /// - Required: by the schema
        height: number = RTS_EXT "height" "height";
        /// Width of the box; `-1` leaves it to the editor.
        ///
        /// - Unit: pixels
        /// - Required: by the schema
        width: number = RTS_EXT "width" "width";
        /// To which side the out-ports point. Small letters are understood too.
        ///
        /// - Values: `RIGHT`, `LEFT`, `UP`, `DOWN`
        /// - Required: by the schema
        direction: attribute = RTS_EXT "direction" "direction";
    }
}

profile_form! {
    /// A name and a value: what no other element has a place for.
    pub struct Property {
        /// Name of the property. A part before the first dot says whose it is, as in `rtsctl.node`.
        ///
        /// - Required: by the schema
        name: attribute = RTS_EXT "name" "name";
        /// Value of the property, as text. It may be left away.
        value: attribute = RTS_EXT "value" "value";
    }
}

profile_form! {
    /// A profile of a system that is part of this one.
    pub struct System {
        /// Where the other profile lies, as a path or URI.
        ///
        /// - Required: by the schema
        path: attribute = RTS_EXT "path" "path";
    }
}
