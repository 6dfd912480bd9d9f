//! Service connectors: which required interface is bound to which provided one.

use super::Check;
use crate::rts_profile::model::{Connector, Target};
use crate::span::{Span, Text};
use crate::system::PortKind;

const CODE: &str = "service-interface-mismatch";

/// `Instance.port.PORT.required.TYPE.NAME`.
struct Descriptor<'a> {
    instance: &'a str,
    port: &'a str,
    provided: bool,
    interface: &'a str,
}

impl<'a> Descriptor<'a> {
    fn read(text: &'a str) -> Option<Self> {
        let (instance, rest) = text.trim().split_once(".port.")?;
        let provided = rest.split_once(".provided.").map(|found| (true, found));
        let required = rest.split_once(".required.").map(|found| (false, found));
        let (provided, (port, rest)) = provided.or(required)?;
        let (interface, _) = rest.rsplit_once('.')?;
        Some(Self {
            instance,
            port,
            provided,
            interface,
        })
    }
}

/// What the properties of a service connector bind to each other.
pub(super) fn bindings(check: &mut Check<'_>, connector: &Connector, owner: &str) {
    if connector.kind != PortKind::Service {
        return;
    }
    let ends: Vec<(&str, &str)> = [&connector.source, &connector.target]
        .into_iter()
        .filter_map(|end| end_of(end.as_ref()?))
        .collect();
    for property in &connector.properties {
        let Some(name) = &property.name else { continue };
        let Some(from) = Descriptor::read(&name.value) else {
            continue;
        };
        is_end(check, &from, &ends, name.span, owner);
        // Of a provided one the value is a reference, which means nothing any more.
        let Some(value) = property.value.as_ref().filter(|_| !from.provided) else {
            continue;
        };
        if let Some(to) = Descriptor::read(&value.value) {
            is_end(check, &to, &ends, value.span, owner);
            bound(check, &from, &to, value.span);
        }
    }
}

fn end_of(target: &Target) -> Option<(&str, &str)> {
    let instance = target.instance_name.as_ref().map(Text::trimmed)?;
    let port = target.port_name.as_ref().map(Text::trimmed)?;
    let bare = port
        .strip_prefix(instance)
        .and_then(|rest| rest.strip_prefix('.'));
    Some((instance, bare.unwrap_or(port)))
}

fn is_end(
    check: &mut Check<'_>,
    found: &Descriptor<'_>,
    ends: &[(&str, &str)],
    span: Span,
    owner: &str,
) {
    if ends.len() < 2 || ends.contains(&(found.instance, found.port)) {
        return;
    }
    let message = format!(
        "`{}.{}` is bound here, but {owner} does not join it",
        found.instance, found.port
    );
    let help = format!(
        "it joins `{}.{}` and `{}.{}`",
        ends[0].0, ends[0].1, ends[1].0, ends[1].1
    );
    check.warning(CODE, message, span, help);
}

fn bound(check: &mut Check<'_>, from: &Descriptor<'_>, to: &Descriptor<'_>, span: Span) {
    if !to.provided {
        let message = format!(
            "`{}.{}` requires an interface of `{}.{}`, which requires it too",
            from.instance, from.port, to.instance, to.port
        );
        let help = "bind a required interface to a provided one";
        check.warning(CODE, message, span, help);
    } else if from.interface != to.interface {
        let message = format!(
            "`{}.{}` requires `{}`, but `{}.{}` provides `{}`",
            from.instance, from.port, from.interface, to.instance, to.port, to.interface
        );
        let help = "bind interfaces of one type";
        check.warning(CODE, message, span, help);
    }
}
