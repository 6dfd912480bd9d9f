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
        (
            "apiVersion",
            "this is a deployment overlay, which is laid over an RTS Profile (`-f PROFILE -f OVERLAY`)",
        ),
        (
            "kind",
            "this is a deployment overlay, which is laid over an RTS Profile (`-f PROFILE -f OVERLAY`)",
        ),
    ],
};

profile_form! {
    /// A type of component: what it is, its ports and parameters, and how it is built.
    pub struct RtcProfile {
        /// Type of the root. No schema has one; some files have it, and it is kept.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// What the component is: `RTC:vendor:category:type:version` (in version 0.1
        /// `RTC:vendor.category.type:version`). An RTS Profile refers to it.
        ///
        /// - Required: by the schema
        id: attribute = RTC "id" "id";
        /// Version of the schema. Some files write `1.0`, which is read as the newest.
        ///
        /// - Values: `0.1`, `0.2`, `0.3`
        /// - Required: by the schema
        version: attribute = RTC "version" "version";
        /// What the component is: name, kind, version, vendor, and how it is executed.
        ///
        /// - Required: by the schema
        basic_info: one<BasicInfo> = RTC "BasicInfo" "basicInfo";
        /// Which of the callbacks of a component (`onInitialize`, `onExecute`, …) it implements.
        ///
        /// - Required: by the schema
        actions: one<Actions> = RTC "Actions" "actions";
        /// The configuration parameters that the component has, with types, defaults and allowed values.
        configuration_set: one<ConfigurationSet> = RTC "ConfigurationSet" "configurationSet";
        /// Its data ports and event ports. `rtsctl check --rtc` compares connectors with them.
        data_ports: many<DataPort> = RTC "DataPorts" "dataPorts";
        /// Its service ports, with the interfaces that they provide or require.
        service_ports: many<ServicePort> = RTC "ServicePorts" "servicePorts";
        /// Parameters of the system that the component needs.
        ///
        /// - Versions: before 0.3; still found later
        parameters: many<Parameter> = RTC "Parameters" "parameters";
        /// In which language it is written, and for which machines.
        language: one<Language> = RTC "Language" "language";
    }
}

profile_form! {
    /// What a component is.
    pub struct BasicInfo {
        /// Type of the element in the schema: `rtcExt:basic_info_ext`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Name of the type: `MotorController`. Its module has this name too.
        ///
        /// - Required: by the schema
        name: attribute = RTC "name" "name";
        /// Whether instances are made at will (`COMMUTATIVE`), each is unlike the others (`UNIQUE`), or all exist from
        /// the start (`STATIC`).
        ///
        /// - Values: `STATIC`, `UNIQUE`, `COMMUTATIVE`
        /// - Required: by the schema
        component_type: attribute = RTC "componentType" "componentType";
        /// Whether the component acts at a rate, now and then, or on events. `EVENT_DRIVEN` of version 0.1 is
        /// understood.
        ///
        /// - Values: `PERIODIC`, `SPORADIC`, `EVENTDRIVEN`
        /// - Required: by the schema
        activity_type: attribute = RTC "activityType" "activityType";
        /// The model it follows: `DataFlowComponent`, `FiniteStateMachineComponent`, `MultiModeComponent`, or several
        /// with commas.
        ///
        /// - Required: by the schema
        component_kind: attribute = RTC "componentKind" "componentKind";
        /// Kind of component, as the vendor names it. It has no effect.
        ///
        /// - Versions: since 0.2
        rtc_type: attribute = RTC "rtcType" "rtcType";
        /// Category, by which editors sort components: `Controller`, `Sensor`.
        ///
        /// - Required: by the schema
        category: attribute = RTC "category" "category";
        /// One line on what it does, which editors show.
        description: attribute = RTC "description" "description";
        /// How often its execution context runs it, unless the system says another rate.
        ///
        /// - Unit: cycles in a second (Hz)
        execution_rate: number = RTC "executionRate" "executionRate";
        /// Type of its execution context.
        ///
        /// - Values: `PeriodicExecutionContext`, `ExtTrigExecutionContext`
        /// - Required: by the schema
        execution_type: attribute = RTC "executionType" "executionType";
        /// How many instances one process may hold; 0 for any number.
        ///
        /// - Default: `0`
        max_instances: number = RTC "maxInstances" "maxInstances";
        /// Who made it. The name is part of the id.
        ///
        /// - Required: by the schema
        vendor: attribute = RTC "vendor" "vendor";
        /// Version of the component, `1.0.0`, which is part of the id.
        ///
        /// - Required: by the schema
        version: attribute = RTC "version" "version";
        /// What it is for, in a few sentences. It has no effect.
        abstract_text: attribute = RTC "abstract" "abstract";
        /// The hardware it is made for, as a name or a path.
        ///
        /// - Versions: since 0.2
        hardware_profile: attribute = RTC "hardwareProfile" "hardwareProfile";
        /// When the profile was made: `2013-08-01T15:23:27`. In YAML it is a mapping of its parts.
        ///
        /// - Required: by the schema
        creation_date: date = RTC "creationDate" "creationDate";
        /// When the profile was changed last, written as `creationDate`.
        ///
        /// - Required: by the schema
        update_date: date = RTC "updateDate" "updateDate";
        /// Free text for people. It is kept and shown, and has no effect.
        comment: attribute = RTC_EXT "comment" "rtcExt::comment";
        /// Name of the project of RTC Builder that the profile belongs to.
        save_project: attribute = RTC_EXT "saveProject" "rtcExt::saveProject";
        /// Documentation for people: what it does, how, who made it, under which license.
        doc: one<BasicDoc> = RTC_DOC "Doc" "rtcDoc::doc";
        /// What was changed, version by version: one text for each.
        ///
        /// - Versions: since 0.2
        version_up_logs: texts = RTC_EXT "VersionUpLogs" "rtcExt::versionUpLogs";
        /// What was changed, version by version, under the name that version 0.1 has.
        ///
        /// - Versions: only 0.1
        version_up_log: texts = RTC_EXT "VersionUpLog" "rtcExt::versionUpLog";
        /// Names and values besides: `FSM` and `FSMType` for state machines, `__iso__…` for ISO 22166.
        properties: many<Property> = RTC_EXT "Properties" "rtcExt::properties|rtcExt::property";
    }
}

