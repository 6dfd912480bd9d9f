//! Composite components: members that are there and in one composite only, and ports that are theirs.

use std::collections::{BTreeSet, HashMap};

use super::Check;
use super::spec::Pointed;
use crate::composite::Composites;
use crate::diagnostic::Finding;
use crate::names;
use crate::rts_profile::composite::{Named, exported, exports, kind, member_port, members};
use crate::rts_profile::model::{Component, Port};
use crate::span::{Span, Text};
use crate::suggest;
use crate::system::{CompositeSpec, PortKind, SystemSpec};

pub(super) fn composites(check: &mut Check<'_>) {
    let read = check.read;
    let all: Vec<&Component> = read.profile.components.iter().collect();
    let all: Vec<&Component> = all.into_iter().filter(|c| kind(c).is_some()).collect();
    let mut first: HashMap<String, String> = HashMap::new();
    for composite in &all {
        let owner = name(composite).to_owned();
        let own = members(composite);
        if own.is_empty() {
            let message =
                format!("composite `{owner}` has no members: there is nothing to run in it");
            let help = "list them as `Participants`, or in its parameter `members`";
            check.warning("composite-component", message, composite.span, help);
        }
        for member in &own {
            self::member(check, &owner, member);
            let before = first
                .entry(member.name.clone())
                .or_insert_with(|| owner.clone());
            if *before != owner {
                let message = format!(
                    "`{}` is a member of two composites, `{before}` and `{owner}`",
                    member.name
                );
                let help = "remove it from one of them; composites may be members of others";
                check.error("composite-member-twice", message, member.span, help);
            }
        }
        ports(check, composite, &owner);
    }
    cycles(check, &all);
}

/// The same of a system that came without its file: what must hold for any of them, each with its JSON pointer.
pub(super) fn by_pointer(spec: &SystemSpec) -> Vec<Pointed> {
    let mut found = Vec::new();
    let mut first: HashMap<&str, &str> = HashMap::new();
    let components = spec.components.iter().map(|c| c.instance.as_str());
    let own = spec.composites.iter().map(|c| c.instance.as_str());
    let known: BTreeSet<&str> = components.clone().chain(own).collect();
    let mut taken: BTreeSet<&str> = components.collect();
    let names: Vec<&str> = known.iter().copied().collect();
    for (index, composite) in spec.composites.iter().enumerate() {
        let (owner, at) = (composite.instance.as_str(), format!("/composites/{index}"));
        let mut tell = |part: &str, code: &str, message: String, help: &str| {
            let finding = Finding::error(code, message).help(help.to_owned());
            found.push((format!("{at}{part}"), finding));
        };
        if let Some(fault) = names::instance_name_problem(owner) {
            let message = format!("the instance name `{owner}` cannot be used: {fault}");
            tell("/instance", "bad-name", message, "give it another name");
        }
        if !taken.insert(owner) {
            let message = format!("two components have the instance name `{owner}`");
            tell(
                "/instance",
                "duplicate-instance",
                message,
                "give each its own name",
            );
        }
        for (number, member) in composite.members.iter().enumerate() {
            let part = format!("/members/{number}");
            if !known.contains(member.as_str()) {
                let message = format!(
                    "composite `{owner}` names the member `{member}`, which the system does not have"
                );
                let help = suggest::advice(member, "components", &names);
                tell(&part, "unknown-instance", message, &help);
            }
            let before = *first.entry(member).or_insert(owner);
            if before != owner {
                let message =
                    format!("`{member}` is a member of two composites, `{before}` and `{owner}`");
                tell(
                    &part,
                    "composite-member-twice",
                    message,
                    "remove it from one of them",
                );
            }
        }
    }
    for way in Composites::of(&spec.composites).cycles() {
        let message = format!("the composite `{}` contains itself", way[0]);
        let index = spec.composites.iter().position(|c| c.instance == way[0]);
        let help = "remove one of its members";
        let finding = Finding::error("composite-cycle", message).help(help);
        found.push((
            format!("/composites/{}", index.unwrap_or_default()),
            finding,
        ));
    }
    found
}

fn name(component: &Component) -> &str {
    component.instance_name.as_ref().map_or("", Text::trimmed)
}

fn member(check: &mut Check<'_>, owner: &str, member: &Named) {
    if check.read.component(&member.name).is_some() || check.sink.is_full() {
        return;
    }
    let message = format!(
        "composite `{owner}` names the member `{}`, which the profile does not have",
        member.name
    );
    let help = suggest::advice(&member.name, "components", &check.instances);
    check.error("unknown-instance", message, member.span, help);
}

/// Each exported port is one of a member.
fn ports(check: &mut Check<'_>, composite: &Component, owner: &str) {
    for port in exported(composite) {
        let found = member_port(check.read, composite, &port.name);
        let declared = found.as_ref().is_some_and(|(member, bare)| {
            member.ports().next().is_none() || member.port(bare).is_some()
        });
        if !declared {
            let message = format!(
                "composite `{owner}` exports `{}`, which is no port of a member of it",
                port.name
            );
            let help = "write `MEMBER.PORT`, as in `exported_ports: Motor0.in, Sensor0.out`";
            check.error("composite-port", message, port.span, help);
        }
    }
}

/// One finding for each round of composites, at the one that the file has first.
fn cycles(check: &mut Check<'_>, all: &[&Component]) {
    let specs: Vec<CompositeSpec> = all
        .iter()
        .map(|composite| CompositeSpec {
            instance: name(composite).to_owned(),
            members: members(composite).into_iter().map(|one| one.name).collect(),
            ..CompositeSpec::default()
        })
        .collect();
    let mut told: Vec<Vec<&str>> = Vec::new();
    let composites = Composites::of(&specs);
    for way in composites.cycles() {
        let mut round = way.clone();
        round.sort_unstable();
        if told.contains(&round) {
            continue;
        }
        told.push(round);
        let found = all.iter().find(|composite| name(composite) == way[0]);
        let span = found.map_or(Span::default(), |composite| composite.span);
        let message = format!(
            "the composite `{}` contains itself: {} -> {}",
            way[0],
            way.join(" -> "),
            way[0]
        );
        let help = "remove one of these from the members of the one before it";
        check.error("composite-cycle", message, span, help);
    }
}

/// The port of a member that an end of a connector at a composite means: its component, bare name, kind and declaration.
pub(super) fn end<'a>(
    check: &mut Check<'a>,
    composite: &'a Component,
    port: &Text,
) -> Option<(&'a Component, &'a str, PortKind, &'a Port)> {
    let owner = name(composite);
    let bare = composite.bare_port(&port.value);
    let found = member_port(check.read, composite, &port.value)
        .and_then(|(member, bare)| {
            let (kind, declared) = member.port(&bare)?;
            let bare = member.bare_port(&declared.name.as_ref()?.value);
            Some((member, bare, kind, declared))
        })
        .filter(|_| exports(composite, &port.value));
    if found.is_none() && !check.sink.is_full() {
        let exported: Vec<String> = exported(composite)
            .into_iter()
            .map(|one| one.name)
            .collect();
        let names: Vec<&str> = exported.iter().map(String::as_str).collect();
        let help = match names.is_empty() {
            true => "name the member itself, or list the port in `exported_ports` of the composite"
                .to_owned(),
            false => suggest::advice(bare, "exported", &names),
        };
        let message = format!("composite `{owner}` exports no port `{bare}`");
        check.error("composite-port", message, port.span, help);
    }
    found
}
