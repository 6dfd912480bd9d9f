//! Composite components as a profile has them: their kinds, members and exported ports.

use super::ReadProfile;
use super::model::Component;
use crate::span::{Span, Text};
use crate::system::CompositeKind;

/// Composites within composites that a port is looked for in.
const DEPTH: usize = 16;

/// What a component shares with its members; none for one that is no composite, or of a kind that is not known.
pub(crate) fn kind(component: &Component) -> Option<CompositeKind> {
    CompositeKind::of(component.composite_type.as_ref()?.trimmed())
}

/// A name in a profile, and where it stands.
#[derive(Debug, Clone)]
pub(crate) struct Named {
    pub name: String,
    pub span: Span,
}

/// The members of a composite: its participants, else those that its parameter `members` lists.
pub(crate) fn members(component: &Component) -> Vec<Named> {
    let participants = component.participants.iter();
    let named: Vec<Named> = participants
        .filter_map(|target| target.instance_name.as_ref())
        .map(|name| Named {
            name: name.trimmed().to_owned(),
            span: name.span,
        })
        .collect();
    match named.is_empty() {
        true => listed(component, "members"),
        false => named,
    }
}

/// The ports of members that it exports, as `Instance.port`.
pub(crate) fn exported(component: &Component) -> Vec<Named> {
    listed(component, "exported_ports")
}

/// The parts of a parameter that is a list; of the active set, else of `default`, else of any.
fn listed(component: &Component, parameter: &str) -> Vec<Named> {
    let active = component.active_configuration_set.as_ref();
    let active = active.map_or("default", Text::trimmed);
    let sets = component.configuration_sets.iter();
    let found = sets.filter_map(|set| {
        let id = set.id.as_ref().map_or("", |id| id.trimmed());
        let value = set.data.iter().find(|one| {
            let name = one.name.as_ref().map_or("", |name| name.trimmed());
            name == parameter
        });
        let rank = [active, "default"].iter().position(|name| *name == id);
        Some((rank.unwrap_or(2), value?.value.as_ref()?))
    });
    let Some((_, text)) = found.min_by_key(|(rank, _)| *rank) else {
        return Vec::new();
    };
    let parts = text.value.split(',').map(str::trim);
    parts
        .filter(|part| !part.is_empty())
        .map(|part| Named {
            name: part.to_owned(),
            span: text.span,
        })
        .collect()
}

/// The component and the bare port that a port of a composite is: `Motor0.in`, or `in` where only one exported port is
/// called so.
pub(crate) fn member_port<'a>(
    read: &'a ReadProfile,
    composite: &'a Component,
    port: &str,
) -> Option<(&'a Component, String)> {
    let mut composite = composite;
    let mut port = composite.bare_port(port).to_owned();
    for _ in 0..DEPTH {
        let (member, bare) = of_member(read, composite, &port)?;
        if kind(member).is_none() {
            return Some((member, bare));
        }
        (composite, port) = (member, bare);
    }
    None
}

fn of_member<'a>(
    read: &'a ReadProfile,
    composite: &Component,
    port: &str,
) -> Option<(&'a Component, String)> {
    let own = members(composite);
    let find = |port: &str| {
        let mut members = own.iter();
        members.find_map(|member| {
            let bare = port.strip_prefix(&member.name)?.strip_prefix('.')?;
            Some((read.component(&member.name)?, bare.to_owned()))
        })
    };
    find(port).or_else(|| {
        let exported = exported(composite);
        let mut called = exported.iter().filter(|one| {
            let bare = one.name.rsplit_once('.').map(|(_, bare)| bare);
            bare == Some(port)
        });
        match (called.next(), called.next()) {
            (Some(only), None) => find(&only.name),
            _ => None,
        }
    })
}

/// Whether a composite exports a port that was said of it.
pub(crate) fn exports(composite: &Component, port: &str) -> bool {
    let port = composite.bare_port(port);
    exported(composite).iter().any(|one| {
        let bare = one.name.rsplit_once('.').map(|(_, bare)| bare);
        one.name == port || bare == Some(port)
    })
}
