//! Types that are read from YAML: each key is declared once, with its type and its documentation. The reader, the writer,
//! the JSON Schema and the table of keys are made of that.

mod collections;
mod declare;
mod faults;
mod scalar;
mod schema;
mod setting;

pub(crate) use collections::within;
pub use collections::{List, Map};
pub(crate) use declare::yaml_type;
pub use faults::Faults;
pub use scalar::{Scalar, Words};
pub use schema::{Definitions, Object, schema_of};
pub use setting::Setting;

use serde_json::Value;

use crate::span::Span;
use crate::yaml::Node;

/// A type of YAML value.
pub trait YamlType: Sized {
    /// Its JSON Schema; types with a name are added to the definitions and referred to.
    fn schema(definitions: &mut Definitions) -> Value;

    /// Reads the value of a key; nothing after a fault that leaves no value.
    fn read(node: &Node, key: &str, faults: &mut Faults) -> Option<Self>;

    /// The value as YAML has it.
    fn write(&self) -> Value;

    /// Adds the keys that lead to plain values.
    fn rows(path: &str, doc: &str, rows: &mut Vec<Row>);

    /// Adds the plain values that are said, and what is taken back.
    fn leaves(&self, path: &[&str], span: Span, leaves: &mut Vec<Leaf>);
}

/// A plain value that is said, or `null`.
#[derive(Debug, Clone, PartialEq)]
pub struct Leaf {
    /// Keys that lead to it.
    pub path: Vec<String>,
    /// Where it stands.
    pub span: Span,
    /// As YAML has it.
    pub value: Value,
}

/// All plain values that a type says, in the order of its declaration.
pub fn leaves_of<T: YamlType>(of: &T) -> Vec<Leaf> {
    let mut leaves = Vec::new();
    of.leaves(&[], Span::default(), &mut leaves);
    leaves
}

/// A key, documented.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Row {
    /// From the root on: `spec.defaults.node`.
    pub path: String,
    /// What it takes.
    pub expected: String,
    /// What it says.
    pub doc: String,
}

/// All keys of a type that lead to plain values, in the order of their declaration.
pub fn rows_of<T: YamlType>() -> Vec<Row> {
    let mut rows = Vec::new();
    T::rows("", "", &mut rows);
    rows
}

/// A documentation comment as one text.
pub(crate) fn text_of(doc: &str) -> String {
    let lines: Vec<&str> = doc.lines().map(str::trim).collect();
    lines.join(" ").trim().to_owned()
}
