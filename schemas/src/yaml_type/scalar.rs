//! Plain values.

use serde_json::{Value, json};

use super::{Definitions, Faults, Leaf, Row, YamlType};
use crate::diagnostic::Finding;
use crate::span::Span;
use crate::yaml::Node;

/// A plain value.
pub trait Scalar: Sized {
    /// What it takes, for advice and documentation.
    const EXPECTED: &'static str;

    /// Whether blanks around it are part of it.
    const BLANKS: bool = false;

    /// The value that a text spells.
    fn parse(text: &str) -> Option<Self>;

    /// A text that spells it.
    fn spelled(&self) -> String;

    /// Its JSON Schema.
    fn schema() -> Value;

    /// What is wrong with a text that spells none.
    fn fault(key: &str, text: &str) -> Finding {
        let message = format!("`{text}` is not a value of `{key}`");
        Finding::error("bad-placement-value", message).help(format!("expected: {}", Self::EXPECTED))
    }

    /// The value as YAML has it.
    fn write(&self) -> Value {
        Value::String(self.spelled())
    }
}

impl<T: Scalar> YamlType for T {
    fn schema(_: &mut Definitions) -> Value {
        T::schema()
    }

    fn read(node: &Node, key: &str, faults: &mut Faults) -> Option<Self> {
        let Some(text) = node.text() else {
            let help = format!("expected: {}", T::EXPECTED);
            faults.wrong_shape(&format!("`{key}`"), "takes a plain value", node, &help);
            return None;
        };
        let spelled = if T::BLANKS {
            &text.value
        } else {
            text.trimmed()
        };
        let value = T::parse(spelled);
        if value.is_none() {
            faults.push(T::fault(key, spelled), text.span);
        }
        value
    }

    fn write(&self) -> Value {
        Scalar::write(self)
    }

    fn rows(path: &str, doc: &str, rows: &mut Vec<Row>) {
        rows.push(Row {
            path: path.to_owned(),
            expected: T::EXPECTED.to_owned(),
            doc: doc.to_owned(),
        });
    }

    fn leaves(&self, path: &[&str], span: Span, leaves: &mut Vec<Leaf>) {
        leaves.push(Leaf {
            path: path.iter().map(|part| (*part).to_owned()).collect(),
            span,
            value: Scalar::write(self),
        });
    }
}

/// One of some words, in any case.
pub trait Words: Sized + Copy + 'static {
    /// All of them.
    const ALL: &'static [Self];
    /// All of them, for advice.
    const EXPECTED: &'static str;

    /// The word.
    fn word(self) -> &'static str;

    /// The value of a word.
    fn of_word(text: &str) -> Option<Self> {
        let text = text.to_ascii_lowercase();
        Self::ALL.iter().copied().find(|one| one.word() == text)
    }

    /// The JSON Schema of the words.
    fn schema_of_words() -> Value {
        let words: Vec<&str> = Self::ALL.iter().map(|one| one.word()).collect();
        json!({"type": "string", "enum": words})
    }
}

impl Scalar for bool {
    const EXPECTED: &'static str = "`true` or `false`";

    fn parse(text: &str) -> Option<Self> {
        crate::placement::parse_bool(text)
    }

    fn spelled(&self) -> String {
        self.to_string()
    }

    fn schema() -> Value {
        json!({"type": "boolean"})
    }

    fn write(&self) -> Value {
        Value::Bool(*self)
    }
}
