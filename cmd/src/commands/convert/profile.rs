//! One RTS or RTC Profile.

use std::path::Path;

use rts_schemas::diagnostic::{Finding, Report, Source};
use rts_schemas::form::{Around, Form, Format, comments};
use rts_schemas::rtc_profile::forms::WORDS as RTC_WORDS;
use rts_schemas::rts_profile::ReadProfile;
use rts_schemas::rts_profile::forms::WORDS as RTS_WORDS;
use rts_schemas::xml::Node;
use rts_schemas::{form, rtc_profile, rts_profile, yaml};

use super::{Args, Made};
use crate::error::CliError;
use crate::input;
use crate::local::plural;
use crate::output::Output;
use crate::show::findings;

/// Converts the file that is named.
pub(super) fn convert(args: &Args, out: &Output) -> Result<Made, CliError> {
    let [path] = args.files.as_slice() else {
        return Err(CliError::usage_help(
            "only rtc.conf files are converted together",
            "name one profile",
        ));
    };
    for (option, given) in [
        ("--overlay", args.overlay.is_some()),
        ("--rtc", args.rtc.is_some()),
        ("--name", args.name.is_some()),
    ] {
        if given {
            return Err(CliError::usage(format!("{option} is for rtc.conf files")));
        }
    }
    let asked = args.format();
    if asked.is_none() && args.profile_version.is_none() && args.rtc_version.is_none() {
        let help = "name a format (`--to yaml`), a version (`--profile-version 0.2`) or both";
        return Err(CliError::usage_help(
            "nothing says what to convert it to",
            help,
        ));
    }
    let bytes = input::read(path)?;
    let name = input::shown(path);
    match rts_profile::read(&name, &bytes) {
        Ok(read) => system(args, read, asked),
        Err(report) => match rtc_profile::read(&name, &bytes) {
            Ok(read) => component(args, read, asked),
            Err(_) => Err(unreadable(path, &report, out)),
        },
    }
}

fn unreadable(path: &Path, report: &Report, out: &Output) -> CliError {
    findings::print(report, out);
    CliError::NotConverted {
        files: path.display().to_string(),
        errors: plural("error", report.findings.len()),
    }
}

fn system(args: &Args, mut read: ReadProfile, asked: Option<Format>) -> Result<Made, CliError> {
    if args.rtc_version.is_some() {
        let help = "`--profile-version` is for an RTS Profile";
        return Err(CliError::usage_help(
            "this is an RTS Profile, --rtc-version is for RTC Profiles",
            help,
        ));
    }
    let format = asked.unwrap_or(read.format);
    let mut report = read.findings.clone();
    read.keep_remarks();
    let (shape, around) = match args.profile_version {
        None => (read.shape, read.around),
        Some(version) => {
            let (shape, around, lost) = rts_profile::versions::to_version(&read, version.into());
            report.extend(lost);
            (shape, around)
        }
    };
    report.findings.extend(commented(
        read.format,
        format,
        &read.source,
        shape.form(),
        &around,
    ));
    Ok(Made {
        text: form::format(shape.form(), &around, &RTS_WORDS, format),
        overlay: None,
        report,
    })
}

fn component(
    args: &Args,
    mut read: rtc_profile::ReadRtcProfile,
    asked: Option<Format>,
) -> Result<Made, CliError> {
    if args.profile_version.is_some() {
        let help = "`--rtc-version` is for an RTC Profile";
        return Err(CliError::usage_help(
            "this is an RTC Profile, --profile-version is for RTS Profiles",
            help,
        ));
    }
    let format = asked.unwrap_or(read.format);
    let mut report = read.findings.clone();
    read.keep_remarks();
    let profile = match args.rtc_version {
        None => read.profile,
        Some(version) => {
            let (profile, lost) = rtc_profile::versions::to_version(&read, version.into());
            report.extend(lost);
            profile
        }
    };
    report.findings.extend(commented(
        read.format,
        format,
        &read.source,
        &profile,
        &read.around,
    ));
    Ok(Made {
        text: form::format(&profile, &read.around, &RTC_WORDS, format),
        overlay: None,
        report,
    })
}

/// Comments are no part of YAML that is written.
fn commented(
    from: Format,
    to: Format,
    source: &Source,
    form: &dyn Form,
    around: &Around,
) -> Option<Finding> {
    if to != Format::Yaml {
        return None;
    }
    let outer = around.before.iter().chain(&around.after);
    let outer = outer.filter(|node| matches!(node, Node::Comment(_) | Node::Instruction(_)));
    let count = comments(form) + outer.count();
    let (name, help, place) = match from {
        Format::Xml => ("XML", "keep the XML too", None),
        Format::Yaml => (
            "old YAML",
            "keep the old file too, or write XML (`--to xml`), which has them",
            yaml::first_comment(source),
        ),
    };
    let have = if count == 1 { "has" } else { "have" };
    let message = format!(
        "{} of the {name} {have} no place in the YAML",
        plural("comment", count)
    );
    let finding = Finding::warning("comments-left-out", message);
    (count > 0).then(|| finding.at(place).help(help))
}
