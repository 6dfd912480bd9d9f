//! RTS Profile (XML or YAML, versions 0.1 and 0.2): read into a mirror, then lowered to the one model; and written again
//! from that model, as XML of version 0.2.

pub(crate) mod composite;
pub mod forms;
pub mod ior;
mod lower;
mod mirror;
pub mod model;
pub mod versions;
mod write;

pub use crate::form::Format;
pub(crate) use lower::{
    CHOICES, NAME_KEY, TYPE_KEY, data_type_of, direction_of, escaped, execution_kind,
    is_pseudo_set, is_reversed, lower_any, normal_data_type, parse_rate, parse_timing, parse_whole,
    places, properties, type_name, unescaped, unused_name,
};
pub use lower::{LowerOptions, Places, lower};
pub use write::{WriteOptions, sayable, write};

use std::collections::HashMap;

use crate::diagnostic::{Place, Report, Source};
use crate::form::{self, Around, Opened, Tree};
use crate::overlay::Overlay;
use crate::span::Span;
use crate::system::{PortKind, SystemSpec};
use crate::xml::document::{Document, EditError};
use crate::{check, yaml};
use forms::{Shape, WORDS};
use model::{Component, Port, RtsProfile};

/// A profile as the file says it, with the text to point at.
#[derive(Debug, Clone)]
pub struct ReadProfile {
    /// The decoded text.
    pub source: Source,
    /// The mirror.
    pub profile: RtsProfile,
    /// All that the file says, in the shape of its version.
    pub shape: Shape,
    /// What stands around the root element.
    pub around: Around,
    /// XML or YAML.
    pub format: Format,
    /// Name of the encoding that was found (`UTF-8`).
    pub encoding: &'static str,
    /// What was noticed while reading: warnings, and errors that left the rest readable.
    pub findings: Report,
    /// Instance name → index of its first component.
    instances: HashMap<String, usize>,
    /// Of components with many ports: their ports in the order of their names.
    ports: HashMap<usize, Vec<u32>>,
}

/// Ports that are looked through one by one.
const FEW_PORTS: usize = 16;

impl ReadProfile {
    /// The place of a range; `None` when it is unknown.
    pub fn place(&self, span: Span) -> Option<Place> {
        (!span.is_unknown()).then(|| self.source.place(span.start, span.end))
    }

    /// Keeps the comments of YAML as comments of XML, which YAML is never written with.
    pub fn keep_remarks(&mut self) {
        form::keep_all_remarks(
            self.format,
            &self.source,
            self.shape.form_mut(),
            &mut self.around,
        );
    }

    /// The component with this instance name; of several the first.
    pub fn component(&self, instance: &str) -> Option<&Component> {
        let index = *self.instances.get(instance.trim())?;
        self.profile.components.get(index)
    }

    /// The declared port of a component, and its kind; of several the first.
    pub fn port(&self, instance: &str, port: &str) -> Option<(PortKind, &Port)> {
        let index = *self.instances.get(instance.trim())?;
        let component = self.profile.components.get(index)?;
        let Some(order) = self.ports.get(&index) else {
            return component.port(port);
        };
        let bare = component.bare_port(port);
        let name = |at: &u32| Some(component.port_name(usize::try_from(*at).ok()?)?.1);
        let at = order.partition_point(|at| name(at) < Some(bare));
        let at = order.get(at).filter(|at| name(at) == Some(bare))?;
        Some(component.port_name(usize::try_from(*at).ok()?)?.0)
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
    let Opened {
        source,
        encoding,
        mut findings,
        tree,
    } = form::open(file_name, bytes, &WORDS)?;
    let mut shape = shape_of(&tree);
    let (format, around) = tree.fill(shape.form_mut(), &WORDS, &source, &mut findings);
    let profile = mirror::mirror(&shape);
    Ok(ReadProfile {
        instances: index(&profile),
        ports: index_ports(&profile),
        source,
        profile,
        shape,
        around,
        format,
        encoding,
        findings,
    })
}

/// The text of a profile in a format: canonical layout, with everything that the profile keeps.
pub fn format(shape: &Shape, around: &Around, format: Format) -> String {
    form::format(shape.form(), around, &WORDS, format)
}

/// The document with everything that differs between what was read from it and an edited copy; see [`form::patch`].
///
/// # Errors
/// As [`form::patch`].
pub fn patch(document: &Document, old: &Shape, new: &Shape) -> Result<Document, EditError> {
    match (old, new) {
        (Shape::V02(old), Shape::V02(new)) => form::patch(document, &**old, &**new, &WORDS),
        (Shape::V01(old), Shape::V01(new)) => form::patch(document, &**old, &**new, &WORDS),
        _ => Err(EditError::Stranger("it is of another version".to_owned())),
    }
}

/// The YAML text with every value that differs between what was read from it and an edited copy; see
/// [`form::patch_yaml`].
///
/// # Errors
/// As [`form::patch_yaml`].
pub fn patch_yaml(source: &Source, old: &Shape, new: &Shape) -> Result<String, EditError> {
    match (old, new) {
        (Shape::V02(old), Shape::V02(new)) => form::patch_yaml(source, &**old, &**new, &WORDS),
        (Shape::V01(old), Shape::V01(new)) => form::patch_yaml(source, &**old, &**new, &WORDS),
        _ => Err(EditError::Stranger("it is of another version".to_owned())),
    }
}

/// Version 0.1 calls a component `Component`; what an XML file says of its version is often wrong.
fn shape_of(tree: &Tree) -> Shape {
    let old = match tree {
        Tree::Xml(tree) => {
            let root = &tree.root;
            let has = |local: &str| root.elements().any(|e| e.local() == local);
            let mut newer = forms::Profile::form_type().fields.iter();
            // Where no element tells, the version does.
            let version = root.attribute(&[forms::RTS, ""], "version");
            let says_so = version.is_some_and(|version| version.value.trim() == "0.1")
                && !newer.any(|field| *field.namespace == *forms::RTS && has(field.local));
            (has("Component") || root.local() == "RTSystemProfile" || says_so) && !has("Components")
        }
        Tree::Yaml(node, _) => {
            let version = node.get("version").and_then(yaml::Node::text);
            version.is_some_and(|version| version.trimmed() == "0.1")
                && node.get("dataPortConnectors").is_none()
        }
    };
    if old {
        Shape::V01(Box::default())
    } else {
        Shape::V02(Box::default())
    }
}

fn index_ports(profile: &RtsProfile) -> HashMap<usize, Vec<u32>> {
    let components = profile.components.iter().enumerate();
    let many = components.filter(|(_, c)| c.data_ports.len() + c.service_ports.len() > FEW_PORTS);
    many.map(|(index, component)| {
        let count = component.data_ports.len() + component.service_ports.len();
        let mut order: Vec<u32> = (0..count)
            .filter(|at| component.port_name(*at).is_some())
            .filter_map(|at| u32::try_from(at).ok())
            .collect();
        let name = |at: u32| Some(component.port_name(usize::try_from(at).ok()?)?.1);
        order.sort_by_key(|at| name(*at));
        (index, order)
    })
    .collect()
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
    let mut system = check::system(file_name, bytes, name, overlays, None)?;
    let report = system.take_report();
    match report.has_errors() {
        true => Err(report),
        false => Ok(Loaded {
            spec: system.spec,
            report,
            places: system.places,
        }),
    }
}
