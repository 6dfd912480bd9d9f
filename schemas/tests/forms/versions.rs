//! The law of versions: what a profile loses on the way to version 0.1 and back is what was named, and nothing else.

use std::collections::BTreeSet;

use rts_schemas::diagnostic::Severity;
use rts_schemas::form::{
    Alike, Form, Format, Missing, Slot, Stray, What, comments, each_text, missing, same,
    strip_places,
};
use rts_schemas::names::id_with_colons;
use rts_schemas::rts_profile::forms::{Profile, Shape};
use rts_schemas::rts_profile::versions::{Version, to_version};
use rts_schemas::rts_profile::{ReadProfile, format, read};
use rts_schemas::span::{Span, Text};

use super::{Tape, fill};

/// Line and column of what was named, and whether it is a value.
type Named = BTreeSet<(usize, usize, bool)>;

/// Checks the law for a profile of version 0.2; gives the names of what is lost.
pub fn only_what_is_named_is_lost(file: &str, bytes: &[u8]) -> Vec<String> {
    let Ok(there) = read(file, bytes) else {
        return Vec::new();
    };
    let Shape::V02(profile) = &there.shape else {
        return Vec::new();
    };
    // Several members in one element become several elements, which are not told from each other here.
    let mut components = profile.components.iter();
    if components.any(|c| c.participants.iter().any(|p| p.participant.len() != 1)) {
        return Vec::new();
    }
    let (old, around, report) = to_version(&there, Version::V01);
    let errors = report.findings.iter();
    let errors: Vec<_> = errors.filter(|f| f.severity == Severity::Error).collect();
    let messages: Vec<String> = errors.iter().map(|f| f.message.clone()).collect();
    if messages
        .iter()
        .any(|message| message.contains("the order of"))
    {
        return messages;
    }
    let place = |f: &&rts_schemas::diagnostic::Finding| {
        let place = f.place.as_ref().unwrap_or_else(|| panic!("{f:?}"));
        // An empty value stands where its element does.
        let values = ["` `", "the kind `", "the attribute `"];
        let value = values.iter().any(|said| f.message.contains(said));
        (place.line, place.column, value)
    };
    // A text and a comment have no place of their own, but that of what they stand in.
    let inside = |message: &str| message.ends_with("elements") || message.ends_with("a comment");
    let named = errors.iter().filter(|f| !inside(&f.message));
    let named: Named = named.map(place).collect();
    let old = format(&old, &around, Format::Xml);
    let old_read = read("old.xml", old.as_bytes()).unwrap();
    assert!(matches!(old_read.shape, Shape::V01(_)), "{file}:\n{old}");
    let (mut back, _, report) = to_version(&old_read, Version::V02);
    assert!(!report.has_errors(), "{file}: {report:?}\n{old}");
    let mut expected = there.shape.clone();
    if messages.is_empty() {
        let count = |shape: &Shape| comments(shape.form());
        assert_eq!(count(&expected), count(&back), "{file}:\n{old}");
    }
    alike(expected.form_mut());
    alike(back.form_mut());
    erase(expected.form_mut(), back.form_mut(), &there, &named);
    if !same(expected.form(), back.form()) {
        strip_places(expected.form_mut());
        strip_places(back.form_mut());
        let (ours, theirs) = (expected.form(), back.form());
        let told = |all: Vec<Missing<'_>>| -> Vec<String> {
            let one = |m: &Missing<'_>| match m.what {
                What::Value(field, text) => format!("{}.{} {text:?}", m.of.name, field.name),
                other => format!("{} {other:?}", m.of.name),
            };
            all.iter().map(one).collect()
        };
        let lost = told(missing(ours, theirs, &EXACT));
        let added = told(missing(theirs, ours, &EXACT));
        panic!("{file}: named {messages:?}, but lost {lost:#?}, added {added:#?}\n{old}");
    }
    messages
}

const EXACT: Alike<'static> = Alike {
    ignored: &[],
    texts: &|_, _, _, _| false,
};

/// What both versions say, each in its own way, as one of them.
fn alike(form: &mut dyn Form) {
    each_text(form, &mut |of, field, text| match (of.name, field.name) {
        ("Profile", "version") => text.value = "0.2".to_owned(),
        ("Component", "composite_type") => {
            for (old, new) in [
                ("AllShared", "PeriodicStateShared"),
                ("ECShared", "PeriodicECShared"),
                ("NonShared", "Grouping"),
            ] {
                if text.trimmed() == old || text.trimmed() == new {
                    text.value = new.to_owned();
                }
            }
        }
        ("Profile" | "Component", "id") | (_, "component_id") => {
            text.value = id_with_colons(&text.value);
        }
        ("WaitTime", "wait_time") | ("Preceding", "timeout") => {
            if let Ok(number) = text.trimmed().parse::<u64>() {
                text.value = number.to_string();
            }
        }
        ("Preceding", "sending_timing") if text.trimmed().eq_ignore_ascii_case("sync") => {
            text.value = "SYNC".to_owned();
        }
        _ => {}
    });
}

