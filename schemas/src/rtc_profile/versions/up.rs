//! The names of version 0.1 → those of 0.2 and later. A profile that has none of them stays as it is.

use crate::form::each_text;
use crate::names::id_with_colons;
use crate::rtc_profile::forms::{BasicInfo, Cxx, Language, Library, RtcProfile, TargetEnvironment};
use crate::span::{Span, Text};

pub(super) fn up(profile: &mut RtcProfile) {
    each_text(
        profile,
        &mut |of, field, text| match (of.name, field.name) {
            ("RtcProfile", "id") => text.value = id_with_colons(&text.value),
            (_, "position") => text.value = text.value.to_uppercase(),
            (_, "activity_type") if text.trimmed() == "EVENT_DRIVEN" => {
                "EVENTDRIVEN".clone_into(&mut text.value);
            }
            _ => {}
        },
    );
    if let Some(info) = &mut profile.basic_info {
        basic_info(info);
    }
    for configuration in profile
        .configuration_set
        .iter_mut()
        .flat_map(|set| &mut set.configurations)
    {
        let varname = configuration.varname.take();
        renamed(
            varname,
            &mut configuration.variable_name,
            &mut configuration.xsi_type,
            "configuration_ext",
        );
    }
    for port in &mut profile.data_ports {
        let varname = port.varname.take();
        renamed(
            varname,
            &mut port.variable_name,
            &mut port.xsi_type,
            "dataport_ext",
        );
        let misspelt = port.subscriprion_type.take();
        port.subscription_type = port.subscription_type.take().or(misspelt);
    }
    for interface in profile
        .service_ports
        .iter_mut()
        .flat_map(|port| &mut port.interfaces)
    {
        let varname = interface.varname.take();
        renamed(
            varname,
            &mut interface.variable_name,
            &mut interface.xsi_type,
            "serviceinterface_ext",
        );
    }
    if let Some(language) = &mut profile.language {
        self::language(language);
    }
}

/// An attribute that became one of `rtcExt`.
fn renamed(old: Option<Text>, new: &mut Option<Text>, xsi_type: &mut Option<Text>, ext: &str) {
    if old.is_some() && new.is_none() {
        *new = old;
        *xsi_type = made(format!("rtcExt:{ext}"));
    }
}

fn basic_info(info: &mut BasicInfo) {
    let logs = std::mem::take(&mut info.version_up_log);
    info.version_up_logs.extend(logs);
    let is_type = |name: Option<&Text>| {
        name.is_some_and(|name| name.trimmed().eq_ignore_ascii_case("RTCType"))
    };
    if info.rtc_type.is_none()
        && let Some(at) = info
            .properties
            .iter()
            .position(|p| is_type(p.name.as_ref()))
    {
        info.rtc_type = info.properties.remove(at).value;
    }
}

/// The language was an element of its own name.
fn language(language: &mut Language) {
    let kinds = [
        ("C++", language.cxx.is_some()),
        ("Python", language.python.take().is_some()),
        ("Java", language.java.is_some()),
        ("C#", language.csharp.take().is_some()),
        ("Ruby", language.ruby.take().is_some()),
    ];
    if language.kind.is_none() {
        let kind = kinds.iter().find(|(_, given)| *given);
        language.kind = kind.and_then(|(kind, _)| made(*kind));
    }
    let cxx = language.cxx.take().map(|cxx| target(*cxx));
    let java = language.java.take().map(|java| {
        target(Cxx {
            libraries: java.libraries,
            ..Cxx::default()
        })
    });
    let targets: Vec<_> = cxx
        .into_iter()
        .chain(java)
        .filter(|t| *t != TargetEnvironment::default())
        .collect();
    if !targets.is_empty() {
        language.targets.extend(targets);
        language.xsi_type = made("rtcExt:language_ext");
    }
}

fn target(cxx: Cxx) -> TargetEnvironment {
    let library = |name: Text| Library {
        name: Some(name),
        ..Library::default()
    };
    TargetEnvironment {
        os: cxx.os,
        cpus: cxx.arch.into_iter().collect(),
        libraries: cxx.libraries.into_iter().map(library).collect(),
        ..TargetEnvironment::default()
    }
}

pub(super) fn made(value: impl Into<String>) -> Option<Text> {
    Some(Text::new(value, Span::default()))
}
