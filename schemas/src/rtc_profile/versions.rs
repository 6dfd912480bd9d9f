//! RTC Profiles from one version of the schema to another. What a version has no place for is taken away and named.

mod down;
mod up;

use super::ReadRtcProfile;
use super::forms::{RtcProfile, WORDS};
use crate::diagnostic::{Finding, Report};
use crate::form::take_fields;
use crate::span::{Span, Text};

/// A version of the schema.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Version {
    /// 0.1
    V01,
    /// 0.2
    V02,
    /// 0.3
    V03,
}

impl Version {
    /// As profiles write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::V01 => "0.1",
            Self::V02 => "0.2",
            Self::V03 => "0.3",
        }
    }

    /// Fields (of a type) that the version does not have.
    fn lacks(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::V01 => &[
                ("Actions", "on_action"),
                ("Actions", "on_mode_changed"),
                ("BasicInfo", "hardware_profile"),
                ("BasicInfo", "comment"),
                ("BasicInfo", "save_project"),
                ("Configuration", "unit"),
                ("Configuration", "constraint"),
                ("Configuration", "comment"),
                ("DataPort", "unit"),
                ("DataPort", "constraint"),
                ("DataPort", "comment"),
                ("DataPort", "events"),
                ("ServicePort", "trans_methods"),
                ("ServicePort", "comment"),
                ("ServiceInterface", "comment"),
                ("Language", "properties"),
            ],
            Self::V02 => &[("DataPort", "events"), ("Language", "properties")],
            Self::V03 => &[("RtcProfile", "parameters"), ("ServiceInterface", "path")],
        }
    }
}

/// The profile in a version. What that version cannot say is left out, and an error of the report names it.
pub fn to_version(read: &ReadRtcProfile, version: Version) -> (RtcProfile, Report) {
    let mut lost = Lost {
        read,
        version,
        report: Report::default(),
    };
    let mut profile = read.profile.clone();
    up::up(&mut profile);
    let mut taken = Vec::new();
    take_fields(&mut profile, version.lacks(), &mut taken);
    for taken in taken {
        let prefix = WORDS.prefix(taken.field.namespace);
        lost.say(&format!("`{prefix}:{}`", taken.field.local), taken.span);
    }
    if version != Version::V03 {
        event_ports(&mut profile, &mut lost);
    }
    if version == Version::V01 {
        down::down(&mut profile, &mut lost);
    }
    profile.version = Some(Text::new(version.name(), Span::default()));
    lost.report.sort_by_place();
    (profile, lost.report)
}

/// What gets lost.
struct Lost<'a> {
    read: &'a ReadRtcProfile,
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
}

