//! Data ports, event ports and service ports.

use super::{
    Constraint, DataPortDoc, EventDoc, Property, RTC, RTC_DOC, RTC_EXT, ServiceInterfaceDoc,
    ServicePortDoc, XSI,
};
use crate::form::profile_form;

profile_form! {
    /// A data port, or an event port.
    pub struct DataPort {
        /// `rtcExt:dataport_ext`, when it has elements or attributes of `rtcExt` or `rtcDoc`.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// `DataInPort`, `DataOutPort` or `EventPort`.
        port_type: attribute = RTC "portType" "portType";
        /// Name of the port.
        name: attribute = RTC "name" "name";
        /// Data type: `RTC::TimedDouble`.
        data_type: attribute = RTC "type" "type";
        /// File that defines the data type.
        idl_file: attribute = RTC "idlFile" "idlFile";
        /// How samples travel: `corba_cdr`.
        interface_type: attribute = RTC "interfaceType" "interfaceType";
        /// `push`, `pull`.
        dataflow_type: attribute = RTC "dataflowType" "dataflowType";
        /// `flush`, `new`, `periodic`.
        subscription_type: attribute = RTC "subscriptionType" "subscriptionType";
        /// The same, as the schema of version 0.1 spells it.
        subscriprion_type: attribute = RTC "subscriprionType" "subscriprionType";
        /// Unit of the values.
        unit: attribute = RTC "unit" "unit";
        /// Name of the variable in the code.
        variable_name: attribute = RTC_EXT "variableName" "rtcExt::variableName";
        /// Name of the variable in the code (version 0.1).
        varname: attribute = RTC_EXT "varname" "rtcExt::varname";
        /// Free text.
        comment: attribute = RTC_EXT "comment" "rtcExt::comment";
        /// On which side editors draw it: `LEFT`, `RIGHT`, `TOP`, `BOTTOM`.
        position: attribute = RTC_EXT "position" "rtcExt::position";
        /// Which values are allowed.
        constraint: one<Constraint> = RTC "Constraint" "constraint";
        /// Events of an event port (since version 0.3).
        events: many<Event> = RTC "Event" "event|events";
        /// Documentation.
        doc: one<DataPortDoc> = RTC_DOC "Doc" "rtcDoc::doc";
        /// Properties of the port.
        properties: many<Property> = RTC_EXT "Properties" "rtcExt::properties|rtcExt::property";
    }
}

profile_form! {
    /// An event that an event port takes.
    pub struct Event {
        /// `rtcDoc:event_doc`, when it has documentation.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Name of the event.
        name: attribute = RTC "name" "name";
        /// When it is taken.
        condition: attribute = RTC "condition" "condition";
        /// State before it.
        source: attribute = RTC "source" "source";
        /// State after it.
        target: attribute = RTC "target" "target";
        /// Data type.
        data_type: attribute = RTC "type" "type";
        /// Documentation.
        doc: one<EventDoc> = RTC_DOC "Doc" "rtcDoc::doc";
    }
}

profile_form! {
    /// A service port.
    pub struct ServicePort {
        /// `rtcExt:serviceport_ext`, when it has elements or attributes of `rtcExt` or `rtcDoc`.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Name of the port.
        name: attribute = RTC "name" "name";
        /// Free text.
        comment: attribute = RTC_EXT "comment" "rtcExt::comment";
        /// On which side editors draw it.
        position: attribute = RTC_EXT "position" "rtcExt::position";
        /// Its interfaces.
        interfaces: many<ServiceInterface> = RTC "ServiceInterface" "serviceInterface|serviceInterfaces";
        /// How calls may travel.
        trans_methods: many<TransMethod> = RTC "TransMethods" "transMethods|transMethod";
        /// Documentation.
        doc: one<ServicePortDoc> = RTC_DOC "Doc" "rtcDoc::doc";
        /// Properties of the port.
        properties: many<Property> = RTC_EXT "Properties" "rtcExt::properties|rtcExt::property";
    }
}

profile_form! {
    /// An interface of a service port.
    pub struct ServiceInterface {
        /// `rtcExt:serviceinterface_ext`, when it has elements or attributes of `rtcExt` or `rtcDoc`.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Name of the interface.
        name: attribute = RTC "name" "name";
        /// `Provided` or `Required`.
        direction: attribute = RTC "direction" "direction";
        /// Name of the instance.
        instance_name: attribute = RTC "instanceName" "instanceName";
        /// Name of the variable in the code (version 0.1).
        varname: attribute = RTC "varname" "varname";
        /// File that defines the interface.
        idl_file: attribute = RTC "idlFile" "idlFile";
        /// Type of the interface, with its modules.
        interface_type: attribute = RTC "type" "type";
        /// Where included files lie (before version 0.3).
        path: attribute = RTC "path" "path";
        /// Name of the variable in the code.
        variable_name: attribute = RTC_EXT "variableName" "rtcExt::variableName";
        /// Free text.
        comment: attribute = RTC_EXT "comment" "rtcExt::comment";
        /// Documentation.
        doc: one<ServiceInterfaceDoc> = RTC_DOC "Doc" "rtcDoc::doc";
        /// Properties of the interface.
        properties: many<Property> = RTC_EXT "Properties" "rtcExt::properties|rtcExt::property";
    }
}

profile_form! {
    /// A way in which calls may travel.
    pub struct TransMethod {
        /// `CORBA` and others.
        kind: attribute = RTC "kind" "kind";
    }
}
