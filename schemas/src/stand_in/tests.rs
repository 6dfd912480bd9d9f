use serde_json::{Value, json};

use super::{Ends, Shape};
use crate::system::{PortKind, SystemSpec};

fn system(components: &Value, connectors: &[(&str, &str, Option<&str>)]) -> SystemSpec {
    let end = |end: &str| {
        let (instance, port) = end.split_once('.').unwrap();
        json!({"instance": instance, "port": port})
    };
    let connectors: Vec<Value> = connectors
        .iter()
        .map(|(source, target, data_type)| {
            json!({
                "name": format!("{source}-{target}"), "kind": "data", "source": end(source),
                "target": end(target), "dataType": data_type, "properties": {},
            })
        })
        .collect();
    let spec = json!({"name": "s", "components": components, "connectors": connectors});
    serde_json::from_value(spec).unwrap()
}

/// The ports of a component's stand-in, one a line.
fn ports(spec: &SystemSpec, instance: &str) -> String {
    let component = spec.components.iter().find(|c| c.instance == instance);
    let shape = Shape::of(component.unwrap(), &Ends::of(spec));
    let line = |port: &crate::system::PortSpec| {
        let direction = port.direction.map_or("-".to_owned(), |d| format!("{d:?}"));
        let data_type = port.data_type.as_deref().unwrap_or("-");
        let why = shape.undetermined(&port.name).unwrap_or_default();
        let line = format!(
            "{} {:?} {direction} {data_type} {why}",
            port.name, port.kind
        );
        line.trim_end().to_owned() + "\n"
    };
    shape.ports.iter().map(line).collect()
}

#[test]
fn what_a_port_declares_goes_before_what_connectors_say() {
    let components = json!([
        {"instance": "A", "type": "A", "ports": [
            {"name": "out", "kind": "data", "direction": "out", "dataType": "T"},
            {"name": "silent", "kind": "data"},
            {"name": "alone", "kind": "data"},
            {"name": "svc", "kind": "service"},
        ]},
        {"instance": "B", "type": "B"},
    ]);
    let connectors = [
        ("A.out", "B.in", Some("U")),
        ("B.back", "A.silent", Some("V")),
    ];
    let spec = system(&components, &connectors);
    insta::assert_snapshot!(ports(&spec, "A"), @"
    out Data Out T
    silent Data In V
    alone Data - - its direction is not known
    svc Service - -
    ");
    // Ports that only connectors name are there too.
    insta::assert_snapshot!(ports(&spec, "B"), @"
    back Data Out V
    in Data In U
    ");
    let said = Ends::of(&spec).disagreements(&spec.components[0]);
    insta::assert_snapshot!(said.join("\n"), @"connector A.out-B.in says that A.out has the type U; its stand-in has T");
}

#[test]
fn a_type_that_only_the_other_end_knows_is_its_type() {
    let typed = json!([{"name": "out", "kind": "data", "direction": "out", "dataType": "T"}]);
    let components = json!([
        {"instance": "A", "type": "A", "ports": typed},
        {"instance": "B", "type": "B"},
        {"instance": "C", "type": "C"},
    ]);
    let connectors = [
        ("A.out", "B.in", None),
        ("C.out", "B.in", None),
        ("C.x", "B.y", None),
    ];
    let spec = system(&components, &connectors);
    insta::assert_snapshot!(ports(&spec, "B"), @"
    in Data In T
    y Data In - its data type is not known
    ");
}

#[test]
fn a_port_that_is_both_ends_has_no_direction() {
    let components = json!([{"instance": "A", "type": "A"}, {"instance": "B", "type": "B"}]);
    let connectors = [("A.p", "B.in", Some("T")), ("B.out", "A.p", Some("T"))];
    let spec = system(&components, &connectors);
    insta::assert_snapshot!(ports(&spec, "A"), @"p Data - T its direction is not known");
}

#[test]
fn parameters_are_those_of_all_sets_and_values_are_no_part_of_a_shape() {
    let of = |value: &str| {
        let sets = json!({"default": {"gain": value}, "fast": {"rate": "9"}});
        let components = json!([{"instance": "A", "type": "A", "configuration": {"sets": sets}}]);
        let spec = system(&components, &[]);
        Shape::of(&spec.components[0], &Ends::of(&spec))
    };
    let names: Vec<String> = of("1").parameters.into_keys().collect();
    assert_eq!(names, ["gain", "rate"]);
    assert_eq!(of("1"), of("2"));
}

#[test]
fn a_service_port_is_never_undetermined() {
    let components =
        json!([{"instance": "A", "type": "A", "ports": [{"name": "svc", "kind": "service"}]}]);
    let spec = system(&components, &[]);
    let shape = Shape::of(&spec.components[0], &Ends::of(&spec));
    assert_eq!(shape.ports[0].kind, PortKind::Service);
    assert_eq!(shape.undetermined("svc"), None);
}

#[test]
fn an_rtc_profile_goes_before_what_the_system_says() {
    let text = r#"<?xml version="1.0" encoding="UTF-8"?>
<rtc:RtcProfile rtc:id="RTC:v:c:A:1.0" rtc:version="0.2" xmlns:rtc="http://www.openrtp.org/namespaces/rtc"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
  <rtc:BasicInfo rtc:name="A" rtc:version="1.0" rtc:vendor="v" rtc:category="c" rtc:executionRate="25"/>
  <rtc:ConfigurationSet><rtc:Configuration rtc:name="gain" rtc:type="double" rtc:defaultValue="0.5"/></rtc:ConfigurationSet>
  <rtc:DataPorts rtc:name="out" rtc:portType="DataOutPort" rtc:type="RTC::TimedDouble"/>
  <rtc:DataPorts rtc:name="more" rtc:portType="DataInPort" rtc:type="RTC::TimedLong"/>
  <rtc:ServicePorts rtc:name="svc"/>
</rtc:RtcProfile>"#;
    let mut library = crate::check::Library::default();
    library.add(crate::rtc_profile::read("RTC.xml", text.as_bytes()).unwrap());
    let ports = json!([{"name": "out", "kind": "data", "direction": "in", "dataType": "U"}]);
    let components = json!([
        {"instance": "A0", "type": "A", "fullId": "RTC:v:c:A:2.0", "ports": ports},
        {"instance": "B0", "type": "B"},
    ]);
    let mut spec = system(&components, &[("A0.extra", "B0.in", Some("T"))]);
    for component in &mut spec.components {
        component.stand_in.profile = super::facts(&library, component);
    }
    insta::assert_snapshot!(self::ports(&spec, "A0"), @"
    out Data Out IDL:RTC/TimedDouble:1.0
    more Data In IDL:RTC/TimedLong:1.0
    svc Service - -
    extra Data Out T
    ");
    let shape = Shape::of(&spec.components[0], &Ends::of(&spec));
    assert_eq!(shape.rate, Some(25.0));
    assert_eq!(shape.parameters["gain"], "0.5");
    assert_eq!(spec.components[1].stand_in.profile, None);
}
