//! RTS Profiles from one version of the schema to the other.
//!
//! Version 0.1 has connectors in the ports that they start from and orders in the components, its ids have dots, and it
//! knows other kinds of composite components. What it has no place for is taken away and named.

mod down;
mod up;

use std::collections::HashMap;

use super::ReadProfile;
use super::forms::{Shape, TargetPort, WORDS};
use crate::diagnostic::{Finding, Report};
use crate::form::{Around, Taken};
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
    let mut lost = Lost {
        read,
        version,
        report: Report::default(),
    };
    let shape = match (&read.shape, version) {
        (Shape::V01(old), Version::V02) => Shape::V02(Box::new(up::up(old, &mut lost))),
        (Shape::V02(old), Version::V01) => Shape::V01(Box::new(down::down(old, &mut lost))),
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
    lost.report.sort_by_place();
    (shape, around, lost.report)
}

/// What gets lost.
struct Lost<'a> {
    read: &'a ReadProfile,
    version: Version,
    report: Report,
}

impl Lost<'_> {
    fn say(&mut self, what: &str, span: Span) {
        let message = format!("version {} cannot say {what}", self.version.name());
        let finding = Finding::error("version-cannot-say", message).at(self.read.place(span));
        self.report
            .push(finding.help("take it out of the profile, or leave it out with `--force`"));
    }

    fn taken(&mut self, all: Vec<Taken>) {
        for taken in all {
            let prefix = WORDS.prefix(taken.field.namespace);
            self.say(&format!("`{prefix}:{}`", taken.field.local), taken.span);
        }
    }
}

/// Kinds of composite components: in version 0.1, and since 0.2.
const COMPOSITES: [(&str, &str); 3] = [
    ("AllShared", "PeriodicStateShared"),
    ("ECShared", "PeriodicECShared"),
    ("NonShared", "Grouping"),
];

/// Changes a kind of composite component; one that the other version does not know becomes `None`.
fn composite(text: &mut Option<Text>, lost: &mut Lost<'_>) {
    let Some(text) = text else { return };
    let pair = |(old, new): &(&'static str, &'static str)| match lost.version {
        Version::V01 => (*new, *old),
        Version::V02 => (*old, *new),
    };
    let kind = text.trimmed();
    let found = COMPOSITES.iter().map(pair).find(|(from, _)| *from == kind);
    let known = |of: &str| COMPOSITES.iter().any(|(old, new)| of == *old || of == *new);
    match found {
        Some((_, to)) => to.clone_into(&mut text.value),
        None if kind.is_empty() || kind == "None" || known(kind) => {}
        None => {
            lost.say(
                &format!("the kind `{kind}` of a composite component"),
                text.span,
            );
            "None".clone_into(&mut text.value);
        }
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
            component.full_id = crate::names::id_with_colons(&component.full_id);
        }
        before.full_id = crate::names::id_with_colons(&before.full_id);
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
            component.full_id = crate::names::id_with_dots(&component.full_id).unwrap();
        }
        hello.full_id = crate::names::id_with_dots(&hello.full_id).unwrap();
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
