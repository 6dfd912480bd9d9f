//! An RTC Profile on its own: names, ports, interfaces and parameters.

mod parameters;
mod ports;
mod rule;

pub(super) use rule::rule_of;

use super::sink::{Sink, said};
use crate::diagnostic::Report;
use crate::names;
use crate::rtc_profile::ReadRtcProfile;
use crate::rtc_profile::forms::BasicInfo;
use crate::rts_profile::parse_rate;
use crate::span::{Span, Text};
use crate::suggest;

/// All problems of an RTC Profile, those of reading among them, in the order of its lines.
pub fn rtc_profile(read: &ReadRtcProfile) -> Report {
    let mut sink = Sink::new(&read.source, read.findings.clone());
    let profile = &read.profile;
    version(&mut sink, profile.version.as_ref());
    if said(&profile.id).is_none() {
        missing(
            &mut sink,
            "the id of the profile",
            profile.span,
            "write `RTC:vendor:category:type:version`",
        );
    }
    match profile.basic_info.as_deref() {
        Some(info) => basic_info(&mut sink, info, profile.id.as_ref()),
        None => missing(
            &mut sink,
            "`BasicInfo`",
            profile.span,
            "it names the component and says when it runs",
        ),
    }
    ports::ports(&mut sink, profile);
    if let Some(set) = &profile.configuration_set {
        parameters::parameters(&mut sink, set);
    }
    let mut report = sink.report;
    report.sort_by_place();
    report
}

/// Something that real profiles leave out, and editors write.
fn missing(sink: &mut Sink<'_>, what: &str, span: Span, help: &str) {
    sink.warning(
        "missing-attribute",
        format!("{what} is missing"),
        span,
        help,
    );
}

fn version(sink: &mut Sink<'_>, version: Option<&Text>) {
    let Some(version) = version else { return };
    if !matches!(version.trimmed(), "0.1" | "0.2" | "0.3" | "1.0" | "1.0.0") {
        let message = format!(
            "`{}` is not a version of the RTC Profile",
            version.trimmed()
        );
        let help = "versions: 0.1, 0.2, 0.3; what it says is read all the same";
        sink.warning("unknown-version", message, version.span, help);
    }
}

fn basic_info(sink: &mut Sink<'_>, info: &BasicInfo, id: Option<&Text>) {
    match said(&info.name) {
        None => missing(
            sink,
            "the name of the component",
            info.span,
            "add `name` to `BasicInfo`",
        ),
        Some(name) => {
            if let Some(fault) = names::name_fault(name.trimmed()) {
                let message = format!("the name of the component cannot be used: {fault}");
                let help = "names have 1 to 128 bytes, no `/` and no control character";
                sink.error("bad-name", message, name.span, help);
            }
            if let Some(id) = id.filter(|id| !id.trimmed().is_empty()) {
                same_name(sink, name, id);
            }
        }
    }
    let words: [(&Option<Text>, &str, &[&str]); 2] = [
        (
            &info.component_type,
            "component type",
            &["STATIC", "UNIQUE", "COMMUTATIVE"],
        ),
        (
            &info.activity_type,
            "activity type",
            &["PERIODIC", "SPORADIC", "EVENTDRIVEN"],
        ),
    ];
    for (text, what, known) in words {
        let Some(text) = said(text) else { continue };
        let plain = text.trimmed().replace('_', "");
        if !known.iter().any(|word| word.eq_ignore_ascii_case(&plain)) {
            let message = format!("`{}` is no known {what}", text.trimmed());
            let help = suggest::advice(text.trimmed(), "known", known);
            sink.warning("unknown-value", message, text.span, help);
        }
    }
    if let Some(rate) = said(&info.execution_rate)
        && parse_rate(&rate.value).is_none()
    {
        let message = format!("the rate `{}` is no number of hertz", rate.trimmed());
        sink.warning(
            "bad-number",
            message,
            rate.span,
            "write a number such as `1000.0`",
        );
    }
    if let Some(count) = said(&info.max_instances)
        && count.trimmed().parse::<u32>().is_err()
    {
        let message = format!("`{}` instances is no whole number", count.trimmed());
        sink.warning(
            "bad-number",
            message,
            count.span,
            "write a whole number; 0 is any number of them",
        );
    }
}

/// The id names the type too.
fn same_name(sink: &mut Sink<'_>, name: &Text, id: &Text) {
    match names::type_name(&id.value, "") {
        None => {
            let message = format!("the id `{}` does not say the type", id.trimmed());
            let help = "write `RTC:vendor:category:type:version`";
            sink.warning("bad-component-id", message, id.span, help);
        }
        Some(kind) if kind != name.trimmed() => {
            let message = format!(
                "the id names the type `{kind}`, `BasicInfo` the component `{}`",
                name.trimmed()
            );
            let help = "give both one name: components are found by it";
            sink.warning("rtc-name-mismatch", message, name.span, help);
        }
        Some(_) => {}
    }
}
