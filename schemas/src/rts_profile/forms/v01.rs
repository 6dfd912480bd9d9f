//! The forms of an RTS Profile 0.1, where they differ: connectors lie in the ports, orders in the components.

use super::{
    ConfigurationSet, DataPort, ExecutionContext, Location, Participants, Property, RTS, RTS_EXT,
    ServicePort, TargetComponent, XSI,
};
use crate::form::profile_form;

profile_form! {
    /// A system, as version 0.1 describes it.
    pub struct Profile {
        /// `rtsExt:rts_profile_ext`, when the root has elements or attributes of `rtsExt`.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// `RTSystem:vendor.name:version`.
        id: attribute = RTS "id" "id";
        /// Version of the schema: `0.1`.
        version: attribute = RTS "version" "version";
        /// What the system is for.
        abstract_text: attribute = RTS "abstract" "abstract";
        /// When the profile was made.
        creation_date: date = RTS "creationDate" "creationDate";
        /// When the profile was changed last.
        update_date: date = RTS "updateDate" "updateDate";
        /// Free text.
        comment: attribute = RTS_EXT "comment" "rtsExt::comment";
        /// The components of the system.
        components: many<Component> = RTS "Component" "components";
        /// What was changed, version by version.
        version_up_logs: texts = RTS_EXT "VersionUpLogs" "rtsExt::versionUpLogs";
        /// The same, under its older name.
        version_up_log: texts = RTS_EXT "VersionUpLog" "rtsExt::versionUpLog";
        /// Names and values that no element has a place for.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// A component of the system.
    pub struct Component {
        /// `rtsExt:component_ext`, when it has elements or attributes of `rtsExt`.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// `RTC:vendor.category.type:version`.
        id: attribute = RTS "id" "id";
        /// Its name, which is its alone in the system.
        instance_name: attribute = RTS "instanceName" "instanceName";
        /// Address of the name server, and the path of the component in it.
        path_uri: attribute = RTS "pathUri" "pathUri";
        /// Name of the configuration set that is in use.
        active_configuration_set: attribute = RTS "activeConfigurationSet" "activeConfigurationSet";
        /// `None`, `AllShared`, `ECShared`, `NonShared` or `Choice`.
        composite_type: attribute = RTS "compositeType" "compositeType";
        /// `false` if the system works without it.
        is_required: boolean = RTS "isRequired" "isRequired";
        /// Free text.
        comment: attribute = RTS_EXT "comment" "rtsExt::comment";
        /// `false` if editors hide it.
        visible: boolean = RTS_EXT "visible" "rtsExt::visible";
        /// When it is started.
        start_up: one<StartUp> = RTS "StartUp" "startUp";
        /// Members of a composite component.
        participants: many<Participants> = RTS "Participants" "participants";
        /// Execution contexts.
        execution_contexts: many<ExecutionContext> = RTS "ExecutionContexts" "executionContexts";
        /// Sets of configuration values.
        configuration_sets: many<ConfigurationSet> = RTS "ConfigurationSets" "configurationSets";
        /// Data ports, with the connections that start there.
        data_ports: many<DataPort> = RTS "DataPorts" "dataPorts";
        /// Service ports, with the connections that start there.
        service_ports: many<ServicePort> = RTS "ServicePorts" "servicePorts";
        /// Where editors draw it.
        location: one<Location> = RTS_EXT "Location" "rtsExt::location";
        /// Properties of the component.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// When a component is started.
    pub struct StartUp {
        /// A whole number; smaller ones go first.
        sequence: number = RTS "sequence" "sequence";
        /// What it waits for.
        conditions: many<Condition> = RTS "Condition" "conditions|condition";
    }
}

profile_form! {
    /// What a component waits for.
    pub struct Condition {
        /// `rtsExt:condition_ext`, when it has properties.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// A time, as XML Schema writes durations: `PT1.5S`.
        wait_time: text = RTS "WaitTime" "waitTime";
        /// Other components.
        preceding: one<Preceding> = RTS "Preceding" "preceding";
        /// Properties of the condition.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// Components to wait for.
    pub struct Preceding {
        /// The components.
        components: many<TargetComponent> = RTS "PrecedingComponent" "precedingComponents|precedingComponent";
    }
}