/// Values that version 0.2 has and 0.1 has not: they come back as what they are without a word.
const ADDED: [(&str, &str); 6] = [
    ("TargetExecutionContext", "instance_name"),
    ("Condition", "sequence"),
    ("TargetExecutionContext", "component_id"),
    ("TargetExecutionContext", "id"),
    ("Preceding", "sending_timing"),
    ("Preceding", "timeout"),
];

/// Takes what was named out of the profile that was read, and what is in its place out of the other.
fn erase(form: &mut dyn Form, back: &mut dyn Form, read: &ReadProfile, named: &Named) {
    let among = |span: Span, value: bool| {
        let place = read.place(span);
        place.is_some_and(|place| named.contains(&(place.line, place.column, value)))
    };
    let is_named = |span: Span| among(span, false);
    let of = form.form_type();
    if !form.extra().is_empty() {
        let beside = form.extra_mut().edit();
        beside
            .attributes
            .retain(|attribute| !among(attribute.span, true));
        beside.keys.retain(|(key, _)| !is_named(key.span));
        beside.strays.retain(|stray| match stray {
            Stray::Element(element) => !is_named(element.span),
            // Two become one where nothing is left between them.
            Stray::Text(_) => false,
            _ => true,
        });
    }
    if !back.extra().is_empty() {
        let strays = &mut back.extra_mut().edit().strays;
        strays.retain(|stray| !matches!(stray, Stray::Text(_)));
    }
    for (at, field) in of.fields.iter().enumerate() {
        match (form.slot(at), back.slot(at)) {
            (Some(Slot::Text(text)), Some(Slot::Text(other))) => {
                let added = text.is_none() && ADDED.contains(&(of.name, field.name));
                if added || text.as_ref().is_some_and(|text| among(text.span, true)) {
                    (*text, *other) = (None, None);
                }
            }
            (Some(Slot::Texts(texts)), _) => texts.retain(|text| !among(text.span, true)),
            (Some(Slot::Forms(forms)), Some(Slot::Forms(others))) => {
                for index in (0..forms.count()).rev() {
                    if forms.form(index).is_some_and(|form| is_named(form.span())) {
                        forms.remove(index);
                    }
                }
                for index in 0..forms.count() {
                    if let (Some(form), Some(other)) =
                        (forms.form_mut(index), others.form_mut(index))
                    {
                        erase(form, other, read, named);
                    }
                }
            }
            _ => {}
        }
    }
}

/// A profile of version 0.2 by chance, most of whose connectors and conditions belong to its components.
pub fn connected(tape: &[u8]) -> Profile {
    let mut tape = Tape::new(tape);
    let mut profile = Profile::default();
    fill(&mut profile, &mut tape, 4);
    profile.version = Some(Text::new("0.2", Span::default()));
    // Version 0.2 has one of them, and neither connectors nor directions in its ports.
    profile.start_up.truncate(1);
    let mut names = Vec::new();
    for component in &mut profile.components {
        names.extend(component.instance_name.clone());
        for port in &mut component.data_ports {
            port.connectors.clear();
            port.port_type = None;
        }
        for port in &mut component.service_ports {
            port.connectors.clear();
        }
        // Each member has an element of its own, and is in it.
        for member in &mut component.participants {
            (member.component_id, member.instance_name) = (None, None);
            member.participant.resize_with(1, Default::default);
        }
    }
    if names.is_empty() {
        return profile;
    }
    let mut known = |name: &mut Option<Text>| {
        if tape.choose(8) < 7 {
            *name = Some(names[tape.choose(names.len())].clone());
        }
    };
    for connector in &mut profile.data_port_connectors {
        known(&mut connector.source.get_or_insert_default().instance_name);
    }
    for connector in &mut profile.service_port_connectors {
        known(&mut connector.source.get_or_insert_default().instance_name);
    }
    for order in &mut profile.start_up {
        for condition in &mut order.targets {
            known(
                &mut condition
                    .target_component
                    .get_or_insert_default()
                    .instance_name,
            );
        }
    }
    profile
}
