//! What readers accept beyond the schemas, what they say of it, and how it looks when it is written.

#![allow(clippy::unwrap_used)] // A failure here is a failed test.

use rts_schemas::diagnostic::render;
use rts_schemas::form::{Format, same};
use rts_schemas::rtc_profile::{format, read};
use rts_schemas::rts_profile::{self, forms::Shape};
use rts_schemas::span::{Span, Text};
use rts_schemas::xml::Document;

const COMPONENT: &str = include_str!("component.xml");
const TWIN: &str = include_str!("component.yaml");

fn text(value: &str) -> Option<Text> {
    Some(Text::new(value, Span::default()))
}

#[test]
fn a_component_in_yaml() {
    let read_xml = read("component.xml", COMPONENT.as_bytes()).unwrap();
    let yaml = format(&read_xml.profile, &read_xml.around, Format::Yaml);
    insta::assert_snapshot!(yaml);
}

/// Old and short keys, left-out levels, numbers for texts: all are read, and written by their usual names.
#[test]
fn yaml_as_it_is_found() {
    let found = read("component.yaml", TWIN.as_bytes()).unwrap();
    let said: Vec<String> = found.findings.findings.iter().map(render).collect();
    let xml = format(&found.profile, &found.around, Format::Xml);
    insta::assert_snapshot!(format!("{}\n\n{xml}", said.join("\n\n")));
    let info = found.profile.basic_info.as_ref().unwrap();
    assert_eq!(
        info.creation_date.as_ref().unwrap().value,
        "2026-01-15T10:00:00+09:00"
    );
    assert_eq!(info.update_date, None);
    let configuration = &found
        .profile
        .configuration_set
        .as_ref()
        .unwrap()
        .configurations[0];
    assert_eq!(configuration.default_value.as_ref().unwrap().value, "1.10");
    let unit = configuration
        .constraint
        .as_ref()
        .unwrap()
        .unit
        .as_ref()
        .unwrap();
    assert_eq!(unit.or.as_ref().unwrap().constraints.len(), 2);
}

const SYSTEM: &str = "\u{feff}<?xml version='1.0'?>\r
<!-- Made by hand. -->\r
<r:RtsProfile xmlns:r='http://www.openrtp.org/namespaces/rts' r:id='RTSystem:a:b:1' version=\"0.2\">\r
\t<r:Components r:instanceName='A0' r:id=\"RTC:v:c:A:1\"   r:pathUri = 'localhost/A0.rtc'/> <!-- the first -->\r
\t<r:Components r:instanceName='B0'\r
\t\tr:id='RTC:v:c:B:1'>\r
\t\t<r:DataPorts r:name='in'/><r:DataPorts r:name='out'/>\r
\t\t<r:Location/>\r
\t</r:Components>\r
</r:RtsProfile>";

#[test]
fn edits_look_as_their_neighbours() {
    let document = Document::open("s.xml", SYSTEM.as_bytes()).unwrap();
    let read = rts_profile::read("s.xml", SYSTEM.as_bytes()).unwrap();
    let mut new = read.shape.clone();
    let Shape::V02(profile) = &mut new else {
        panic!("{new:?}")
    };
    profile.abstract_text = text("it's \"new\"\n& good");
    profile.id = text("RTSystem:a:b:'2'");
    let first = &mut profile.components[0];
    first.instance_name = None;
    first.visible = text("true");
    let set = rts_profile::forms::ConfigurationSet {
        id: text("default"),
        ..Default::default()
    };
    first.configuration_sets.push(set);
    let second = &mut profile.components[1];
    second.data_ports.remove(0);
    second.data_ports.push(rts_profile::forms::DataPort {
        name: text("new"),
        ..Default::default()
    });
    profile
        .version_up_logs
        .push(Text::new("1 < 2", Span::default()));
    let patched = rts_profile::patch(&document, &read.shape, &new).unwrap();
    let bytes = patched.bytes().unwrap();
    assert!(bytes.starts_with(&SYSTEM.as_bytes()[..40]));
    insta::assert_snapshot!(patched.text().replace('\r', "␍").replace('\t', "→"));
    let again = rts_profile::read("s.xml", &bytes).unwrap();
    assert!(same(again.shape.form(), new.form()));
}

#[test]
fn a_form_of_another_document_is_refused() {
    let document = Document::open("s.xml", SYSTEM.as_bytes()).unwrap();
    let other = SYSTEM.replace("<r:DataPorts r:name='in'/>", "");
    let other = rts_profile::read("o.xml", other.as_bytes()).unwrap();
    let error = rts_profile::patch(&document, &other.shape, &other.shape).unwrap_err();
    insta::assert_snapshot!(error, @"the form was not read from this document: `<r:Components>` at byte 257");
}

#[test]
fn what_stands_twice_or_holds_too_much_is_told() {
    let system = SYSTEM.replace(
        "<r:Location/>",
        "<e:Location xmlns:e='http://www.openrtp.org/namespaces/rts_ext'/><e:Location xmlns:e='http://www.openrtp.org/namespaces/rts_ext'/>",
    );
    let read = rts_profile::read("s.xml", system.as_bytes()).unwrap();
    let said: Vec<String> = read.findings.findings.iter().map(render).collect();
    insta::assert_snapshot!(said.join("\n\n"));
}

/// Each thing that is read otherwise than the schema has it, or not at all, is told at its place, and kept to the letter.
#[test]
fn what_is_not_as_the_schema_has_it_is_told_and_kept() {
    let system = SYSTEM
        .replace(
            "r:pathUri = 'localhost/A0.rtc'",
            "pathUri='localhost/A0.rtc' r:visible='true' r:pathURI='b' own='1' x:own='2' xmlns:x='urn:mine' xsi:nil='false' xmlns:xsi='http://www.w3.org/2001/XMLSchema-instance'",
        )
        .replace("<r:Location/>", "a &lt; b<!-- > --> and more <r:Location/>twice: Stray\r\n text");
    let read = rts_profile::read("s.xml", system.as_bytes()).unwrap();
    let said: Vec<String> = read.findings.findings.iter().map(render).collect();
    insta::assert_snapshot!(said.join("\n\n"));
    let document = Document::open("s.xml", system.as_bytes()).unwrap();
    let same = rts_profile::patch(&document, &read.shape, &read.shape).unwrap();
    assert_eq!(same.bytes().unwrap(), system.as_bytes());
    let first = &read.profile.components[0];
    assert_eq!(first.path_uri.as_ref().unwrap().value, "localhost/A0.rtc");
}

/// `type` of a port is its data type, whatever stands before it.
#[test]
fn an_attribute_without_prefix_is_that_of_the_profile() {
    let text = COMPONENT.replace("rtc:type=", "type=");
    let (read, usual) = (
        read("c.xml", text.as_bytes()).unwrap(),
        read("c.xml", COMPONENT.as_bytes()).unwrap(),
    );
    let types = |profile: &rts_schemas::rtc_profile::forms::RtcProfile| {
        let ports = profile.data_ports.iter();
        ports
            .map(|port| port.data_type.as_ref().map(|t| t.value.clone()))
            .collect::<Vec<_>>()
    };
    assert!(types(&usual.profile).iter().any(Option::is_some));
    assert_eq!(types(&read.profile), types(&usual.profile));
}
