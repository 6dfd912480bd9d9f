//! A profile with its overlays, checked to the end: nothing stops at the first fault.

use crate::check;
use crate::diagnostic::Report;
use crate::overlay::{self, Overlay};
use crate::rts_profile::{self, LowerOptions, ReadProfile};
use crate::system::SystemSpec;

/// A system as its files describe it, right or wrong.
#[derive(Debug, Clone)]
pub struct System {
    /// The profile.
    pub read: ReadProfile,
    /// The one model with the overlays laid over it: what could be understood. `None` when it has no name.
    pub spec: Option<SystemSpec>,
    /// Everything that was found in the profile, in the order of its lines.
    pub report: Report,
    /// What was found when each overlay was laid over the system.
    pub overlays: Vec<Report>,
}

/// Reads and checks a profile and lays the overlays over it in their order, whatever is wrong with it.
///
/// # Errors
/// When the profile cannot be read at all.
pub fn system(
    file_name: &str,
    bytes: &[u8],
    name: Option<&str>,
    overlays: &[Overlay],
) -> Result<System, Report> {
    let read = rts_profile::read(file_name, bytes)?;
    let options = LowerOptions {
        name,
        file_stem: crate::names::file_stem(file_name),
    };
    let mut report = check::profile(&read);
    let (mut spec, lowering) = rts_profile::lower(&read, &options);
    report.extend(lowering);
    report.sort_by_place();
    let overlays = match &mut spec {
        Some(spec) => overlays.iter().map(|o| overlay::apply(spec, o)).collect(),
        None => Vec::new(),
    };
    Ok(System {
        read,
        spec,
        report,
        overlays,
    })
}
