//! The recorded data of one port, as overlays and profiles have it.

use serde_json::{Value, json};

use crate::diagnostic::Finding;
use crate::span::Span;
use crate::stand_in::recorded::MAX_VALUES;
use crate::yaml::{self, Node};
use crate::yaml_type::{Definitions, Faults, Leaf, Row, YamlType, within};

const EXPECTED: &str = "a list of values; of a type that is a sequence, a list of lists";

/// Values in their order, each the texts of its elements.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Values(pub Vec<Vec<String>>);

impl YamlType for Values {
    fn schema(_: &mut Definitions) -> Value {
        let plain = json!({"type": ["string", "number", "boolean"]});
        let list = json!({"type": "array", "items": plain, "maxItems": MAX_VALUES});
        let item = json!({"anyOf": [plain, list]});
        json!({"type": "array", "items": item, "minItems": 1, "maxItems": MAX_VALUES})
    }

    fn read(node: &Node, key: &str, faults: &mut Faults) -> Option<Self> {
        match &node.value {
            yaml::Value::Sequence(items) => {
                within(items.len(), key, node, faults)?;
                let values = items.iter().map(|item| value(item, key, faults));
                // All faults are told.
                let values: Vec<Option<Vec<String>>> = values.collect();
                values.into_iter().collect::<Option<_>>().map(Self)
            }
            // As a profile has it.
            yaml::Value::Scalar(text) => {
                let values = of_json(text);
                if values.is_none() {
                    let message = format!("`{key}` takes {EXPECTED}");
                    let help = "write the values themselves, such as `[1, 2.5, 3]`";
                    let finding = Finding::error("bad-placement-value", message).help(help);
                    faults.push(finding, node.span);
                }
                values.map(Self)
            }
            _ => wrong(node, key, faults),
        }
    }

    fn write(&self) -> Value {
        let values = self.0.iter().map(|texts| match texts.as_slice() {
            [one] => json!(one),
            more => json!(more),
        });
        Value::Array(values.collect())
    }

    fn rows(path: &str, doc: &str, rows: &mut Vec<Row>) {
        rows.push(Row {
            path: path.to_owned(),
            expected: EXPECTED.to_owned(),
            doc: doc.to_owned(),
        });
    }

    fn leaves(&self, path: &[&str], span: Span, leaves: &mut Vec<Leaf>) {
        leaves.push(Leaf {
            path: path.iter().map(|part| (*part).to_owned()).collect(),
            span,
            value: self.write(),
        });
    }
}

fn value(node: &Node, key: &str, faults: &mut Faults) -> Option<Vec<String>> {
    let yaml::Value::Sequence(items) = &node.value else {
        return Some(vec![text(node, key, faults)?]);
    };
    within(items.len(), key, node, faults)?;
    items.iter().map(|item| text(item, key, faults)).collect()
}

fn text(node: &Node, key: &str, faults: &mut Faults) -> Option<String> {
    match &node.value {
        yaml::Value::Scalar(text) => Some(text.to_string()),
        _ => wrong(node, key, faults),
    }
}

fn wrong<T>(node: &Node, key: &str, faults: &mut Faults) -> Option<T> {
    let help = "write the values themselves, such as `[1, 2.5, 3]`";
    let wanted = format!("takes {EXPECTED}");
    faults.wrong_shape(&format!("`{key}`"), &wanted, node, help);
    None
}

fn of_json(text: &str) -> Option<Vec<Vec<String>>> {
    let plain = |value: Value| match value {
        Value::String(text) => Some(text),
        Value::Number(number) => Some(number.to_string()),
        Value::Bool(truth) => Some(truth.to_string()),
        Value::Null | Value::Array(_) | Value::Object(_) => None,
    };
    let values: Vec<Value> = serde_json::from_str(text).ok()?;
    let small = |count: usize| count <= MAX_VALUES;
    let values = Some(values).filter(|values| small(values.len()))?;
    let value = |value: Value| match value {
        Value::Array(items) if small(items.len()) => items.into_iter().map(plain).collect(),
        one => Some(vec![plain(one)?]),
    };
    values.into_iter().map(value).collect()
}
