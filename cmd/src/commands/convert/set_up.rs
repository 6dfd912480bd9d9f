//! `rtc.conf` files of one system.

use std::io::Read;
use std::path::{Path, PathBuf};

use jiff::Timestamp;
use rts_schemas::diagnostic::Report;
use rts_schemas::form::Format;
use rts_schemas::names;
use rts_schemas::rtc_conf::{self, Options, SIZE_LIMIT, Sources};
use rts_schemas::rtc_profile::forms::RtcProfile;

use super::{Args, Made, is_conf};
use crate::error::CliError;
use crate::input;
use crate::library;
use crate::output::Output;

/// Converts them into one system.
pub(super) fn convert(args: &Args, out: &Output) -> Result<Made, CliError> {
    if let Some(other) = args.files.iter().find(|file| !is_conf(file)) {
        let message = format!(
            "{} is no rtc.conf, and is not converted together with one",
            other.display()
        );
        return Err(CliError::usage(message));
    }
    if args.rtc_version.is_some() || args.profile_version == Some(super::RtsVersion::V01) {
        let help = "write the profile, then convert it";
        return Err(CliError::usage_help(
            "rtc.conf files become an RTS Profile 0.2",
            help,
        ));
    }
    if args
        .overlay
        .as_ref()
        .is_some_and(|overlay| *overlay == args.out)
    {
        return Err(CliError::usage("--out and --overlay name the same file"));
    }
    if let Some(name) = args.name.as_ref().filter(|name| !names::is_dns_label(name)) {
        let help = "a name has 1 to 63 of `a-z`, `0-9` and `-`";
        return Err(CliError::usage_help(
            format!("`{name}` cannot name a system"),
            help,
        ));
    }
    let mut files = Vec::with_capacity(args.files.len());
    for path in &args.files {
        files.push((input::shown(path), input::read(path)?));
    }
    let named: Vec<(&str, &[u8])> = files
        .iter()
        .map(|(name, bytes)| (name.as_str(), bytes.as_slice()))
        .collect();
    let mut report = Report::default();
    let types = types(args.rtc.as_slice(), &mut report, out)?;
    let setup = rtc_conf::load(&named, &Disk, &mut report);
    let name = args
        .name
        .clone()
        .or_else(|| default_name(args.files.first()?));
    let created = Timestamp::now().strftime("%Y-%m-%dT%H:%M:%S").to_string();
    let made = rtc_conf::convert(
        &setup,
        &Options {
            name: name.as_deref(),
            created: &created,
            types: &types,
            managers_inside: args.overlay.is_none(),
        },
    );
    report.extend(made.report.clone());
    Ok(Made {
        text: made.text(args.format().unwrap_or(Format::Xml)),
        overlay: Some(made.overlay),
        report,
    })
}

/// The name of the folder, if the file's own says nothing.
fn default_name(path: &Path) -> Option<String> {
    let whole = path.canonicalize().ok()?;
    rtc_conf::system_name(whole.to_str()?)
}

/// Files that an rtc.conf names.
struct Disk;

impl Sources for Disk {
    fn read(&self, path: &str) -> Result<Option<Vec<u8>>, String> {
        let Ok(found) = std::fs::metadata(path) else {
            return Ok(None);
        };
        // What is no file (a pipe, a device) may have no end.
        if !found.is_file() {
            return Ok(None);
        }
        let mut bytes = Vec::new();
        let read = std::fs::File::open(path);
        let read = read.and_then(|file| file.take(SIZE_LIMIT as u64 + 1).read_to_end(&mut bytes));
        read.map_err(|error| error.to_string())?;
        Ok(Some(bytes))
    }
}

/// The RTC Profiles in a folder, found as `check` finds them.
fn types(
    folder: &[PathBuf],
    report: &mut Report,
    out: &Output,
) -> Result<Vec<RtcProfile>, CliError> {
    let mut unreadable = None;
    let mut bytes = |path: &Path| {
        let read = input::read(path);
        read.map_err(|error| unreadable.get_or_insert(error)).ok()
    };
    let library = library::read(folder, &mut bytes, report, out);
    if let Some(error) = unreadable {
        return Err(error);
    }
    let profiles = library.profiles().iter();
    Ok(profiles.map(|read| read.profile.clone()).collect())
}
