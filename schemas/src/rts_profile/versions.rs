//! RTS Profiles from one version of the schema to the other.
//!
//! Version 0.1 has connectors in the ports that they start from and orders in the components, its ids have dots, and it
//! knows other kinds of composite components. What it has no place for is kept in properties where that tells nobody
//! anything wrong, else taken away and named: all that does not come back from the other version is missing.

mod down;
pub(crate) mod kept;
mod ports;
mod up;

use std::collections::HashMap;

use super::ReadProfile;
use super::forms::{Profile, Shape, TargetPort, WORDS};
use super::mirror::duration;
use crate::diagnostic::{Finding, Report};
use crate::form::{Alike, Around, FieldType, FormType, Missing, What, missing};
use crate::names::{id_with_colons, id_with_dots};
use crate::span::{Span, Text};

/// A version of the schema.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Version {
    /// 0.1
    V01,
    /// 0.2
    V02,
}

impl Version {
    /// As profiles write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::V01 => "0.1",
            Self::V02 => "0.2",
        }
    }
}

/// The profile in a version. What that version cannot say is left out, and an error of the report names it.
pub fn to_version(read: &ReadProfile, version: Version) -> (Shape, Around, Report) {
    let mut report = Report::default();
    let shape = match (&read.shape, version) {
        (Shape::V01(old), Version::V02) => {
            let new = up::up(old);
            let back = down::down(&new);
            name(missing(&**old, &back, &ALIKE), read, version, &mut report);
            Shape::V02(Box::new(new))
        }
        (Shape::V02(old), Version::V01) => {
            let new = down::down(old);
            let back = up::up(&new);
            name(missing(&**old, &back, &ALIKE), read, version, &mut report);
            undotted(old, read, &mut report);
            Shape::V01(Box::new(new))
        }
        (shape, _) => {
            let mut shape = shape.clone();
            let text = Some(Text::new(version.name(), Span::default()));
            match &mut shape {
                Shape::V01(profile) => profile.version = text,
                Shape::V02(profile) => profile.version = text,
            }
            shape
        }
    };
    let mut around = read.around.clone();
    around.qname = around
        .qname
        .map(|name| name.replace("RTSystemProfile", WORDS.roots[0]).into());
    report.sort_by_place();
    (shape, around, report)
}

/// What both versions say, each in its own way.
const ALIKE: Alike<'static> = Alike {
    ignored: &[
        ("Profile", "version"),
        ("Profile", "version_up_log"),
        ("Profile", "version_up_logs"),
        ("DataPort", "port_type"),
        ("DataPort", "connectors"),
        ("ServicePort", "connectors"),
    ],
    texts: &alike,
};

fn alike(of: &FormType, field: &FieldType, old: &str, new: &str) -> bool {
    match (of.name, field.name) {
        ("Component", "composite_type") => {
            kind(new, true) != "None" && kind(old, true) == kind(new, true)
        }
        ("Profile" | "Component", "id") | (_, "component_id") => {
            id_with_colons(old) == id_with_colons(new)
        }
        ("Condition", "wait_time") => duration(old).is_some() && duration(old) == duration(new),
        ("WaitTime", "wait_time") | ("Preceding", "timeout") => {
            let number = |text: &str| text.trim().parse::<u64>().ok();
            number(old).is_some() && number(old) == number(new)
        }
        ("Preceding", "sending_timing") => old.trim().eq_ignore_ascii_case(new),
        _ => false,
    }
}

fn name(missing: Vec<Missing<'_>>, read: &ReadProfile, version: Version, report: &mut Report) {
    for missing in missing {
        let message = format!("version {} cannot say {}", version.name(), words(&missing));
        let finding = Finding::error("version-cannot-say", message).at(read.place(missing.span));
        report.push(finding.help("take it out of the profile, or leave it out with `--force`"));
    }
}

