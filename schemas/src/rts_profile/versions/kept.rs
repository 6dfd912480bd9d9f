//! What version 0.1 has no attribute for, kept in properties, which its schema allows beside connectors and contexts.

use super::ports::Typed;
use crate::rts_profile::forms::Property;
use crate::span::{Span, Text};

/// How the names of these properties start.
pub(crate) const PREFIX: &str = "rtsctl.v02.";

/// The element had no `xsi:type`, which the schema wants beside properties.
const UNTYPED: &str = "untyped";

/// Keeps a value.
pub(super) fn keep(of: &mut Typed<'_>, name: &str, value: Option<Text>) {
    keep_as(
        of,
        name,
        Property {
            value,
            ..Property::default()
        },
    );
}

/// Keeps a property under another name.
pub(super) fn keep_as(of: &mut Typed<'_>, name: &str, property: Property) {
    if of.xsi_type.is_none() {
        *of.xsi_type = Some(Text::new(of.extended, Span::default()));
        keep(of, UNTYPED, None);
    }
    of.properties.push(Property {
        name: Some(Text::new(format!("{PREFIX}{name}"), Span::default())),
        ..property
    });
}

/// Takes what was kept out again, under the names without the prefix.
pub(super) fn take(of: &mut Typed<'_>) -> Vec<(String, Property)> {
    let mut kept = Vec::new();
    for property in std::mem::take(of.properties) {
        let name = property.name.as_ref();
        match name.and_then(|name| name.value.strip_prefix(PREFIX)) {
            Some(UNTYPED) => *of.xsi_type = None,
            Some(name) => kept.push((name.to_owned(), property)),
            None => of.properties.push(property),
        }
    }
    kept
}
