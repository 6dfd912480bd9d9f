//! RTS Profile (XML or YAML, versions 0.1 and 0.2): read into a mirror, then lowered to the one model; and written again
//! from that model, as XML of version 0.2.

pub mod ior;
mod lower;
pub mod model;
mod read_xml;
mod read_yaml;
mod write;

pub use lower::{LowerOptions, Places, lower};
pub(crate) use lower::{
    NAME_KEY, TYPE_KEY, data_type_of, direction_of, execution_kind, is_pseudo_set, is_reversed,
    normal_data_type, parse_rate, parse_timing, parse_whole, type_name,
};
pub use write::{WriteOptions, sayable, write};

use std::collections::HashMap;

use crate::diagnostic::{Finding, Place, Report, Source};
use crate::overlay::{self, Overlay};
use crate::span::Span;
use crate::system::SystemSpec;
use crate::{check, xml, yaml};
use model::{Component, RtsProfile};

/// A profile as the file says it, with the text to point at.
#[derive(Debug, Clone)]
pub struct ReadProfile {
    /// The decoded text.
    pub source: Source,
    /// The mirror.
    pub profile: RtsProfile,
    /// XML or YAML.
    pub format: Format,
    /// Name of the encoding that was found (`UTF-8`).
    pub encoding: &'static str,
    /// What was noticed while reading: warnings, and errors that left the rest readable.
    pub findings: Report,
    /// Instance name → index of its first component.
    instances: HashMap<String, usize>,
}

/// How a profile is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// `rts:RtsProfile`.
    Xml,
    /// `rtsProfile:`.
    Yaml,
}

impl ReadProfile {
    /// The place of a range; `None` when it is unknown.
    pub fn place(&self, span: Span) -> Option<Place> {
        (!span.is_unknown()).then(|| self.source.place(span.start, span.end))
    }

    /// The component with this instance name; of several the first.
    pub fn component(&self, instance: &str) -> Option<&Component> {
        let index = *self.instances.get(instance.trim())?;
        self.profile.components.get(index)
    }

    /// How the file writes an attribute: `rts:instanceName` in XML, `instanceName` in YAML.
    pub fn spelled(&self, key: &str) -> String {
        match self.format {
            Format::Xml => format!("rts:{key}"),
            Format::Yaml => key.to_owned(),
        }
    }
}

/// Reads a profile; the format is seen from the content, never from the file's name.
///
/// # Errors
/// A report with one error when the file cannot be read at all: encoding, syntax, or another kind of document.
pub fn read(file_name: &str, bytes: &[u8]) -> Result<ReadProfile, Report> {
    let decoded = xml::decode(file_name, bytes).map_err(|finding| alone(*finding))?;
    let source = Source::new(file_name, decoded.text);
    let mut findings = Report::default();
    findings.findings.extend(decoded.warning);
    let start = source.text().trim_start();
    let (format, profile) = if start.is_empty() {
        return Err(alone(
            Finding::error("empty-file", format!("{file_name} is empty"))
                .help("an RTS Profile starts with `<rts:RtsProfile …>` or `rtsProfile:`"),
        ));
    } else if start.starts_with('<') {
        let root = xml::parse(source.text()).map_err(|error| alone(error.finding(&source)))?;
        (
            Format::Xml,
            read_xml::profile(&root, &source, &mut findings),
        )
    } else {
        let root = yaml::parse(&source).map_err(|finding| alone(*finding))?;
        (
            Format::Yaml,
            read_yaml::profile(&root, &source, &mut findings),
        )
    };
    match profile {
        Some(profile) => Ok(ReadProfile {
            instances: index(&profile),
            source,
            profile,
            format,
            encoding: decoded.encoding,
            findings,
        }),
        None => Err(findings),
    }
}

fn index(profile: &RtsProfile) -> HashMap<String, usize> {
    let mut instances = HashMap::new();
    for (index, component) in profile.components.iter().enumerate() {
        if let Some(name) = &component.instance_name {
            instances.entry(name.trimmed().to_owned()).or_insert(index);
        }
    }
    instances
}

fn alone(finding: Finding) -> Report {
    Report {
        findings: vec![finding],
    }
}

/// Reads, checks and lowers a profile, then lays the overlays over it in their order.
///
/// The name of the system is `name` if given, else the profile's, else the stem of the file.
///
/// # Errors
/// All findings, at least one of them an error: nothing of such a system may be deployed.
pub fn load(
    file_name: &str,
    bytes: &[u8],
    name: Option<&str>,
    overlays: &[Overlay],
) -> Result<(SystemSpec, Report), Report> {
    load_with_places(file_name, bytes, name, overlays).map(|loaded| (loaded.spec, loaded.report))
}

/// A system that was read, and where its parts stand.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// The system.
    pub spec: SystemSpec,
    /// Findings, none of them an error.
    pub report: Report,
    /// Places of its parts.
    pub places: Places,
}

/// [`load`], with the places of the system's parts.
///
/// # Errors
/// As [`load`].
pub fn load_with_places(
    file_name: &str,
    bytes: &[u8],
    name: Option<&str>,
    overlays: &[Overlay],
) -> Result<Loaded, Report> {
    let read = read(file_name, bytes)?;
    let options = LowerOptions {
        name,
        file_stem: crate::names::file_stem(file_name),
    };
    let mut report = check::profile(&read);
    let (spec, lowering) = lower(&read, &options);
    report.extend(lowering);
    report.sort_by_place();
    let Some(mut spec) = spec else {
        debug_assert!(report.has_errors());
        return Err(report);
    };
    let places = lower::places(&read, &spec);
    for overlay in overlays {
        report.extend(overlay::apply(&mut spec, overlay));
    }
    if report.has_errors() {
        Err(report)
    } else {
        Ok(Loaded {
            spec,
            report,
            places,
        })
    }
}
