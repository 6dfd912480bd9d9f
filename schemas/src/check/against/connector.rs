//! A connector against the RTC Profiles of both ends: what the RTS Profile leaves out is looked up there.

use super::{Against, interfaces};
use crate::check::choices::{self, Offer};
use crate::rtc_profile::forms::DataPort;
use crate::rts_profile::model::{Component, Connector, Target, property_value};
use crate::rts_profile::{CHOICES, data_type_of, direction_of, normal_data_type};
use crate::span::{Span, Text};
use crate::system::{Direction, PortKind};

/// What is known of one end.
struct Known<'a> {
    path: String,
    span: Span,
    direction: Option<Direction>,
    data_type: Option<String>,
    types: [Option<&'a str>; 3],
    /// All of it is said in the RTS Profile, and was checked there.
    said: bool,
}

pub(super) fn connector<'a>(against: &mut Against<'a>, connector: &'a Connector) {
    let (Some(source), Some(target)) = (&connector.source, &connector.target) else {
        return;
    };
    if connector.kind == PortKind::Service {
        return interfaces::interfaces(against, connector, source, target);
    }
    let (Some(source), Some(target)) = (known(against, source), known(against, target)) else {
        return;
    };
    if source.said && target.said {
        return;
    }
    let sink = &mut against.sink;
    if let (Some(a), Some(b)) = (source.direction, target.direction)
        && a == b
    {
        let (what, other, span) = match a {
            Direction::In => ("in-ports", "an out-port", source.span),
            Direction::Out => ("out-ports", "an in-port", target.span),
        };
        let message = format!("`{}` and `{}` are both {what}", source.path, target.path);
        let help = format!("one end of a data connector must be {other}; so say the RTC Profiles");
        sink.error("direction-mismatch", message, span, help);
    }
    types(sink, connector, &source, &target);
    let offers = [&source, &target].map(|end| Offer {
        path: end.path.clone(),
        types: end.types,
    });
    choices::compare(connector, &offers, |code, message, span, help| {
        sink.warning(code, message, span, help);
    });
}

fn types(
    sink: &mut crate::check::sink::Sink<'_>,
    connector: &Connector,
    source: &Known<'_>,
    target: &Known<'_>,
) {
    let help = "connect ports of one type; so say the RTC Profiles";
    if let (Some(from), Some(to)) = (&source.data_type, &target.data_type)
        && !same_type(from, to)
    {
        let message = format!(
            "`{}` has the type `{from}`, `{}` has `{to}`",
            source.path, target.path
        );
        return sink.error("data-type-mismatch", message, target.span, help);
    }
    let property = property_value(&connector.properties, "dataport.data_type");
    if let Some(own) = property.or(connector.data_type.as_ref())
        && let Some(ports) = source.data_type.as_ref().or(target.data_type.as_ref())
        && normal_data_type(&own.value).is_some()
        && !same_type(&own.value, ports)
    {
        let message = format!(
            "the connector says the type `{}`, its ports `{ports}`",
            own.trimmed()
        );
        sink.error("data-type-mismatch", message, own.span, help);
    }
}

/// What is known of an end whose component has an RTC Profile with the port.
fn known<'a>(against: &Against<'a>, target: &'a Target) -> Option<Known<'a>> {
    let (component, bare, index) = against.end(target)?;
    let own: &'a DataPort = against.types.get(&index)?.data.get(bare)?;
    let declared = against
        .read
        .port(&component.instance_name.as_ref()?.value, bare);
    let declared = declared.map(|(_, port)| port);
    let said = declared.and_then(direction_of);
    let said_type = declared.and_then(data_type_of);
    let offered = [
        &own.interface_type,
        &own.dataflow_type,
        &own.subscription_type,
    ];
    let mut types = CHOICES.map(|name| {
        let text = property_value(&declared?.properties, name)?;
        Some(text.trimmed())
    });
    let complete = said.is_some() && said_type.is_some() && types.iter().all(Option::is_some);
    for (at, text) in offered.into_iter().enumerate() {
        let own = text
            .as_ref()
            .map(Text::trimmed)
            .filter(|text| !text.is_empty());
        // `CorbaPort` is no way in which samples travel: old samples have it here.
        types[at] = types[at].or(own.filter(|own| *own != "CorbaPort"));
    }
    Some(Known {
        path: path(component, bare),
        span: target.port_name.as_ref().map_or(target.span, |p| p.span),
        direction: said.or_else(|| direction(own.port_type.as_ref()?.trimmed())),
        data_type: said_type.or_else(|| {
            let text = own.data_type.as_ref()?;
            normal_data_type(&text.value).map(|_| text.trimmed().to_owned())
        }),
        types,
        said: complete,
    })
}

pub(super) fn path(component: &Component, bare: &str) -> String {
    let instance = component.instance_name.as_ref().map_or("", Text::trimmed);
    format!("{instance}.{bare}")
}

/// Of an RTC Profile's port type; an event port takes events in.
pub(crate) fn direction(port_type: &str) -> Option<Direction> {
    match port_type.to_ascii_lowercase().as_str() {
        "datainport" | "in" | "eventport" => Some(Direction::In),
        "dataoutport" | "out" => Some(Direction::Out),
        _ => None,
    }
}

/// True when two spellings may mean one type: a bare name leaves its module open.
pub(super) fn same_type(a: &str, b: &str) -> bool {
    let (Some(one), Some(other)) = (normal_data_type(a), normal_data_type(b)) else {
        return true;
    };
    let bare = |text: &str| !text.contains("::") && !text.contains('/');
    let name = |text: &str| {
        let path = text.split(':').nth(1).unwrap_or_default();
        path.rsplit('/').next().unwrap_or_default().to_owned()
    };
    one == other || ((bare(a) || bare(b)) && name(&one) == name(&other))
}

#[cfg(test)]
mod tests {
    use super::same_type;

    #[test]
    fn a_bare_name_may_be_of_any_module() {
        assert!(same_type("IDL:RTC/TimedLong:1.0", "RTC::TimedLong"));
        assert!(same_type("IDL:Img/Image:1.0", "Image"));
        assert!(same_type("Any", "RTC::TimedLong"));
        assert!(!same_type("IDL:RTC/TimedLong:1.0", "RTC::TimedDouble"));
        assert!(!same_type("IDL:Img/Image:1.0", "Other::Image"));
    }
}
