//! The deployment overlay: where and how components run, said beside a profile that stays untouched.
//!
//! ```yaml
//! apiVersion: rtsctl.dev/v1
//! kind: Deployment
//! metadata: { name: lab }
//! spec:
//!   components:
//!     Printer0: { isolated: true, restart: on-failure }
//! ```

mod configuration;
mod document;
mod kind;
mod order;
mod select;
mod warn;

pub use document::{
    API_VERSION, ApiVersion, Deployment, DeploymentSpec, KIND, Kind, Metadata, Order, Rule,
    Selector, Sequence, WaitTime,
};

use serde_json::Value;

use crate::diagnostic::{Place, Report, Source};
use crate::placement;
use crate::rts_profile::Places;
use crate::span::Span;
use crate::system::SystemSpec;
use crate::yaml_type::{self, Faults, Row, YamlType, leaves_of};
use crate::{xml, yaml};

pub use configuration::{KnownParameters, Parameters};

/// An overlay as its file says it.
#[derive(Debug, Clone)]
pub struct Overlay {
    source: Source,
    /// `metadata.name`: the overlay's own name, for display.
    pub name: Option<String>,
    /// All that it says.
    pub deployment: Deployment,
    /// What is wrong with its shape, keys and values.
    pub findings: Report,
}

impl Overlay {
    /// The name of its file.
    pub fn file(&self) -> &str {
        self.source.name()
    }

    /// The nodes that it says hosts are: host, node.
    pub fn hosts(&self) -> impl Iterator<Item = (&str, &str)> {
        let hosts = self.deployment.spec.get().and_then(|spec| spec.hosts.get());
        let hosts = hosts.into_iter().flat_map(|hosts| hosts.iter());
        hosts.filter_map(|(host, node)| Some((host.trimmed(), node.get()?.0.as_str())))
    }

    fn place(&self, span: Span) -> Option<Place> {
        (!span.is_unknown()).then(|| self.source.place(span.start, span.end))
    }
}

/// Reads an overlay that is right. Whether its instances exist is seen only when it is laid over a system.
///
/// # Errors
/// Everything that is wrong with its shape, keys and values.
pub fn read(file_name: &str, bytes: &[u8]) -> Result<Overlay, Report> {
    let overlay = read_any(file_name, bytes)?;
    match overlay.findings.has_errors() {
        true => Err(overlay.findings),
        false => Ok(overlay),
    }
}

/// Reads an overlay as far as it can be understood; what is wrong is among its findings, and among those of laying it.
///
/// # Errors
/// When the file cannot be read at all: encoding, syntax, or another kind of document.
pub fn read_any(file_name: &str, bytes: &[u8]) -> Result<Overlay, Report> {
    let one = |finding| Report {
        findings: vec![finding],
    };
    let decoded = xml::decode(file_name, bytes).map_err(|finding| one(*finding))?;
    let source = Source::new(file_name, decoded.text);
    if let Some(finding) = kind::other(&source) {
        return Err(one(finding));
    }
    let root = yaml::parse(&source).map_err(|finding| one(*finding))?;
    if let Some(finding) = kind::other_root(&root, &source) {
        return Err(one(finding));
    }
    let mut faults = Faults::default();
    let deployment = Deployment::read(&root, "", &mut faults);
    let mut overlay = Overlay {
        source,
        name: None,
        deployment: deployment.unwrap_or_default(),
        findings: Report::default(),
    };
    let mut report = faults.into_report(|span| overlay.place(span));
    report.sort_by_place();
    let metadata = overlay.deployment.metadata.get();
    let name = metadata.and_then(|metadata| metadata.name.get());
    overlay.name = name.map(|name| name.0.clone());
    overlay.findings = report;
    Ok(overlay)
}

/// Lays an overlay over a system: what it says wins, what it does not say stays.
pub fn apply(spec: &mut SystemSpec, overlay: &Overlay) -> Report {
    let (places, known) = (&mut Places::default(), &KnownParameters::default());
    lay(spec, overlay, places, known)
}

/// The same; what the overlay says has its place there from then on. The report begins with what is wrong in the overlay
/// itself: what of it could be understood is laid all the same.
pub fn lay(
    spec: &mut SystemSpec,
    overlay: &Overlay,
    places: &mut Places,
    known: &KnownParameters,
) -> Report {
    let mut faults = Faults::default();
    let Some(said) = overlay.deployment.spec.get() else {
        return overlay.findings.clone();
    };
    for chosen in select::choose(spec, said, &mut faults) {
        let leaves = leaves_of(chosen.said.as_ref());
        configuration::check_before(spec, &chosen, known, &mut faults);
        for index in &chosen.components {
            let Some(component) = spec.components.get_mut(*index) else {
                continue;
            };
            placement::lay(component, &chosen.said);
            for leaf in &leaves {
                let path: Vec<&str> = leaf.path.iter().map(String::as_str).collect();
                let pointer = format!("/components/{index}/{}", placement::pointer(&path));
                let place = overlay.place(leaf.span);
                place
                    .into_iter()
                    .for_each(|place| places.put(pointer.clone(), place));
            }
        }
    }
    configuration::check_active(spec, said, &mut faults);
    order::add(spec, said, &mut faults, |pointer, span| {
        let place = overlay.place(span);
        place
            .into_iter()
            .for_each(|place| places.put(pointer.clone(), place));
    });
    warn::not_carried_out(said, &mut faults);
    let mut report = faults.into_report(|span| overlay.place(span));
    if overlay.findings.has_errors() {
        // What a rule says may be just what could not be read.
        report
            .findings
            .retain(|finding| finding.code != "empty-rule");
    }
    report.extend(overlay.findings.clone());
    report.sort_by_place();
    report
}

/// The JSON Schema (2020-12) of overlays.
pub fn schema() -> Value {
    yaml_type::schema_of::<Deployment>("rtsctl deployment overlay")
}

/// The keys of overlays that lead to plain values.
pub fn keys() -> Vec<Row> {
    yaml_type::rows_of::<Deployment>()
}

/// The text of an overlay.
pub fn write(deployment: &Deployment) -> String {
    yaml::print(&deployment.write())
}
