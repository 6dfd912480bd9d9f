//! Reads all files that are to be checked, and gathers what is wrong with each.

use std::path::{Path, PathBuf};

use rts_schemas::check;
use rts_schemas::diagnostic::Report;
use rts_schemas::overlay::{self, Overlay};
use rts_schemas::rtc_profile;

use super::{cycles, reached};
use crate::error::CliError;
use crate::input::{is_stdin, read, shown};
use crate::library;
use crate::local::nodes::Nodes;
use crate::output::Output;

/// What is checked together.
pub(super) struct Files<'a> {
    pub(super) profile: &'a Path,
    pub(super) overlays: Vec<&'a PathBuf>,
    pub(super) rtc: &'a [PathBuf],
    pub(super) name: Option<&'a str>,
    /// All that there are; none when nobody says.
    pub(super) nodes: Vec<&'a str>,
    /// Those of the home.
    pub(super) home: Option<Nodes>,
}

impl Files<'_> {
    /// Everything that was found, file by file, and the first file that could not be read.
    pub(super) fn check(&self, out: &Output) -> Result<(Report, Option<CliError>), CliError> {
        let all = self.overlays.iter().map(|path| path.as_path());
        let stdin = all.chain([self.profile]).filter(|path| is_stdin(path));
        if stdin.count() > 1 {
            return Err(CliError::usage("standard input can be read only once"));
        }
        let mut unreadable = None;
        let mut bytes = |path: &Path| match read(path) {
            Ok(bytes) => Some(bytes),
            Err(error) => {
                unreadable.get_or_insert(error);
                None
            }
        };
        let profile = bytes(self.profile);
        let overlays: Vec<Option<Result<Overlay, Report>>> = self
            .overlays
            .iter()
            .map(|path| Some(overlay::read_any(&shown(path), &bytes(path)?)))
            .collect();
        let mut rtc = Report::default();
        let library = library::read(self.rtc, &mut bytes, &mut rtc, out);

        let usable: Vec<Overlay> = overlays
            .iter()
            .flatten()
            .filter_map(|overlay| overlay.as_ref().ok().cloned())
            .collect();
        let mut report = Report::default();
        let mut laid: Vec<Report> = usable.iter().map(|o| o.findings.clone()).collect();
        if let Some(bytes) = profile {
            let name = shown(self.profile);
            match check::system(&name, &bytes, self.name, &usable, Some(&library)) {
                Ok(mut system) => {
                    system.add(cycles::cycles(&system));
                    let nodes = (!self.nodes.is_empty()).then_some(self.nodes.as_slice());
                    system.add(check::placed(&system, nodes));
                    if let Some(nodes) = &self.home {
                        system.add(reached::cut_off(&system, nodes));
                    }
                    if !self.rtc.is_empty() {
                        let (against, used) = check::against(&system.read, &library);
                        system.add(against);
                        let profiles = library.profiles();
                        let used = used.iter().filter_map(|index| profiles.get(*index));
                        used.for_each(|profile| rtc.extend(check::rtc_profile(profile)));
                    }
                    report.extend(system.report);
                    laid = system
                        .overlays
                        .into_iter()
                        .map(|(_, report)| report)
                        .collect();
                }
                Err(fault) => report.extend(alone(&name, &bytes, fault)),
            }
        }
        let mut laid = laid.into_iter();
        for overlay in overlays.into_iter().flatten() {
            match overlay {
                Ok(_) => report.extend(laid.next().unwrap_or_default()),
                Err(fault) => report.extend(fault),
            }
        }
        report.extend(rtc);
        Ok((report, unreadable))
    }
}

/// Another document than an RTS Profile may be an RTC Profile.
fn alone(name: &str, bytes: &[u8], fault: Report) -> Report {
    let is_other = fault.findings.iter().any(|f| f.code == "wrong-root");
    if !is_other {
        return fault;
    }
    match rtc_profile::read(name, bytes) {
        Ok(profile) => check::rtc_profile(&profile),
        Err(other) if other.findings.iter().any(|f| f.code == "wrong-root") => fault,
        Err(other) => other,
    }
}
