//! Mappings whose keys are names, and lists.

use serde_json::{Value, json};

use super::schema::nullable;
use super::{Definitions, Faults, Leaf, Row, Setting, YamlType};
use crate::diagnostic::Finding;
use crate::span::{Span, Text};
use crate::yaml::{self, Node};

/// Most entries of a mapping or list.
const ENTRIES: usize = 10_000;

/// Longest key, in bytes: as that of a stored parameter or set.
const KEY: usize = 528;

/// Names and what is said under them, in the order of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Map<T>(pub Vec<(Text, Setting<T>)>);

impl<T> Default for Map<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Map<T> {
    /// The names and what is said under them.
    pub fn iter(&self) -> impl Iterator<Item = (&Text, &Setting<T>)> {
        self.0.iter().map(|(key, setting)| (key, setting))
    }
}

impl<T: YamlType> YamlType for Map<T> {
    fn schema(definitions: &mut Definitions) -> Value {
        json!({
            "type": "object",
            "propertyNames": {"minLength": 1, "maxLength": KEY},
            "additionalProperties": nullable(T::schema(definitions)),
            "maxProperties": ENTRIES,
        })
    }

    fn read(node: &Node, key: &str, faults: &mut Faults) -> Option<Self> {
        if !matches!(node.value, yaml::Value::Mapping(_)) {
            let what = format!("`{key}`");
            faults.wrong_shape(&what, "must be a mapping", node, "write `key: value` lines");
            return None;
        }
        within(node.entries().len(), key, node, faults)?;
        let mut map = Self::default();
        for (name, value) in node.entries() {
            if let Some(problem) = key_problem(&name.value) {
                let message = format!("`{}` cannot be a name in `{key}`: {problem}", name.value);
                let help = format!("a name has 1 to {KEY} bytes without control characters");
                faults.push(Finding::error("bad-name", message).help(help), name.span);
                continue;
            }
            map.0
                .push((name.clone(), Setting::read(name, value, faults)));
        }
        Some(map)
    }

    fn write(&self) -> Value {
        let entries = self.0.iter();
        let entries = entries.filter_map(|(key, said)| Some((key.value.clone(), said.write()?)));
        Value::Object(entries.collect())
    }

    fn rows(path: &str, doc: &str, rows: &mut Vec<Row>) {
        T::rows(&format!("{path}.NAME"), doc, rows);
    }

    fn leaves(&self, path: &[&str], _: Span, leaves: &mut Vec<Leaf>) {
        for (key, said) in self.iter() {
            said.leaves(path, &key.value, leaves);
        }
    }
}

fn key_problem(key: &str) -> Option<&'static str> {
    match key {
        key if key.trim().is_empty() => Some("it is empty"),
        key if key.len() > KEY => Some("it is too long"),
        key if key.chars().any(char::is_control) => Some("it has a control character"),
        _ => None,
    }
}

/// A fault when a mapping or list has too many entries.
pub(crate) fn within(count: usize, key: &str, node: &Node, faults: &mut Faults) -> Option<()> {
    if count <= ENTRIES {
        return Some(());
    }
    let message = format!("`{key}` has {count} entries, which are more than {ENTRIES}");
    let finding = Finding::error("too-many-entries", message).help("write fewer, or use globs");
    faults.push(finding, node.span);
    None
}

/// A list; one item may stand alone.
#[derive(Debug, Clone, PartialEq)]
pub struct List<T>(pub Vec<(T, Span)>);

impl<T> Default for List<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T: YamlType> YamlType for List<T> {
    fn schema(definitions: &mut Definitions) -> Value {
        let item = T::schema(definitions);
        let list = json!({"type": "array", "items": item, "maxItems": ENTRIES});
        json!({"anyOf": [item, list]})
    }

    fn read(node: &Node, key: &str, faults: &mut Faults) -> Option<Self> {
        let items = match &node.value {
            yaml::Value::Sequence(items) => items,
            _ => std::slice::from_ref(node),
        };
        within(items.len(), key, node, faults)?;
        let read = |item: &Node| Some((T::read(item, key, faults)?, item.span));
        Some(Self(items.iter().filter_map(read).collect()))
    }

    fn write(&self) -> Value {
        Value::Array(self.0.iter().map(|(item, _)| item.write()).collect())
    }

    fn rows(path: &str, doc: &str, rows: &mut Vec<Row>) {
        T::rows(path, doc, rows);
    }

    fn leaves(&self, path: &[&str], span: Span, leaves: &mut Vec<Leaf>) {
        leaves.push(Leaf {
            path: path.iter().map(|part| (*part).to_owned()).collect(),
            span,
            value: self.write(),
        });
    }
}
