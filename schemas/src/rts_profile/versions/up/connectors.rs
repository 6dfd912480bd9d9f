//! Connectors leave the port that they start from.

use crate::form::Value;
use crate::names::id_with_colons;
use crate::rts_profile::forms::{Profile, Property, TargetPort, v01};
use crate::rts_profile::versions::kept;
use crate::rts_profile::versions::ports::{Connector, Port};
use crate::span::Text;

/// Connectors and the positions that were kept for them.
pub(super) struct Found<C> {
    all: Vec<(Option<usize>, C)>,
}

impl<C: Connector> Found<C> {
    /// None yet.
    pub(super) fn none() -> Self {
        Self { all: Vec::new() }
    }

    /// Takes the connectors out of the ports of a component.
    pub(super) fn take<P: Port<Connector = C>>(&mut self, component: &mut v01::Component) {
        let implied = TargetPort {
            component_id: component.id.clone(),
            instance_name: component.instance_name.clone(),
            ..TargetPort::default()
        };
        P::all(component).retain_mut(|port| {
            let mut declared = true;
            let name = port.name().clone();
            for mut connector in std::mem::take(port.connectors()) {
                let source = TargetPort {
                    port_name: name.clone(),
                    ..implied.clone()
                };
                let kept = restored(&mut connector, source);
                declared &= kept.declared;
                self.all.push((kept.position, connector));
            }
            declared || says_more(port)
        });
    }

    /// Puts them on top of the profile.
    pub(super) fn put<P: Port<Connector = C>>(mut self, profile: &mut Profile) {
        self.all
            .sort_by_key(|(position, _)| position.unwrap_or(usize::MAX));
        let all = self.all.into_iter().map(|(_, connector)| connector);
        P::on_top(profile).extend(all);
    }
}

struct Kept {
    declared: bool,
    position: Option<usize>,
}

/// Gives a connector its source, as it was before it went into its port.
fn restored(connector: &mut impl Connector, mut source: TargetPort) -> Kept {
    let mut of = Kept {
        declared: true,
        position: None,
    };
    for (name, property) in kept::take(&mut connector.typed()) {
        let value = property.value.clone();
        match name.as_str() {
            "position" => of.position = value.and_then(|text| text.value.parse().ok()),
            "source.undeclared" => of.declared = false,
            "source.portName" => source.port_name = value,
            "source.instanceName" => source.instance_name = value,
            "source.componentId" => {
                source.component_id = value.map(|id| Text::new(id_with_colons(&id.value), id.span));
            }
            "source.type" => source.xsi_type = value,
            name => {
                let own = name.strip_prefix("source.property.");
                let span = property
                    .name
                    .as_ref()
                    .map_or(property.span, |name| name.span);
                let name = own.map(|own| Text::new(own, span));
                source.properties.push(Property { name, ..property });
            }
        }
    }
    connector.source().get_or_insert_with(|| Box::new(source));
    of
}

/// True for a port of which more is said than its name.
fn says_more(port: &impl Port) -> bool {
    let fields = port.form_type().fields.iter().enumerate();
    let beside = port.extra().get();
    let mut others = fields.filter(|(_, field)| !matches!(field.name, "name" | "connectors"));
    let empty = |value: Value<'_>| value.count() == 0;
    !others.all(|(at, _)| empty(port.value(at)))
        || !beside.strays.is_empty()
        || !beside.keys.is_empty()
}