/// Says what is missing.
fn words(missing: &Missing<'_>) -> String {
    let called = |field: &FieldType| format!("`{}:{}`", WORDS.prefix(field.namespace), field.local);
    match missing.what {
        What::Value(field, Some(text)) if field.name == "composite_type" => {
            format!("the kind `{}` of a composite component", text.trimmed())
        }
        What::Value(field, Some(text)) => format!("{} `{}`", called(field), text.value),
        What::Value(field, None) if field.name.ends_with("port_connectors") => {
            "a connector that starts from no component".to_owned()
        }
        What::Value(field, None) => called(field),
        What::Order(field) => format!("the order of {}", called(field)),
        What::Attribute(name) => format!("the attribute `{name}`"),
        What::Element(name) => format!("`<{name}>`"),
        What::Key(name) => format!("the key `{name}`"),
        What::Text => "a text between elements".to_owned(),
        What::Comment => "a comment".to_owned(),
    }
}

/// An id that stays as it is, since its fields have dots of their own.
fn undotted(profile: &Profile, read: &ReadProfile, report: &mut Report) {
    let components = profile.components.iter().map(|component| &component.id);
    let ids = std::iter::once(&profile.id).chain(components).flatten();
    for id in ids.filter(|id| id_with_dots(&id.value).is_none()) {
        let message = format!(
            "version 0.1 cannot say the id `{}`, whose fields have dots of their own; it is kept as it is",
            id.value
        );
        let finding = Finding::warning("version-cannot-say", message).at(read.place(id.span));
        report.push(finding.help("other programs may not understand it in a profile of 0.1"));
    }
}

/// Kinds of composite components: in version 0.1, and since 0.2.
const COMPOSITES: [(&str, &str); 3] = [
    ("AllShared", "PeriodicStateShared"),
    ("ECShared", "PeriodicECShared"),
    ("NonShared", "Grouping"),
];

/// A kind of composite component, as the newer version names it or as the older; one that is not known there is `None`.
fn kind(text: &str, newer: bool) -> &str {
    let pair = |(old, new): &(&'static str, &'static str)| match newer {
        true => (*old, *new),
        false => (*new, *old),
    };
    let text = text.trim();
    let mut pairs = COMPOSITES.iter().map(pair);
    let found = pairs.find(|(from, to)| *from == text || *to == text);
    found.map_or("None", |(_, to)| to)
}

fn composite(text: &mut Option<Text>, newer: bool) {
    let Some(text) = text else { return };
    if !matches!(text.trimmed(), "" | "None") {
        text.value = kind(&text.value, newer).to_owned();
    }
}

/// The instance that an end names.
fn instance(end: Option<&TargetPort>) -> &str {
    end.and_then(|end| end.instance_name.as_ref())
        .map_or("", Text::trimmed)
}

