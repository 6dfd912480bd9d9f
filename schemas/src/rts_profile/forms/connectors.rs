//! Connections between ports.

use super::{Property, RTS, RTS_EXT, XSI};
use crate::form::profile_form;

profile_form! {
    /// A connection between two data ports.
    pub struct DataPortConnector {
        /// Type of the element in the schema: `rtsExt:dataport_connector_ext`. The schema wants it where the element
        /// has attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Any text; editors write a UUID. It may stand in a file twice, so nothing is found by it.
        ///
        /// - Required: by the schema
        connector_id: attribute = RTS "connectorId" "connectorId";
        /// Any text: often the names of both ports. A good name makes messages of `rtsctl` easier to read.
        ///
        /// - Required: by the schema
        name: attribute = RTS "name" "name";
        /// Type of the data: `IDL:RTC/TimedLong:1.0`; `TimedLong` and `RTC::TimedLong` mean the same. Where it is
        /// missing, the property `dataport.data_type` counts.
        ///
        /// - Required: by the schema
        data_type: attribute = RTS "dataType" "dataType";
        /// How samples travel: by CORBA, by a function call within one process, or by shared memory.
        ///
        /// - Values: `corba_cdr`, `direct`, `shared_memory`
        /// - Default: `corba_cdr`
        /// - Required: by the schema
        interface_type: attribute = RTS "interfaceType" "interfaceType";
        /// Who starts a transfer: the out-port (`push`) or the in-port (`pull`). Capital letters do not count.
        ///
        /// - Values: `push`, `pull`
        /// - Default: `push`
        /// - Required: by the schema
        dataflow_type: attribute = RTS "dataflowType" "dataflowType";
        /// When an out-port pushes: in its own call and waiting for the receiver (`flush`, `block`), from a queue when
        /// there is something new (`new`), or at a rate (`periodic`).
        ///
        /// - Values: `flush`, `new`, `periodic`, `block`
        /// - Default: `flush`
        subscription_type: attribute = RTS "subscriptionType" "subscriptionType";
        /// How often samples are pushed, with the subscription type `periodic`. Others ignore it.
        ///
        /// - Unit: pushes in a second (Hz)
        push_interval: number = RTS "pushInterval" "pushInterval";
        /// Free text for people. It is kept and shown, and has no effect.
        comment: attribute = RTS_EXT "comment" "rtsExt::comment";
        /// Whether editors show it. It has no effect on the system.
        ///
        /// - Values: `true`, `false`
        /// - Default: `true`
        visible: boolean = RTS_EXT "visible" "rtsExt::visible";
        /// The port that writes: an out-port. Where a file has the ends the wrong way round, they are swapped, with a
        /// warning.
        ///
        /// - Required: by the schema
        source: one<TargetPort> = RTS "sourceDataPort" "sourceDataPort";
        /// The port that reads: an in-port. Several are several connections.
        ///
        /// - Required: by the schema
        targets: some<TargetPort> = RTS "targetDataPort" "targetDataPort";
        /// How the connection is made: `dataport.*` for buffers, serializers, time-outs and others. They win over the
        /// attributes; references of CORBA (`…_ior`) are left away.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// A connection between two service ports.
    pub struct ServicePortConnector {
        /// Type of the element in the schema: `rtsExt:serviceport_connector_ext`. The schema wants it where the element
        /// has attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Any text; editors write a UUID. Nothing is found by it.
        ///
        /// - Required: by the schema
        connector_id: attribute = RTS "connectorId" "connectorId";
        /// Any text: often the names of both ports.
        ///
        /// - Required: by the schema
        name: attribute = RTS "name" "name";
        /// How calls travel. No known editor writes it.
        trans_method: attribute = RTS "transMethod" "transMethod";
        /// Free text for people. It is kept and shown, and has no effect.
        comment: attribute = RTS_EXT "comment" "rtsExt::comment";
        /// Whether editors show it. It has no effect on the system.
        ///
        /// - Values: `true`, `false`
        /// - Default: `true`
        visible: boolean = RTS_EXT "visible" "rtsExt::visible";
        /// One end. Which side provides and which requires is said by the interfaces of the ports, not by this order.
        ///
        /// - Required: by the schema
        source: one<TargetPort> = RTS "sourceServicePort" "sourceServicePort";
        /// The other end. Several are several connections.
        ///
        /// - Required: by the schema
        targets: some<TargetPort> = RTS "targetServicePort" "targetServicePort";
        /// Which required interface is bound to which provided one, and `port.connection.strictness`. References of
        /// CORBA are left away.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// An end of a connection.
    pub struct TargetPort {
        /// Type of the element in the schema: `rtsExt:target_port_ext`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Id of the component: `RTC:vendor:category:type:version`. The instance name finds it; this only confirms it.
        ///
        /// - Required: by the schema
        component_id: attribute = RTS "componentId" "componentId";
        /// Instance name of the component that has the port.
        ///
        /// - Required: by the schema
        instance_name: attribute = RTS "instanceName" "instanceName";
        /// Name of the port, alone (`out`) or after the instance name and a dot (`Motor0.out`).
        ///
        /// - Required: by the schema
        port_name: attribute = RTS "portName" "portName";
        /// `COMPONENT_PATH_ID` repeats the `pathUri` of the component, sometimes by way of its manager; it only settles
        /// doubts.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}
