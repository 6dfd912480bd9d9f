//! The deployment overlay: where components run, said beside a profile that stays untouched.
//!
//! ```yaml
//! apiVersion: rtsctl.dev/v1
//! kind: Deployment
//! metadata: { name: lab }
//! spec:
//!   components:
//!     Printer0: { isolated: true, restart: on-failure }
//! ```

use crate::diagnostic::{Finding, Place, Report, Source};
use crate::placement::{self, PREFIX};
use crate::span::{Span, Text};
use crate::suggest;
use crate::system::{ComponentSpec, SystemSpec};
use crate::yaml::{Node, Value};
use crate::{xml, yaml};

/// Value of `apiVersion`.
pub const API_VERSION: &str = "rtsctl.dev/v1";

/// Value of `kind`.
pub const KIND: &str = "Deployment";

/// An overlay as its file says it.
#[derive(Debug, Clone)]
pub struct Overlay {
    source: Source,
    /// `metadata.name`: the overlay's own name, for display.
    pub name: Option<String>,
    components: Vec<Entry>,
}

#[derive(Debug, Clone)]
struct Entry {
    instance: Text,
    /// Keys without their prefix.
    settings: Vec<(Text, Text)>,
}

impl Overlay {
    /// The instance names it speaks of, in the order of the file.
    pub fn instances(&self) -> impl Iterator<Item = &str> {
        self.components
            .iter()
            .map(|entry| entry.instance.value.as_str())
    }

    fn place(&self, span: Span) -> Option<Place> {
        (!span.is_unknown()).then(|| self.source.place(span.start, span.end))
    }
}

/// Reads an overlay. Whether its instances exist is seen only when it is applied.
///
/// # Errors
/// Everything that is wrong with its shape, keys and values.
pub fn read(file_name: &str, bytes: &[u8]) -> Result<Overlay, Report> {
    let one = |finding| Report {
        findings: vec![finding],
    };
    let decoded = xml::decode(file_name, bytes).map_err(|finding| one(*finding))?;
    let source = Source::new(file_name, decoded.text);
    let root = yaml::parse(&source).map_err(|finding| one(*finding))?;
    let mut reader = Reader {
        overlay: Overlay {
            source,
            name: None,
            components: Vec::new(),
        },
        report: Report::default(),
    };
    reader.root(&root);
    reader.report.sort_by_place();
    if reader.report.has_errors() {
        Err(reader.report)
    } else {
        Ok(reader.overlay)
    }
}

/// Lays an overlay over a system: what it says wins, what it does not say stays.
pub fn apply(spec: &mut SystemSpec, overlay: &Overlay) -> Report {
    let mut report = Report::default();
    let instances: Vec<String> = spec.components.iter().map(|c| c.instance.clone()).collect();
    for entry in &overlay.components {
        let instance = entry.instance.trimmed();
        let component = spec.components.iter_mut().find(|c| c.instance == instance);
        let Some(component) = component else {
            let names: Vec<&str> = instances.iter().map(String::as_str).collect();
            report.push(
                Finding::error(
                    "unknown-instance",
                    format!("the system has no component `{instance}`"),
                )
                .at(overlay.place(entry.instance.span))
                .help(suggest::advice(instance, "components", &names)),
            );
            continue;
        };
        set_all(component, overlay, entry, &mut report);
    }
    report.sort_by_place();
    report
}

/// `isolated: true` beats a manager of the same overlay, whichever stands first.
fn set_all(component: &mut ComponentSpec, overlay: &Overlay, entry: &Entry, report: &mut Report) {
    let (isolated, others): (Vec<_>, Vec<_>) = entry
        .settings
        .iter()
        .partition(|(key, _)| key.value == "isolated");
    for (key, value) in others.into_iter().chain(isolated) {
        if let Err(error) = placement::set(component, &key.value, &value.value) {
            let span = if error.code() == "bad-placement-value" {
                value.span
            } else {
                key.span
            };
            report.push(
                Finding::error(error.code(), error.to_string())
                    .at(overlay.place(span))
                    .help(error.help()),
            );
        }
    }
}

