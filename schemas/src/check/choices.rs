//! How samples travel: what a connector chooses is among what both of its ports offer.

use super::Check;
use super::connector::End;
use crate::rts_profile::CHOICES;
use crate::rts_profile::model::{Connector, Port, property_value};
use crate::span::{Span, Text};
use crate::suggest;
use crate::system::PortKind;

/// The code and the words of each of the three choices, in their order.
const WORDS: [(&str, &str); 3] = [
    ("incompatible-interface-type", "interface type"),
    ("incompatible-dataflow-type", "dataflow type"),
    ("incompatible-subscription-type", "subscription type"),
];

/// Interface types that are known, in any case.
const INTERFACES: [&str; 15] = [
    "corba_cdr",
    "corba_any",
    "direct",
    "inproc",
    "shared_memory",
    "shm",
    "uds",
    "tcp",
    "data_service",
    "csp_channel",
    "tcp_any",
    "ros",
    "ros2",
    "opensplice",
    "fast-rtps",
];

/// Says where an interface type is none of those that are known, nor one that a port of the connector offers: it is
/// passed on, and means the best that reaches here.
pub(super) fn known(
    check: &mut Check<'_>,
    connector: &Connector,
    owner: &str,
    ends: [Option<End<'_>>; 2],
) {
    if connector.kind != PortKind::Data {
        return;
    }
    let property = property_value(&connector.properties, CHOICES[0]);
    let attribute = connector.interface_type.as_ref();
    let said = [
        attribute.map(|text| ("interfaceType", text)),
        property.map(|text| (CHOICES[0], text)),
    ];
    for (what, text) in said.into_iter().flatten() {
        let value = text.trimmed();
        let is_known = INTERFACES.iter().any(|k| k.eq_ignore_ascii_case(value));
        let mut ends = ends.iter().flatten();
        if value.is_empty() || is_known || ends.any(|end| offers(end.port, CHOICES[0], value)) {
            continue;
        }
        let message = format!(
            "`{value}` is no known {what} of {owner}; it is passed on as it is, and may mean nothing"
        );
        let help = suggest::advice(value, "known", &INTERFACES);
        check.warning("unknown-value", message, text.span, help);
    }
}

/// One end as it is told, and what it offers; `None` where nothing is said.
pub(super) struct Offer<'a> {
    pub(super) path: String,
    pub(super) types: [Option<&'a str>; 3],
}

pub(super) fn choices(check: &mut Check<'_>, connector: &Connector, ends: [End<'_>; 2]) {
    if connector.kind != PortKind::Data {
        return;
    }
    let offers = ends.map(|end| Offer {
        path: end.path(),
        types: CHOICES.map(|name| {
            let text = property_value(&end.port.properties, name)?;
            Some(text.trimmed())
        }),
    });
    compare(connector, &offers, |code, message, span, help| {
        check.warning(code, message, span, help);
    });
}

/// True when a port names a value among those that it offers of a choice.
fn offers(port: &Port, choice: &str, value: &str) -> bool {
    property_value(&port.properties, choice).is_some_and(|list| has(&list.value, value))
}

/// Compares a connector's choices with what its ends offer.
pub(super) fn compare(
    connector: &Connector,
    offers: &[Offer<'_>],
    mut say: impl FnMut(&'static str, String, Span, String),
) {
    for (at, (code, what)) in WORDS.into_iter().enumerate() {
        let offered = offers
            .iter()
            .filter_map(|offer| Some((offer, offer.types[at]?)));
        let offered: Vec<_> = offered.filter(|(_, list)| !is_open(list)).collect();
        if let Some(chosen) = chosen(connector, at) {
            let refused = offered
                .iter()
                .find(|(_, list)| !has(list, chosen.trimmed()));
            if let Some((offer, list)) = refused {
                let message = format!(
                    "the {what} `{}` is none that `{}` offers",
                    chosen.trimmed(),
                    offer.path
                );
                say(
                    code,
                    message,
                    chosen.span,
                    format!("it offers: {}", list.trim()),
                );
            }
        } else if let [(one, list), (other, others)] = offered.as_slice()
            && !items(list).any(|item| has(others, item))
        {
            let message = format!("`{}` and `{}` share no {what}", one.path, other.path);
            let help = format!("they offer: {}; {}", list.trim(), others.trim());
            say(code, message, connector.span, help);
        }
    }
}

/// What a connector says; the property wins over the attribute.
fn chosen(connector: &Connector, at: usize) -> Option<&Text> {
    let attribute = match at {
        0 => &connector.interface_type,
        1 => &connector.dataflow_type,
        _ => &connector.subscription_type,
    };
    property_value(&connector.properties, CHOICES[at])
        .or(attribute.as_ref())
        .filter(|text| !text.trimmed().is_empty())
}

fn items(list: &str) -> impl Iterator<Item = &str> {
    list.split(',')
        .map(str::trim)
        .filter(|item| !item.is_empty())
}

/// Anything goes, or nothing is said.
fn is_open(list: &str) -> bool {
    let mut all = items(list).peekable();
    all.peek().is_none() || all.any(|item| item.eq_ignore_ascii_case("any"))
}

/// As OpenRTM compares: without regard to capital letters. A kind with a variant (`new.fifo`) is one of its kind.
fn has(list: &str, chosen: &str) -> bool {
    items(list).any(|item| item.eq_ignore_ascii_case(chosen))
}
