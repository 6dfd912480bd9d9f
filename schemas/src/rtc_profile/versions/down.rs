//! 0.2 → 0.1: what is left after the later fields were taken away gets its older names.

use super::Lost;
use super::up::made;
use crate::form::each_text;
use crate::names::id_with_dots;
use crate::rtc_profile::forms::{
    Action, Actions, Cxx, Java, Language, Property, RtcProfile, TargetEnvironment,
};
use crate::span::Text;

pub(super) fn down(profile: &mut RtcProfile, lost: &mut Lost<'_>) {
    if let Some(id) = &mut profile.id {
        match id_with_dots(&id.value) {
            Some(dotted) => id.value = dotted,
            None => {
                let (what, span) = (
                    format!(
                        "the id `{}`, whose fields have dots of their own,",
                        id.value
                    ),
                    id.span,
                );
                lost.say(&what, span);
            }
        }
    }
    each_text(profile, &mut |_, field, text| match field.name {
        "position" => text.value = text.value.to_lowercase(),
        "activity_type" if text.trimmed() == "EVENTDRIVEN" => {
            "EVENT_DRIVEN".clone_into(&mut text.value);
        }
        _ => {}
    });
    if let Some(info) = &mut profile.basic_info {
        info.version_up_log.append(&mut info.version_up_logs);
        if let Some(kind) = info.rtc_type.take() {
            info.properties.push(Property {
                name: made("RTCType"),
                value: Some(kind),
                ..Property::default()
            });
            info.xsi_type = made("rtcExt:basic_info_ext");
        }
    }
    actions(profile.actions.get_or_insert_default());
    for configuration in profile
        .configuration_set
        .iter_mut()
        .flat_map(|set| &mut set.configurations)
    {
        configuration.varname = configuration.variable_name.take();
        let more = !configuration.properties.is_empty();
        configuration.xsi_type = extended(more, configuration.doc.is_some(), "configuration");
    }
    for port in &mut profile.data_ports {
        port.varname = port.variable_name.take();
        port.subscriprion_type = port.subscription_type.take();
        let more = port.varname.is_some() || port.position.is_some() || !port.properties.is_empty();
        port.xsi_type = extended(more, port.doc.is_some(), "dataport");
    }
    for interface in profile
        .service_ports
        .iter_mut()
        .flat_map(|port| &mut port.interfaces)
    {
        interface.varname = interface.variable_name.take();
        let more = !interface.properties.is_empty();
        interface.xsi_type = extended(more, interface.doc.is_some(), "serviceinterface");
    }
    if let Some(language) = &mut profile.language {
        self::language(language, lost);
    }
}

/// The type of an element that has more than the basic schema says.
fn extended(more: bool, documented: bool, name: &str) -> Option<Text> {
    match (more, documented) {
        (true, _) => made(format!("rtcExt:{name}_ext")),
        (false, true) => made(format!("rtcDoc:{name}_doc")),
        (false, false) => None,
    }
}

/// Version 0.1 lists all twelve.
fn actions(actions: &mut Actions) {
    let all = [
        &mut actions.on_initialize,
        &mut actions.on_finalize,
        &mut actions.on_startup,
        &mut actions.on_shutdown,
        &mut actions.on_activated,
        &mut actions.on_deactivated,
        &mut actions.on_aborting,
        &mut actions.on_error,
        &mut actions.on_reset,
        &mut actions.on_execute,
        &mut actions.on_state_update,
        &mut actions.on_rate_changed,
    ];
    for action in all {
        action.get_or_insert_with(|| {
            Box::new(Action {
                implemented: made("false"),
                ..Action::default()
            })
        });
    }
}

fn language(language: &mut Language, lost: &mut Lost<'_>) {
    let Some(kind) = language.kind.take() else {
        return;
    };
    let mut targets = std::mem::take(&mut language.targets).into_iter();
    language.xsi_type = None;
    let empty = || Some(Text::new("", kind.span));
    match kind.trimmed() {
        "C++" => language.cxx = Some(Box::new(cxx(targets.next().unwrap_or_default(), lost))),
        "Java" => {
            let Cxx {
                os,
                arch,
                libraries,
                ..
            } = cxx(targets.next().unwrap_or_default(), lost);
            for text in os.iter().chain(&arch) {
                lost.say("the machine of a component in Java", text.span);
            }
            language.java = Some(Box::new(Java {
                libraries,
                ..Java::default()
            }));
        }
        "Python" => language.python = empty(),
        "C#" => language.csharp = empty(),
        "Ruby" => language.ruby = empty(),
        other => lost.say(&format!("the language `{other}`"), kind.span),
    }
    for target in targets {
        lost.say("a further machine", target.span);
    }
}

/// One system, one processor, and libraries by their names.
fn cxx(target: TargetEnvironment, lost: &mut Lost<'_>) -> Cxx {
    for text in [&target.lang_version, &target.other, &target.cpu_other]
        .into_iter()
        .flatten()
    {
        lost.say("this of a machine", text.span);
    }
    for text in target.os_versions.iter().chain(target.cpus.iter().skip(1)) {
        lost.say("this of a machine", text.span);
    }
    let versions = target
        .libraries
        .iter()
        .flat_map(|library| [&library.version, &library.other]);
    for text in versions.flatten() {
        lost.say("this of a library", text.span);
    }
    Cxx {
        os: target.os,
        arch: target.cpus.into_iter().next(),
        libraries: target
            .libraries
            .into_iter()
            .filter_map(|library| library.name)
            .collect(),
        ..Cxx::default()
    }
}
