//! The forms of an RTS Profile 0.1, where they differ: connectors lie in the ports, orders in the components.

use super::{
    ConfigurationSet, DataPort, ExecutionContext, Location, Participants, Property, RTS, RTS_EXT,
    ServicePort, TargetComponent, XSI,
};
use crate::form::profile_form;

profile_form! {
    /// A system, as version 0.1 describes it: connectors lie in the ports, the order in the components.
    pub struct Profile {
        /// Type of the element in the schema: `rtsExt:rts_profile_ext`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Identity of the system: `RTSystem:vendor.name:version`. The last part before the version names the system in
        /// `rtsctl`.
        ///
        /// - Required: by the schema
        id: attribute = RTS "id" "id";
        /// Version of the schema, as the file says it.
        ///
        /// - Values: `0.1`
        /// - Required: by the schema
        version: attribute = RTS "version" "version";
        /// What the system is for, in a few words. Editors show it; it has no effect.
        abstract_text: attribute = RTS "abstract" "abstract";
        /// When the profile was made: `2013-08-01T15:23:27`, with a time zone or without.
        ///
        /// - Required: by the schema
        creation_date: date = RTS "creationDate" "creationDate";
        /// When the profile was changed last, written as `creationDate`.
        ///
        /// - Required: by the schema
        update_date: date = RTS "updateDate" "updateDate";
        /// Free text for people. It is kept and shown, and has no effect.
        comment: attribute = RTS_EXT "comment" "rtsExt::comment";
        /// The components of the system, with their ports, connectors and start-up.
        components: many<Component> = RTS "Component" "components";
        /// What was changed, version by version: one text for each.
        version_up_logs: texts = RTS_EXT "VersionUpLogs" "rtsExt::versionUpLogs";
        /// What was changed, version by version, under the name that the schema of 0.1 has.
        version_up_log: texts = RTS_EXT "VersionUpLog" "rtsExt::versionUpLog";
        /// Names and values that no element has a place for.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// A component of the system, as version 0.1 describes it.
    pub struct Component {
        /// Type of the element in the schema: `rtsExt:component_ext`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// What the component is: `RTC:vendor.category.type:version`. The last part before the version is the type, by
        /// which its module is found.
        ///
        /// - Required: by the schema
        id: attribute = RTS "id" "id";
        /// Name of the instance, which is its alone in the system. Connectors refer to it.
        ///
        /// - Required: by the schema
        instance_name: attribute = RTS "instanceName" "instanceName";
        /// Address of the name server, and the path of the component in it: `localhost:2809/Motor0.rtc`.
        ///
        /// - Required: by the schema
        path_uri: attribute = RTS "pathUri" "pathUri";
        /// Name of the configuration set that is in use. It is one of `configurationSets`.
        active_configuration_set: attribute = RTS "activeConfigurationSet" "activeConfigurationSet";
        /// How a composite component treats its members.
        ///
        /// - Values: `None`, `AllShared`, `ECShared`, `NonShared`, `Choice`
        /// - Default: `None`
        composite_type: attribute = RTS "compositeType" "compositeType";
        /// Whether the system is of no use without it.
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
        /// When the component is started among the others. Without it, at once.
        start_up: one<StartUp> = RTS "StartUp" "startUp";
        /// Members of a composite component, by reference.
        participants: many<Participants> = RTS "Participants" "participants";
        /// Execution contexts that run the component. They have no ids in this version.
        execution_contexts: many<ExecutionContext> = RTS "ExecutionContexts" "executionContexts";
        /// Sets of configuration values; sets with names as `__widget__` say how editors show the others.
        configuration_sets: many<ConfigurationSet> = RTS "ConfigurationSets" "configurationSets";
        /// Its data ports, with the connections that start there.
        data_ports: many<DataPort> = RTS "DataPorts" "dataPorts";
        /// Its service ports, with the connections that start there.
        service_ports: many<ServicePort> = RTS "ServicePorts" "servicePorts";
        /// Where editors draw it in their diagram. It has no effect on the system.
        location: one<Location> = RTS_EXT "Location" "rtsExt::location";
        /// Properties of the component, the placement of `rtsctl` among them.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// When a component is started, as version 0.1 says it.
    pub struct StartUp {
        /// Place in the order: a whole number. Smaller ones go first.
        ///
        /// - Required: by the schema
        sequence: number = RTS "sequence" "sequence";
        /// What the component waits for before it is started: times, or other components.
        conditions: many<Condition> = RTS "Condition" "conditions|condition";
    }
}

profile_form! {
    /// What a component waits for.
    pub struct Condition {
        /// Type of the element in the schema: `rtsExt:condition_ext`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// A time to wait, as XML Schema writes durations: `PT1.5S` is one and a half seconds.
        wait_time: text = RTS "WaitTime" "waitTime";
        /// Other components that must have been started before.
        preceding: one<Preceding> = RTS "Preceding" "preceding";
        /// Properties of the condition. They are kept, and have no effect.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// Components to wait for.
    pub struct Preceding {
        /// The components to wait for, by reference: all of them.
        components: many<TargetComponent> = RTS "PrecedingComponent" "precedingComponents|precedingComponent";
    }
}
