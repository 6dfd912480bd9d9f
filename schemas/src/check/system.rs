//! A profile with its overlays, checked to the end: nothing stops at the first fault.

use super::configured::{configured, known_parameters};
use super::contexts::contexts;
use super::library::Library;
use super::recorded::recorded;
use crate::check;
use crate::diagnostic::Report;
use crate::overlay::{self, KnownParameters, Overlay};
use crate::rts_profile::{self, LowerOptions, Places, ReadProfile, lower_any, places};
use crate::system::SystemSpec;

/// A system as its files describe it, right or wrong.
#[derive(Debug, Clone)]
pub struct System {
    /// The profile.
    pub read: ReadProfile,
    /// The one model with the overlays laid over it: what could be understood. Without a name when there is none; then the
    /// report has an error.
    pub spec: SystemSpec,
    /// Where its parts stand, in the profile or in an overlay.
    pub places: Places,
    /// Everything that was found in the profile, in the order of its lines.
    pub report: Report,
    /// The files of the overlays, and what was found in each.
    pub overlays: Vec<(String, Report)>,
    /// Hosts that overlays name, and the nodes that these are.
    pub(super) hosts: Vec<(String, String)>,
}

/// Reads and checks a profile and lays the overlays over it in their order, whatever is wrong with it. Values that overlays
/// give are held against the profile, and against the RTC Profiles of a library.
///
/// # Errors
/// When the profile cannot be read at all.
pub fn system(
    file_name: &str,
    bytes: &[u8],
    name: Option<&str>,
    overlays: &[Overlay],
    library: Option<&Library>,
) -> Result<System, Report> {
    let read = rts_profile::read(file_name, bytes)?;
    let options = LowerOptions {
        name,
        file_stem: crate::names::file_stem(file_name),
    };
    let mut report = check::profile(&read);
    let (mut spec, lowering) = lower_any(&read, &options);
    report.extend(lowering);
    report.sort_by_place();
    let mut places = places(&read, &spec);
    let known = match overlays {
        [] => KnownParameters::new(),
        _ => known_parameters(&read, library),
    };
    let laid = overlays.iter().map(|overlay| {
        let report = overlay::lay(&mut spec, overlay, &mut places, &known);
        (overlay.file().to_owned(), report)
    });
    let laid = laid.collect();
    let mut values = configured(&read, &spec, &places, library);
    values.extend(contexts(&spec, &places));
    if let Some(library) = library {
        values.extend(recorded(&spec, &places, library));
    }
    let hosts = overlays.iter().flat_map(Overlay::hosts);
    let hosts = hosts.map(|(host, node)| (host.to_owned(), node.to_owned()));
    let mut system = System {
        hosts: hosts.collect(),
        read,
        spec,
        places,
        report,
        overlays: laid,
    };
    system.add(values);
    Ok(system)
}

impl System {
    /// Adds findings to those of the files that they stand in.
    pub fn add(&mut self, report: Report) {
        for finding in report.findings {
            let file = finding.place.as_ref().map(|place| place.file.as_str());
            let mut overlays = self.overlays.iter_mut();
            match overlays.find(|(name, _)| Some(name.as_str()) == file) {
                Some((_, report)) => report.push(finding),
                None => self.report.push(finding),
            }
        }
        self.report.sort_by_place();
        for (_, report) in &mut self.overlays {
            report.sort_by_place();
        }
    }

    /// Takes all findings, file by file.
    pub fn take_report(&mut self) -> Report {
        let mut all = std::mem::take(&mut self.report);
        for (_, report) in &mut self.overlays {
            all.extend(std::mem::take(report));
        }
        all
    }
}
