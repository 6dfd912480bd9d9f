//! Profiles of any size, the same each time: as RT System Editor saves a system, a chain of components with all their
//! properties. Groups are left away: the reference library stops at them.

use std::fmt::Write;

/// Bytes that one component and its connectors take, roughly.
const COMPONENT: usize = 2_140;

/// A profile in XML of about so many bytes.
pub fn of_size(bytes: usize) -> String {
    of_components(bytes.div_ceil(COMPONENT))
}

/// A profile in XML of so many components.
pub fn of_components(count: usize) -> String {
    let mut text = String::with_capacity((count + 1) * COMPONENT);
    text.push_str(HEAD);
    for number in 0..count {
        component(number, &mut text);
    }
    for number in 1..count {
        connector(number - 1, number, &mut text);
    }
    if count > 0 {
        text.push_str("    <rts:StartUp>\n");
        for number in (0..count).step_by(10) {
            condition(number, &mut text);
        }
        text.push_str("    </rts:StartUp>\n");
    }
    text.push_str("</rts:RtsProfile>\n");
    text
}

const HEAD: &str = r#"<?xml version="1.0" encoding="UTF-8" standalone="yes"?>
<rts:RtsProfile rts:id="RTSystem:rtsctl:Generated:1.0" rts:version="0.2" rts:creationDate="2026-01-15T10:00:00" rts:updateDate="2026-01-15T10:00:00" xmlns:rts="http://www.openrtp.org/namespaces/rts" xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
    <!-- 生成されたシステム -->
"#;

/// What writing to a text cannot do is fail.
macro_rules! put {
    ($text:expr, $($words:tt)*) => {
        let _ = write!($text, $($words)*);
    };
}

fn component(number: usize, text: &mut String) {
    let instance = format!("Filter{number}");
    put!(
        text,
        r#"    <rts:Components xsi:type="rtsExt:component_ext" rts:id="RTC:rtsctl:example:Filter:1.0" rts:pathUri="localhost:2809/{instance}.rtc" rts:instanceName="{instance}" rts:compositeType="None" rts:isRequired="true" rts:activeConfigurationSet="default" rtsExt:visible="true">
"#
    );
    for (port, direction) in [("in", "DataInPort"), ("out", "DataOutPort")] {
        put!(
            text,
            r#"        <rts:DataPorts xsi:type="rtsExt:dataport_ext" rts:name="{instance}.{port}" rtsExt:visible="true">
            <rtsExt:Properties rtsExt:value="{direction}" rtsExt:name="port.port_type"/>
            <rtsExt:Properties rtsExt:value="IDL:RTC/TimedDoubleSeq:1.0" rtsExt:name="dataport.data_type"/>
        </rts:DataPorts>
"#
        );
    }
    text.push_str("        <rts:ConfigurationSets rts:id=\"default\">\n");
    for (name, value) in [("gain", "1.10"), ("offset", "0,0,0"), ("mode", "a &lt; b")] {
        put!(
            text,
            "            <rts:ConfigurationData rts:name=\"{name}\" rts:data=\"{value}\"/>\n"
        );
    }
    text.push_str("        </rts:ConfigurationSets>\n");
    put!(
        text,
        r#"        <rts:ExecutionContexts xsi:type="rtsExt:execution_context_ext" rts:id="0" rts:kind="PERIODIC" rts:rate="1000.0"/>
        <rtsExt:Location rtsExt:direction="RIGHT" rtsExt:width="-1" rtsExt:height="-1" rtsExt:y="{}" rtsExt:x="{}"/>
        <rtsExt:Properties rtsExt:value="{}" rtsExt:name="serial"/>
    </rts:Components>
"#,
        number / 100 * 60,
        number % 100 * 90,
        format!("{number:08x}").repeat(4)
    );
}

fn connector(from: usize, to: usize, text: &mut String) {
    put!(
        text,
        r#"    <rts:DataPortConnectors xsi:type="rtsExt:dataport_connector_ext" rts:connectorId="c{from}" rts:name="link{from}" rts:dataType="IDL:RTC/TimedDoubleSeq:1.0" rts:interfaceType="corba_cdr" rts:dataflowType="push" rts:subscriptionType="flush" rtsExt:visible="true">
        <rts:sourceDataPort rts:portName="Filter{from}.out" rts:instanceName="Filter{from}" rts:componentId="RTC:rtsctl:example:Filter:1.0"/>
        <rts:targetDataPort rts:portName="Filter{to}.in" rts:instanceName="Filter{to}" rts:componentId="RTC:rtsctl:example:Filter:1.0"/>
    </rts:DataPortConnectors>
"#
    );
}

fn condition(number: usize, text: &mut String) {
    put!(
        text,
        r#"        <rts:targets rts:sequence="{number}">
            <rts:TargetComponent rts:id="0" rts:instanceName="Filter{number}" rts:componentId="RTC:rtsctl:example:Filter:1.0"/>
            <rts:WaitTime rts:waitTime="0"/>
        </rts:targets>
"#
    );
}