/// Event ports are data ports of version 0.3.
fn event_ports(profile: &mut RtcProfile, lost: &mut Lost<'_>) {
    profile.data_ports.retain(|port| {
        let kind = port
            .port_type
            .as_ref()
            .filter(|kind| kind.trimmed() == "EventPort");
        if let Some(kind) = kind {
            lost.say("an event port", kind.span);
        }
        kind.is_none()
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::Format;
    use crate::rtc_profile::{format, read};

    const OLD: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<rtc:RtcProfile rtc:version="0.1" rtc:id="RTC:Vendor.Category.Name:1.0.0" xmlns:rtc="http://www.openrtp.org/namespaces/rtc"
    xmlns:rtcExt="http://www.openrtp.org/namespaces/rtc_ext" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
    <rtc:BasicInfo xsi:type="rtcExt:basic_info_ext" rtc:name="Name" rtc:activityType="EVENT_DRIVEN" rtc:vendor="Vendor">
        <rtcExt:VersionUpLog>first</rtcExt:VersionUpLog>
        <rtcExt:Properties rtcExt:name="RTCType" rtcExt:value="own"/>
    </rtc:BasicInfo>
    <rtc:ConfigurationSet>
        <rtc:Configuration rtc:name="gain" rtc:type="int" rtc:defaultValue="1" rtc:varname="m_gain"/>
    </rtc:ConfigurationSet>
    <rtc:DataPorts xsi:type="rtcExt:dataport_ext" rtc:portType="DataInPort" rtc:name="in" rtc:type="TimedLong" rtc:subscriprionType="Flush"
        rtcExt:position="left" rtcExt:varname="m_in"/>
    <rtc:ServicePorts rtc:name="svc">
        <rtc:ServiceInterface rtc:name="if" rtc:direction="Provided" rtc:varname="m_if" rtc:path="idl"/>
    </rtc:ServicePorts>
    <rtc:Parameters rtc:name="p" rtc:defaultValue="1"/>
    <rtc:Language><rtc:Cxx rtc:os="Linux" rtc:arch="i386"><rtc:library>m</rtc:library></rtc:Cxx></rtc:Language>
</rtc:RtcProfile>
"#;

    fn converted(text: &str, version: Version) -> (String, Report) {
        let profile = read("RTC.xml", text.as_bytes()).unwrap();
        let (new, report) = to_version(&profile, version);
        (format(&new, &profile.around, Format::Xml), report)
    }

    #[test]
    fn an_old_profile_becomes_a_new_one_and_back() {
        let (new, report) = converted(OLD, Version::V02);
        assert_eq!(report, Report::default());
        insta::assert_snapshot!(new);
        let (again, report) = converted(&new, Version::V02);
        assert_eq!((again, report), (new.clone(), Report::default()));
        let (old, report) = converted(&new, Version::V01);
        assert_eq!(report, Report::default());
        // Version 0.1 lists every action.
        insta::assert_snapshot!("back_in_version_0_1", old);
        let (newest, report) = converted(&new, Version::V03);
        let said: Vec<&str> = report.findings.iter().map(|f| f.message.as_str()).collect();
        assert_eq!(
            said,
            [
                "version 0.3 cannot say `rtc:path`",
                "version 0.3 cannot say `rtc:Parameters`"
            ]
        );
        assert!(
            !newest.contains("Parameters") && newest.contains(r#"rtc:version="0.3""#),
            "{newest}"
        );
    }

    #[test]
    fn what_is_newer_is_named() {
        let text = r#"<rtc:RtcProfile rtc:version="0.3" rtc:id="RTC:a:b.c:d:1" xmlns:rtc="http://www.openrtp.org/namespaces/rtc">
  <rtc:Actions><rtc:OnAction rtc:implemented="true"/></rtc:Actions>
  <rtc:DataPorts rtc:portType="EventPort" rtc:name="e"><rtc:Event rtc:name="x" rtc:source="a" rtc:target="b"/></rtc:DataPorts>
  <rtc:DataPorts rtc:portType="DataInPort" rtc:name="in" rtc:unit="m"/>
  <rtc:Language rtc:kind="Lua"/>
</rtc:RtcProfile>"#;
        let said = |version| {
            let (_, report) = converted(text, version);
            let said = report
                .findings
                .iter()
                .map(|f| (f.message.clone(), f.place.as_ref().unwrap().line));
            said.collect::<Vec<_>>()
        };
        assert!(said(Version::V03).is_empty());
        let named = |version: &str, what: &str, line| {
            (format!("version {version} cannot say {what}"), line)
        };
        assert_eq!(
            said(Version::V02),
            [
                named("0.2", "an event port", 3),
                named("0.2", "`rtc:Event`", 3)
            ]
        );
        assert_eq!(
            said(Version::V01),
            [
                named(
                    "0.1",
                    "the id `RTC:a:b.c:d:1`, whose fields have dots of their own,",
                    1
                ),
                named("0.1", "`rtc:OnAction`", 2),
                named("0.1", "an event port", 3),
                named("0.1", "`rtc:Event`", 3),
                named("0.1", "`rtc:unit`", 4),
                named("0.1", "the language `Lua`", 5)
            ]
        );
    }
}