/// Index of components by their names, of several the first.
fn by_name<'a>(names: impl Iterator<Item = Option<&'a Text>>) -> HashMap<String, usize> {
    let mut index = HashMap::new();
    for (at, name) in names.enumerate() {
        if let Some(name) = name {
            index.entry(name.trimmed().to_owned()).or_insert(at);
        }
    }
    index
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::Format;
    use crate::rts_profile::{LowerOptions, format, load, lower, read};

    const HELLO: &[u8] = include_bytes!("../../../manifests/hello/system.xml");

    const OLD: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<rts:RTSystemProfile rts:id="RTSystem:v.w.old:1.0" rts:version="0.1" xmlns:rts="http://www.openrtp.org/namespaces/rts"
    xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext">
    <!-- the source -->
    <rts:Component rts:id="RTC:v.w.c.A:1.0" rts:instanceName="A0" rts:pathUri="localhost/A0.rtc" rts:compositeType="ECShared" rts:isRequired="true">
        <rts:StartUp rts:sequence="2"><rts:Condition><rts:WaitTime>PT1.5S</rts:WaitTime></rts:Condition></rts:StartUp>
        <rts:Participants>
            <rts:Participant rts:instanceName="B0" rts:componentId="RTC:v.w.c.B:1.0"/>
            <rts:Participant rts:instanceName="C0" rts:componentId="RTC:v.w.c.C:1.0"/>
        </rts:Participants>
        <rts:ExecutionContexts rts:kind="PERIODIC" rts:rate="100.0"/>
        <rts:DataPorts rts:name="out">
            <rts:DataPortConnectors rts:connectorId="1" rts:name="x" rts:dataType="TimedLong" rts:interfaceType="corba_cdr" rts:dataflowType="push">
                <rts:targetDataPort rts:portName="in" rts:instanceName="B0" rts:componentId="RTC:v.w.c.B:1.0"/>
            </rts:DataPortConnectors>
        </rts:DataPorts>
        <other:thing xmlns:other="urn:x" kept="yes"/>
    </rts:Component>
    <rts:Component rts:id="RTC:v.w.c.B:1.0" rts:instanceName="B0" rts:pathUri="localhost/B0.rtc" rts:compositeType="None" rts:isRequired="true">
        <rts:StartUp rts:sequence="3"><rts:Condition><rts:Preceding><rts:PrecedingComponent rts:instanceName="A0" rts:componentId="RTC:v.w.c.A:1.0"/></rts:Preceding></rts:Condition></rts:StartUp>
        <rts:DataPorts rts:name="in"/>
    </rts:Component>
    <rts:Component rts:id="RTC:v.w.c.C:1.0" rts:instanceName="C0" rts:pathUri="localhost/C0.rtc" rts:compositeType="None" rts:isRequired="true"/>
</rts:RTSystemProfile>
"#;

    fn converted(bytes: &[u8], version: Version) -> (String, Report) {
        let profile = read("system.xml", bytes).unwrap();
        let (shape, around, report) = to_version(&profile, version);
        (format(&shape, &around, Format::Xml), report)
    }

    fn spec(text: &str) -> crate::system::SystemSpec {
        lower(
            &read("system.xml", text.as_bytes()).unwrap(),
            &LowerOptions::default(),
        )
        .0
        .unwrap()
    }

    #[test]
    fn an_old_profile_becomes_a_new_one_and_back() {
        let (new, report) = converted(OLD.as_bytes(), Version::V02);
        assert_eq!(report, Report::default());
        insta::assert_snapshot!(new);
        let mut before = spec(OLD);
        for component in &mut before.components {
            component.full_id = id_with_colons(&component.full_id);
        }
        for composite in &mut before.composites {
            composite.full_id = id_with_colons(&composite.full_id);
        }
        before.full_id = id_with_colons(&before.full_id);
        assert_eq!(spec(&new), before);
        let (old, report) = converted(new.as_bytes(), Version::V01);
        assert_eq!(report, Report::default());
        assert_eq!(spec(&old), spec(OLD));
        assert!(
            old.contains("<!-- the source -->") && old.contains("<other:thing"),
            "{old}"
        );
        let (again, _) = converted(old.as_bytes(), Version::V02);
        assert_eq!(again, new);
    }

    #[test]
    fn what_the_old_version_cannot_say_is_named() {
        let (old, report) = converted(HELLO, Version::V01);
        let said: Vec<String> = report
            .findings
            .iter()
            .map(crate::diagnostic::render)
            .collect();
        insta::assert_snapshot!(said.join("\n\n"), @r"
        error[version-cannot-say]: version 0.1 cannot say `rts:Activation`
          --> system.xml:74:5
           |
        74 |     <rts:Activation>
           |     ^^^^^^^^^^^^^^^^
           = help: take it out of the profile, or leave it out with `--force`
        ");
        let (system, _) = load("old.xml", old.as_bytes(), None, &[]).unwrap();
        let mut hello = load("system.xml", HELLO, None, &[]).unwrap().0;
        hello.orders = crate::system::Orders::default();
        for component in &mut hello.components {
            component.full_id = id_with_dots(&component.full_id).unwrap();
        }
        hello.full_id = id_with_dots(&hello.full_id).unwrap();
        assert_eq!(system, hello);
    }

    #[test]
    fn the_same_version_stays_as_it_is() {
        let profile = read("system.xml", HELLO).unwrap();
        let (shape, around, report) = to_version(&profile, Version::V02);
        assert_eq!(report, Report::default());
        let text = |shape: &Shape, around: &Around| format(shape, around, Format::Xml);
        assert_eq!(text(&shape, &around), text(&profile.shape, &profile.around));
    }
}