profile_form! {
    /// The configuration parameters of a component.
    pub struct ConfigurationSet {
        /// The parameters, each with its type and the value that it has first.
        configurations: many<Configuration> = RTC "Configuration" "configuration|configurations";
    }
}

profile_form! {
    /// A configuration parameter.
    pub struct Configuration {
        /// Type of the element in the schema: `rtcExt:configuration_ext`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Name of the parameter, by which `rtsctl conf` and RTS Profiles set it.
        ///
        /// - Required: by the schema
        name: attribute = RTC "name" "name";
        /// Type of the value, as the language of the component names it: `int`, `double`, `std::string`,
        /// `std::vector<double>`.
        ///
        /// - Required: by the schema
        data_type: attribute = RTC "type" "type";
        /// Value that it has until another is set, as text.
        ///
        /// - Required: by the schema
        default_value: attribute = RTC "defaultValue" "defaultValue";
        /// Unit of the value, for people: `rad/s`.
        ///
        /// - Versions: since 0.2
        unit: attribute = RTC "unit" "unit";
        /// Name of the variable in the code.
        ///
        /// - Versions: only 0.1; later `variableName`
        varname: attribute = RTC "varname" "varname";
        /// Name of the variable in the code that RTC Builder makes.
        ///
        /// - Versions: since 0.2
        variable_name: attribute = RTC_EXT "variableName" "rtcExt::variableName";
        /// Free text for people. It is kept and shown, and has no effect.
        comment: attribute = RTC_EXT "comment" "rtcExt::comment";
        /// Which values are allowed. `rtsctl check --rtc` compares the values of an RTS Profile with it.
        ///
        /// - Versions: since 0.2
        constraint: one<Constraint> = RTC "Constraint" "constraint";
        /// Documentation for people: meaning, unit, range.
        doc: one<ConfigurationDoc> = RTC_DOC "Doc" "rtcDoc::doc";
        /// Names and values besides: `__widget__` says how editors show the parameter (`text`, `radio`, `slider.0.01`,
        /// `spin`, `checkbox`).
        properties: many<Property> = RTC_EXT "Properties" "rtcExt::properties|rtcExt::property";
    }
}

profile_form! {
    /// A parameter of the system that a component needs (before version 0.3).
    pub struct Parameter {
        /// Name of the parameter within the system.
        ///
        /// - Required: by the schema
        name: attribute = RTC "name" "name";
        /// Value that it has until another is set, as text.
        default_value: attribute = RTC "defaultValue" "defaultValue";
    }
}

profile_form! {
    /// A name and a value: what no other element has a place for.
    pub struct Property {
        /// Name of the property: `__widget__`, `FSM`.
        ///
        /// - Required: by the schema
        name: attribute = RTC_EXT "name" "name";
        /// Value of the property, as text. It may be left away.
        value: attribute = RTC_EXT "value" "value";
    }
}
