//! What is wrong in a file, with the ranges of text that it is about.

use super::{Definitions, YamlType};
use crate::diagnostic::{Finding, Place, Report};
use crate::span::Span;
use crate::suggest;
use crate::yaml::Node;

/// Most faults that are kept: nobody reads more, and each costs its line.
const LIMIT: usize = 500;

/// Findings that have no place yet.
#[derive(Debug, Default)]
pub struct Faults {
    list: Vec<(Finding, Span)>,
}

impl Faults {
    /// Adds a finding about a range of the text.
    pub fn push(&mut self, finding: Finding, span: Span) {
        if self.list.len() < LIMIT {
            self.list.push((finding, span));
        }
    }

    /// A value of another shape than the key takes.
    pub fn wrong_shape(&mut self, what: &str, wanted: &str, node: &Node, help: &str) {
        let message = format!("{what} {wanted}, this is {}", node.kind());
        self.push(Finding::error("wrong-shape", message).help(help), node.span);
    }

    /// A key that nobody knows here.
    pub fn unknown_key(&mut self, code: &str, key: &str, known: &[&str], span: Span) {
        let message = match code {
            "unknown-placement-key" => format!("`{key}` is not a placement key"),
            _ => format!("`{key}` is not known here"),
        };
        let bare = key.strip_prefix(crate::placement::PREFIX).unwrap_or(key);
        let help = suggest::advice(bare, "keys", known);
        self.push(Finding::error(code, message).help(help), span);
    }

    /// A key that must be there.
    pub fn missing_key<T: YamlType>(&mut self, key: &str, node: &Node) {
        let schema = T::schema(&mut Definitions::default());
        let value = schema.get("const").and_then(|value| value.as_str());
        let help = format!("add `{key}: {}`", value.unwrap_or("…"));
        let message = format!("`{key}` is missing");
        self.push(Finding::error("missing-key", message).help(help), node.span);
    }

    /// The first finding.
    pub fn into_first(self) -> Option<Finding> {
        self.list.into_iter().next().map(|(finding, _)| finding)
    }

    /// The findings with their places.
    pub fn into_report(self, place: impl Fn(Span) -> Option<Place>) -> Report {
        let findings = self.list.into_iter();
        Report {
            findings: findings.map(|(f, span)| f.at(place(span))).collect(),
        }
    }
}