struct Reader {
    overlay: Overlay,
    report: Report,
}

impl Reader {
    fn error(&mut self, code: &str, message: String, span: Span, help: impl Into<String>) {
        // A file of nothing but mistakes needs no longer list.
        const MOST: usize = 200;
        if self.report.findings.len() >= MOST {
            return;
        }
        let place = self.overlay.place(span);
        self.report
            .push(Finding::error(code, message).at(place).help(help));
    }

    fn root(&mut self, root: &Node) {
        if !self.mapping(root, "an overlay") {
            return;
        }
        self.constant(root, "apiVersion", API_VERSION);
        self.constant(root, "kind", KIND);
        self.only(root, &["apiVersion", "kind", "metadata", "spec"]);
        if let Some(metadata) = root
            .get("metadata")
            .filter(|node| node.value != Value::Null)
            && self.mapping(metadata, "`metadata`")
        {
            self.only(metadata, &["name"]);
            self.overlay.name = metadata.get("name").and_then(Node::text).map(|t| t.value);
        }
        let Some(spec) = root.get("spec") else {
            self.error(
                "missing-key",
                "`spec` is missing".into(),
                root.span,
                "add `spec: { components: … }`",
            );
            return;
        };
        if !self.mapping(spec, "`spec`") {
            return;
        }
        self.only(spec, &["components"]);
        if let Some(components) = spec
            .get("components")
            .filter(|node| node.value != Value::Null)
            && self.mapping(components, "`components`")
        {
            for (instance, node) in components.entries() {
                self.entry(instance, node);
            }
        }
    }

    fn entry(&mut self, instance: &Text, node: &Node) {
        let mut entry = Entry {
            instance: instance.clone(),
            settings: Vec::new(),
        };
        if node.value != Value::Null && !self.mapping(node, &format!("`{}`", instance.value)) {
            return;
        }
        for (key, value) in node.entries() {
            let bare = key.value.strip_prefix(PREFIX).unwrap_or(&key.value);
            if !placement::KEYS.contains(&bare) {
                let help = suggest::advice(bare, "keys", &placement::KEYS);
                let message = format!("`{}` is not a placement key", key.value);
                self.error("unknown-placement-key", message, key.span, help);
                continue;
            }
            match value.text() {
                Some(text) => entry.settings.push((Text::new(bare, key.span), text)),
                None => {
                    let message = format!(
                        "`{}` takes a plain value, this is {}",
                        key.value,
                        value.kind()
                    );
                    self.error("wrong-shape", message, key.span, "write `key: value`");
                }
            }
        }
        self.overlay.components.push(entry);
    }

    fn mapping(&mut self, node: &Node, what: &str) -> bool {
        let is_mapping = matches!(node.value, Value::Mapping(_));
        if !is_mapping {
            let message = format!("{what} must be a mapping, this is {}", node.kind());
            self.error(
                "wrong-shape",
                message,
                node.span,
                "write `key: value` lines",
            );
        }
        is_mapping
    }

    fn constant(&mut self, root: &Node, key: &str, expected: &str) {
        match root.get(key).and_then(Node::text) {
            Some(text) if text.value == expected => {}
            Some(text) => {
                let message = format!(
                    "`{key}` is `{}`, this program reads `{expected}`",
                    text.value
                );
                self.error(
                    "wrong-kind",
                    message,
                    text.span,
                    format!("write `{key}: {expected}`"),
                );
            }
            None => {
                let message = format!("`{key}` is missing");
                self.error(
                    "missing-key",
                    message,
                    root.span,
                    format!("add `{key}: {expected}`"),
                );
            }
        }
    }

    fn only(&mut self, node: &Node, known: &[&str]) {
        for (key, _) in node.entries() {
            if !known.contains(&key.value.as_str()) {
                let message = format!("`{}` is not known here", key.value);
                self.error(
                    "unknown-key",
                    message,
                    key.span,
                    suggest::advice(&key.value, "keys", known),
                );
            }
        }
    }
}
