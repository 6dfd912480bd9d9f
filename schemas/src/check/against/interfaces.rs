//! Service connectors: what one side requires, the other must provide.

use super::Against;
use super::connector::path;
use crate::rtc_profile::forms::{ServiceInterface, ServicePort};
use crate::rts_profile::model::{Connector, Target};
use crate::span::{Span, Text};

const CODE: &str = "service-interface-mismatch";

/// One side of a service connector.
struct Side<'a> {
    path: String,
    span: Span,
    port: &'a ServicePort,
}

impl<'a> Side<'a> {
    fn interfaces(&self, provided: bool) -> impl Iterator<Item = (&'a str, &'a str)> + use<'a> {
        let wanted = if provided { "provided" } else { "required" };
        let all = self.port.interfaces.iter();
        all.filter(move |i| {
            let direction = i.direction.as_ref().map_or("", Text::trimmed);
            direction.eq_ignore_ascii_case(wanted)
        })
        .filter_map(|i| Some((i.interface_type.as_ref()?.trimmed(), name(i))))
        .filter(|(kind, _)| !kind.is_empty())
    }
}

/// By which an interface is found: that of its instance, else its own.
fn name(interface: &ServiceInterface) -> &str {
    let instance = interface.instance_name.as_ref().map(Text::trimmed);
    let own = interface.name.as_ref().map_or("", Text::trimmed);
    instance.filter(|name| !name.is_empty()).unwrap_or(own)
}

pub(super) fn interfaces<'a>(
    against: &mut Against<'a>,
    connector: &Connector,
    source: &'a Target,
    target: &'a Target,
) {
    let (Some(a), Some(b)) = (side(against, source), side(against, target)) else {
        return;
    };
    if a.port.interfaces.is_empty() || b.port.interfaces.is_empty() {
        return;
    }
    // A connector that binds them itself says more than their names.
    let bound = connector.properties.iter().any(|property| {
        let name = property.name.as_ref().map_or("", Text::trimmed);
        name.contains(".required.")
    });
    let mut fits = 0;
    for (one, other) in [(&a, &b), (&b, &a)] {
        let provided: Vec<_> = other.interfaces(true).collect();
        for (kind, name) in one.interfaces(false) {
            let same: Vec<_> = provided.iter().filter(|(k, _)| same(k, kind)).collect();
            if same.is_empty() {
                continue;
            }
            fits += 1;
            if !bound && !same.iter().any(|(_, other)| *other == name) {
                let message = format!(
                    "`{}` requires `{kind}` of the instance `{name}`, `{}` provides it as `{}`",
                    one.path, other.path, same[0].1
                );
                let help = "OpenRTM joins interfaces of one type and instance name; give both the same name, or bind them in the connector";
                against.sink.warning(CODE, message, one.span, help);
            }
        }
    }
    if fits == 0 {
        let told = |side: &Side<'_>| {
            let of = |provided, word: &str| -> Vec<String> {
                let all = side.interfaces(provided).take(6);
                all.map(|(kind, _)| format!("{word} `{kind}`")).collect()
            };
            let mut all = of(true, "provides");
            all.extend(of(false, "requires"));
            format!("`{}` {}", side.path, all.join(", "))
        };
        let message = format!(
            "no interface that `{}` or `{}` requires is provided by the other",
            a.path, b.path
        );
        let help = format!("{}; {}", told(&a), told(&b));
        against.sink.error(CODE, message, b.span, help);
    }
}

/// A bare name leaves its module open.
fn same(a: &str, b: &str) -> bool {
    let last = |text: &str| text.rsplit(':').next().unwrap_or_default().to_owned();
    a == b || ((!a.contains(':') || !b.contains(':')) && last(a) == last(b))
}

fn side<'a>(against: &Against<'a>, target: &'a Target) -> Option<Side<'a>> {
    let (component, bare, index) = against.end(target)?;
    let port: &'a ServicePort = against.types.get(&index)?.service.get(bare)?;
    Some(Side {
        path: path(component, bare),
        span: target.port_name.as_ref().map_or(target.span, |p| p.span),
        port,
    })
}
