//! Connections between ports.

use super::{Property, RTS, RTS_EXT, XSI};
use crate::form::profile_form;

profile_form! {
    /// A connection between two data ports.
    pub struct DataPortConnector {
        /// `rtsExt:dataport_connector_ext`, when it has elements or attributes of `rtsExt`.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Any text; editors write a UUID.
        connector_id: attribute = RTS "connectorId" "connectorId";
        /// Any text.
        name: attribute = RTS "name" "name";
        /// Data type: `IDL:RTC/TimedLong:1.0`, or shorter.
        data_type: attribute = RTS "dataType" "dataType";
        /// How samples travel: `corba_cdr`, `direct`, `shared_memory`.
        interface_type: attribute = RTS "interfaceType" "interfaceType";
        /// `push` or `pull`.
        dataflow_type: attribute = RTS "dataflowType" "dataflowType";
        /// When samples are pushed: `flush`, `new`, `periodic`, `block`.
        subscription_type: attribute = RTS "subscriptionType" "subscriptionType";
        /// Pushes in a second, for `periodic`.
        push_interval: number = RTS "pushInterval" "pushInterval";
        /// Free text.
        comment: attribute = RTS_EXT "comment" "rtsExt::comment";
        /// `false` if editors hide it.
        visible: boolean = RTS_EXT "visible" "rtsExt::visible";
        /// The port that writes.
        source: one<TargetPort> = RTS "sourceDataPort" "sourceDataPort";
        /// The port that reads.
        targets: some<TargetPort> = RTS "targetDataPort" "targetDataPort";
        /// `dataport.*`: buffers, serializers and others.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// A connection between two service ports.
    pub struct ServicePortConnector {
        /// `rtsExt:serviceport_connector_ext`, when it has elements or attributes of `rtsExt`.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Any text; editors write a UUID.
        connector_id: attribute = RTS "connectorId" "connectorId";
        /// Any text.
        name: attribute = RTS "name" "name";
        /// How calls travel.
        trans_method: attribute = RTS "transMethod" "transMethod";
        /// Free text.
        comment: attribute = RTS_EXT "comment" "rtsExt::comment";
        /// `false` if editors hide it.
        visible: boolean = RTS_EXT "visible" "rtsExt::visible";
        /// One end.
        source: one<TargetPort> = RTS "sourceServicePort" "sourceServicePort";
        /// The other end.
        targets: some<TargetPort> = RTS "targetServicePort" "targetServicePort";
        /// Properties of the connection.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// An end of a connection.
    pub struct TargetPort {
        /// `rtsExt:target_port_ext`, when it has properties.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Id of the component.
        component_id: attribute = RTS "componentId" "componentId";
        /// Instance name of the component.
        instance_name: attribute = RTS "instanceName" "instanceName";
        /// Name of the port, bare or with the instance name and a dot before it.
        port_name: attribute = RTS "portName" "portName";
        /// `COMPONENT_PATH_ID` and others.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}
