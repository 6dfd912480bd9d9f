//! Data ports, event ports and service ports.

use super::{
    Constraint, DataPortDoc, EventDoc, Property, RTC, RTC_DOC, RTC_EXT, ServiceInterfaceDoc,
    ServicePortDoc, XSI,
};
use crate::form::profile_form;

profile_form! {
    /// A data port, or an event port.
    pub struct DataPort {
        /// Type of the element in the schema: `rtcExt:dataport_ext`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Direction of the port, or that it takes events (since version 0.3).
        ///
        /// - Values: `DataInPort`, `DataOutPort`, `EventPort`
        /// - Required: by the schema
        port_type: attribute = RTC "portType" "portType";
        /// Name of the port, which connectors refer to.
        ///
        /// - Required: by the schema
        name: attribute = RTC "name" "name";
        /// Type of the data: `RTC::TimedDouble`. It must be that of the port at the other end.
        ///
        /// - Required: by the schema
        data_type: attribute = RTC "type" "type";
        /// File of IDL that defines the data type, unless OpenRTM brings it.
        idl_file: attribute = RTC "idlFile" "idlFile";
        /// How samples may travel; empty for any way.
        ///
        /// - Values: `corba_cdr`, `direct`, `shared_memory`
        interface_type: attribute = RTC "interfaceType" "interfaceType";
        /// Who may start a transfer; empty for either.
        ///
        /// - Values: `push`, `pull`
        dataflow_type: attribute = RTC "dataflowType" "dataflowType";
        /// When an out-port may push; empty for any way.
        ///
        /// - Values: `flush`, `new`, `periodic`
        /// - Versions: since 0.2
        subscription_type: attribute = RTC "subscriptionType" "subscriptionType";
        /// When an out-port may push, as the schema of version 0.1 spells it.
        ///
        /// - Versions: only 0.1
        subscriprion_type: attribute = RTC "subscriprionType" "subscriprionType";
        /// Unit of the values, for people: `m/s`.
        ///
        /// - Versions: since 0.2
        unit: attribute = RTC "unit" "unit";
        /// Name of the variable in the code that RTC Builder makes.
        ///
        /// - Versions: since 0.2
        variable_name: attribute = RTC_EXT "variableName" "rtcExt::variableName";
        /// Name of the variable in the code.
        ///
        /// - Versions: only 0.1
        varname: attribute = RTC_EXT "varname" "rtcExt::varname";
        /// Free text for people. It is kept and shown, and has no effect.
        comment: attribute = RTC_EXT "comment" "rtcExt::comment";
        /// On which side of the box editors draw it. Small letters are those of version 0.1.
        ///
        /// - Values: `LEFT`, `RIGHT`, `TOP`, `BOTTOM`
        /// - Required: by the schema
        position: attribute = RTC_EXT "position" "rtcExt::position";
        /// Which values samples may have.
        ///
        /// - Versions: since 0.2
        constraint: one<Constraint> = RTC "Constraint" "constraint";
        /// The events that an event port takes.
        ///
        /// - Versions: since 0.3
        events: many<Event> = RTC "Event" "event|events";
        /// Documentation for people: what it carries, how often, in which unit.
        doc: one<DataPortDoc> = RTC_DOC "Doc" "rtcDoc::doc";
        /// Names and values besides. They are kept.
        properties: many<Property> = RTC_EXT "Properties" "rtcExt::properties|rtcExt::property";
    }
}

profile_form! {
    /// An event that an event port takes.
    pub struct Event {
        /// Type of the element in the schema: `rtcDoc:event_doc`. The schema wants it where the element has attributes
        /// or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Name of the event, which the state machine takes.
        ///
        /// - Required: by the schema
        name: attribute = RTC "name" "name";
        /// When the event is taken: a condition in words or code.
        condition: attribute = RTC "condition" "condition";
        /// State of the machine before the event.
        ///
        /// - Required: by the schema
        source: attribute = RTC "source" "source";
        /// State of the machine after the event.
        ///
        /// - Required: by the schema
        target: attribute = RTC "target" "target";
        /// Type of the data that comes with the event.
        data_type: attribute = RTC "type" "type";
        /// Documentation for people: what it means and who sends it.
        doc: one<EventDoc> = RTC_DOC "Doc" "rtcDoc::doc";
    }
}

profile_form! {
    /// A service port: interfaces that it provides to others or requires of them.
    pub struct ServicePort {
        /// Type of the element in the schema: `rtcExt:serviceport_ext`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Name of the port, which connectors refer to.
        ///
        /// - Required: by the schema
        name: attribute = RTC "name" "name";
        /// Free text for people. It is kept and shown, and has no effect.
        comment: attribute = RTC_EXT "comment" "rtcExt::comment";
        /// On which side of the box editors draw it.
        ///
        /// - Values: `LEFT`, `RIGHT`, `TOP`, `BOTTOM`
        /// - Required: by the schema
        position: attribute = RTC_EXT "position" "rtcExt::position";
        /// Its interfaces, each provided or required.
        interfaces: many<ServiceInterface> = RTC "ServiceInterface" "serviceInterface|serviceInterfaces";
        /// In which ways calls may travel.
        ///
        /// - Versions: since 0.2
        trans_methods: many<TransMethod> = RTC "TransMethods" "transMethods|transMethod";
        /// Documentation for people: what the port is for.
        doc: one<ServicePortDoc> = RTC_DOC "Doc" "rtcDoc::doc";
        /// Names and values besides. They are kept.
        properties: many<Property> = RTC_EXT "Properties" "rtcExt::properties|rtcExt::property";
    }
}

profile_form! {
    /// An interface of a service port.
    pub struct ServiceInterface {
        /// Type of the element in the schema: `rtcExt:serviceinterface_ext`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Name of the interface within the port.
        ///
        /// - Required: by the schema
        name: attribute = RTC "name" "name";
        /// Whether the component serves the interface or calls it. Capital letters do not count.
        ///
        /// - Values: `Provided`, `Required`
        /// - Required: by the schema
        direction: attribute = RTC "direction" "direction";
        /// Name of the instance of the interface; often empty.
        instance_name: attribute = RTC "instanceName" "instanceName";
        /// Name of the variable in the code.
        ///
        /// - Versions: only 0.1
        varname: attribute = RTC "varname" "varname";
        /// File of IDL that defines the interface. RTC Builder makes stubs and skeletons of it.
        idl_file: attribute = RTC "idlFile" "idlFile";
        /// Type of the interface, with its modules: `OpenHRP::ExecutionProfileService`. Both ends must have the same.
        ///
        /// - Required: by the schema
        interface_type: attribute = RTC "type" "type";
        /// Where files lie that the IDL includes.
        ///
        /// - Versions: before 0.3; still found later
        path: attribute = RTC "path" "path";
        /// Name of the variable in the code that RTC Builder makes.
        ///
        /// - Versions: since 0.2
        variable_name: attribute = RTC_EXT "variableName" "rtcExt::variableName";
        /// Free text for people. It is kept and shown, and has no effect.
        comment: attribute = RTC_EXT "comment" "rtcExt::comment";
        /// Documentation for people: arguments, results, exceptions.
        doc: one<ServiceInterfaceDoc> = RTC_DOC "Doc" "rtcDoc::doc";
        /// Names and values besides. They are kept.
        properties: many<Property> = RTC_EXT "Properties" "rtcExt::properties|rtcExt::property";
    }
}

profile_form! {
    /// A way in which calls may travel.
    pub struct TransMethod {
        /// The way: `CORBA` and others.
        ///
        /// - Required: by the schema
        kind: attribute = RTC "kind" "kind";
    }
}
