//! The forms of an RTC Profile: every element and attribute of the schemas 0.1, 0.2 and 0.3, as text.

mod actions;
mod constraint;
mod docs;
mod language;
mod ports;

pub use actions::{Action, Actions};
pub use constraint::{
    Comparison, Constraint, ConstraintUnit, Constraints, PropertyIsBetween, PropertyIsLike,
    PropertyIsNull,
};
pub use docs::{
    ActionDoc, BasicDoc, ConfigurationDoc, DataPortDoc, EventDoc, ServiceInterfaceDoc,
    ServicePortDoc,
};
pub use language::{Cxx, Java, Language, Library, TargetEnvironment};
pub use ports::{DataPort, Event, ServiceInterface, ServicePort, TransMethod};

use crate::form::{Vocabulary, profile_form};

/// Namespace of `rtc:`.
pub const RTC: &str = "http://www.openrtp.org/namespaces/rtc";
/// Namespace of `rtcDoc:`.
pub const RTC_DOC: &str = "http://www.openrtp.org/namespaces/rtc_doc";
/// Namespace of `rtcExt:`.
pub const RTC_EXT: &str = "http://www.openrtp.org/namespaces/rtc_ext";
/// Namespace of `xsi:`.
pub const XSI: &str = "http://www.w3.org/2001/XMLSchema-instance";

/// Names of RTC Profiles.
pub static WORDS: Vocabulary = Vocabulary {
    title: "RTC Profile",
    roots: &["RtcProfile"],
    namespace: RTC,
    key: "rtcProfile",
    prefixes: &[
        ("rtc", RTC),
        ("rtcDoc", RTC_DOC),
        ("rtcExt", RTC_EXT),
        ("xsi", XSI),
    ],
    others: &[
        (
            "RtsProfile",
            "this is an RTS Profile, which describes a system; a component is described by an `rtc:RtcProfile`",
        ),
        (
            "rtsProfile",
            "this is an RTS Profile, which describes a system; a component is described by `rtcProfile:`",
        ),
    ],
};

profile_form! {
    /// A type of component: what it is, its ports and parameters, and how it is built.
    pub struct RtcProfile {
        /// Type of the root, which no schema has.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// `RTC:vendor:category:type:version`.
        id: attribute = RTC "id" "id";
        /// Version of the schema: `0.1`, `0.2` or `0.3`.
        version: attribute = RTC "version" "version";
        /// What it is.
        basic_info: one<BasicInfo> = RTC "BasicInfo" "basicInfo";
        /// Which of its actions are implemented.
        actions: one<Actions> = RTC "Actions" "actions";
        /// Its configuration parameters.
        configuration_set: one<ConfigurationSet> = RTC "ConfigurationSet" "configurationSet";
        /// Its data ports and event ports.
        data_ports: many<DataPort> = RTC "DataPorts" "dataPorts";
        /// Its service ports.
        service_ports: many<ServicePort> = RTC "ServicePorts" "servicePorts";
        /// Parameters of the system (before version 0.3).
        parameters: many<Parameter> = RTC "Parameters" "parameters";
        /// In which language it is written.
        language: one<Language> = RTC "Language" "language";
    }
}

profile_form! {
    /// What a component is.
    pub struct BasicInfo {
        /// `rtcExt:basic_info_ext`, when it has elements or attributes of `rtcExt` or `rtcDoc`.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Name of the type.
        name: attribute = RTC "name" "name";
        /// `STATIC`, `UNIQUE` or `COMMUTATIVE`.
        component_type: attribute = RTC "componentType" "componentType";
        /// `PERIODIC`, `SPORADIC` or `EVENTDRIVEN`.
        activity_type: attribute = RTC "activityType" "activityType";
        /// `DataFlowComponent`, `FiniteStateMachineComponent` and others.
        component_kind: attribute = RTC "componentKind" "componentKind";
        /// Kind of component, as the vendor names it.
        rtc_type: attribute = RTC "rtcType" "rtcType";
        /// Category.
        category: attribute = RTC "category" "category";
        /// One line on what it does.
        description: attribute = RTC "description" "description";
        /// Cycles in a second.
        execution_rate: number = RTC "executionRate" "executionRate";
        /// `PeriodicExecutionContext`, `ExtTrigExecutionContext` and others.
        execution_type: attribute = RTC "executionType" "executionType";
        /// How many there may be in one process; 0 for any number.
        max_instances: number = RTC "maxInstances" "maxInstances";
        /// Who made it.
        vendor: attribute = RTC "vendor" "vendor";
        /// Version of the component.
        version: attribute = RTC "version" "version";
        /// What it is for.
        abstract_text: attribute = RTC "abstract" "abstract";
        /// The hardware it is made for.
        hardware_profile: attribute = RTC "hardwareProfile" "hardwareProfile";
        /// When the profile was made.
        creation_date: date = RTC "creationDate" "creationDate";
        /// When the profile was changed last.
        update_date: date = RTC "updateDate" "updateDate";
        /// Free text.
        comment: attribute = RTC_EXT "comment" "rtcExt::comment";
        /// Name of the editor's project.
        save_project: attribute = RTC_EXT "saveProject" "rtcExt::saveProject";
        /// Documentation.
        doc: one<BasicDoc> = RTC_DOC "Doc" "rtcDoc::doc";
        /// What was changed, version by version.
        version_up_logs: texts = RTC_EXT "VersionUpLogs" "rtcExt::versionUpLogs";
        /// The same, under its older name.
        version_up_log: texts = RTC_EXT "VersionUpLog" "rtcExt::versionUpLog";
        /// `FSM`, `__iso__…` and others.
        properties: many<Property> = RTC_EXT "Properties" "rtcExt::properties|rtcExt::property";
    }
}

profile_form! {
    /// The configuration parameters.
    pub struct ConfigurationSet {
        /// The parameters.
        configurations: many<Configuration> = RTC "Configuration" "configuration|configurations";
    }
}

profile_form! {
    /// A configuration parameter.
    pub struct Configuration {
        /// `rtcExt:configuration_ext`, when it has elements or attributes of `rtcExt` or `rtcDoc`.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Name of the parameter.
        name: attribute = RTC "name" "name";
        /// Data type: `int`, `double`, `std::string` and others.
        data_type: attribute = RTC "type" "type";
        /// Value until another is set.
        default_value: attribute = RTC "defaultValue" "defaultValue";
        /// Unit of the value.
        unit: attribute = RTC "unit" "unit";
        /// Name of the variable in the code (version 0.1).
        varname: attribute = RTC "varname" "varname";
        /// Name of the variable in the code.
        variable_name: attribute = RTC_EXT "variableName" "rtcExt::variableName";
        /// Free text.
        comment: attribute = RTC_EXT "comment" "rtcExt::comment";
        /// Which values are allowed.
        constraint: one<Constraint> = RTC "Constraint" "constraint";
        /// Documentation.
        doc: one<ConfigurationDoc> = RTC_DOC "Doc" "rtcDoc::doc";
        /// `__widget__`: how editors show it, and others.
        properties: many<Property> = RTC_EXT "Properties" "rtcExt::properties|rtcExt::property";
    }
}

profile_form! {
    /// A parameter of the system (before version 0.3).
    pub struct Parameter {
        /// Name.
        name: attribute = RTC "name" "name";
        /// Value until another is set.
        default_value: attribute = RTC "defaultValue" "defaultValue";
    }
}

profile_form! {
    /// A name and a value.
    pub struct Property {
        /// Name.
        name: attribute = RTC_EXT "name" "name";
        /// Value.
        value: attribute = RTC_EXT "value" "value";
    }
}
