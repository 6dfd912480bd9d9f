//! Data and service ports with their connectors, which change places in the same way.

use crate::form::{Extra, Form};
use crate::rts_profile::forms::{
    DataPort, DataPortConnector, Profile, Property, ServicePort, ServicePortConnector, TargetPort,
    v01,
};
use crate::span::Text;

/// An element that may have properties.
pub(super) struct Typed<'a> {
    pub xsi_type: &'a mut Option<Text>,
    pub properties: &'a mut Vec<Property>,
    /// The type that the schema wants beside properties.
    pub extended: &'static str,
}

/// A port of either kind.
pub(super) trait Port: Form + Default {
    type Connector: Connector;
    /// The ports of this kind.
    fn all(component: &mut v01::Component) -> &mut Vec<Self>;
    fn name(&mut self) -> &mut Option<Text>;
    fn connectors(&mut self) -> &mut Vec<Self::Connector>;
    /// Where connectors of this kind stand since version 0.2.
    fn on_top(profile: &mut Profile) -> &mut Vec<Self::Connector>;
}

/// A connector of either kind.
pub(super) trait Connector: Form {
    fn source(&mut self) -> &mut Option<Box<TargetPort>>;
    fn typed(&mut self) -> Typed<'_>;
    fn beside(&mut self) -> &mut Extra;
}

macro_rules! port {
    ($port:ty, $connector:ty, $ports:ident, $connectors:ident, $extended:literal) => {
        impl Port for $port {
            type Connector = $connector;
            fn all(component: &mut v01::Component) -> &mut Vec<Self> {
                &mut component.$ports
            }
            fn name(&mut self) -> &mut Option<Text> {
                &mut self.name
            }
            fn connectors(&mut self) -> &mut Vec<$connector> {
                &mut self.connectors
            }
            fn on_top(profile: &mut Profile) -> &mut Vec<$connector> {
                &mut profile.$connectors
            }
        }

        impl Connector for $connector {
            fn source(&mut self) -> &mut Option<Box<TargetPort>> {
                &mut self.source
            }
            fn typed(&mut self) -> Typed<'_> {
                Typed {
                    xsi_type: &mut self.xsi_type,
                    properties: &mut self.properties,
                    extended: $extended,
                }
            }
            fn beside(&mut self) -> &mut Extra {
                &mut self.extra
            }
        }
    };
}

port!(
    DataPort,
    DataPortConnector,
    data_ports,
    data_port_connectors,
    "rtsExt:dataport_connector_ext"
);
port!(
    ServicePort,
    ServicePortConnector,
    service_ports,
    service_port_connectors,
    "rtsExt:serviceport_connector_ext"
);
