//! The documentation of overlays, from their JSON Schema, which is made of the types.

use std::sync::Arc;

use serde_json::Value;

use super::{Docs, Facts, Field, Inner};
use crate::overlay;

/// What is said of an overlay.
pub(super) fn deployment() -> Docs {
    let schema = Arc::new(overlay::schema());
    let (name, root) = resolved(&schema, &schema);
    of(&schema, name.unwrap_or("Deployment"), root)
}

fn of(root: &Arc<Value>, name: &str, schema: &Value) -> Docs {
    let properties = schema["properties"].as_object();
    let required = |key: &str| {
        let keys = schema["required"].as_array().into_iter().flatten();
        keys.into_iter().any(|other| other == key)
    };
    let fields = properties.into_iter().flatten();
    Docs {
        name: name.to_owned(),
        text: description(schema),
        fields: fields
            .map(|(key, schema)| field(root, key, schema, required(key)))
            .collect(),
    }
}

fn field(root: &Arc<Value>, key: &str, schema: &Value, required: bool) -> Field {
    let shape = Shape::of(root, schema);
    let facts = Facts {
        values: shape.values,
        required: required.then(|| "by the format".to_owned()),
        ..Facts::default()
    };
    let inner = shape.inner.map(|(name, schema)| {
        let root = Arc::clone(root);
        Inner::new(move || of(&root, &name, &schema))
    });
    Field {
        name: key.to_owned(),
        others: Vec::new(),
        xml: None,
        yaml: None,
        kind: shape.kind,
        text: description(schema),
        facts,
        inner,
    }
}

/// What a schema allows.
#[derive(Default)]
struct Shape {
    kind: String,
    values: Vec<String>,
    /// Name and schema of the mapping that it leads to.
    inner: Option<(String, Value)>,
}

impl Shape {
    fn of(root: &Value, schema: &Value) -> Self {
        let (name, schema) = resolved(root, schema);
        let within = |prefix: &str, inner: &Value| {
            let mut shape = Self::of(root, inner);
            shape.kind.insert_str(0, prefix);
            shape
        };
        if schema["properties"].is_object() {
            let name = name.unwrap_or("object").to_owned();
            return Self {
                kind: name.clone(),
                values: Vec::new(),
                inner: Some((name, schema.clone())),
            };
        }
        if schema["items"].is_object() {
            return within("[]", &schema["items"]);
        }
        if schema["additionalProperties"].is_object() {
            return within("map[string]", &schema["additionalProperties"]);
        }
        let words = schema["enum"].as_array().into_iter().flatten();
        let words = words.chain(schema.get("const"));
        let word = |value: &Value| match value {
            Value::String(text) => text.clone(),
            other => other.to_string(),
        };
        let kind = match schema["type"].as_str() {
            Some("integer") => "number",
            Some(kind) => kind,
            None => "string",
        };
        Self {
            kind: kind.to_owned(),
            values: words.filter(|value| !value.is_null()).map(word).collect(),
            inner: None,
        }
    }
}

/// The schema that is meant, and its name: references are followed, and of a choice the first is taken that says most.
fn resolved<'a>(root: &'a Value, schema: &'a Value) -> (Option<&'a str>, &'a Value) {
    const DEEPEST: usize = 16;
    let (mut name, mut schema) = (None, schema);
    for _ in 0..DEEPEST {
        if let Some(reference) = schema["$ref"].as_str() {
            name = reference.rsplit('/').next();
            schema = root
                .pointer(reference.trim_start_matches('#'))
                .unwrap_or(schema);
        } else if let Some(choices) = schema["anyOf"].as_array() {
            let holds = |choice: &&Value| {
                let keys = ["$ref", "properties", "items", "additionalProperties"];
                keys.iter().any(|key| choice.get(key).is_some())
            };
            let said = |choice: &&Value| choice["type"] != "null";
            let choice = choices
                .iter()
                .find(holds)
                .or_else(|| choices.iter().find(said));
            let Some(choice) = choice else { break };
            schema = choice;
        } else {
            break;
        }
    }
    (name, schema)
}

fn description(schema: &Value) -> String {
    schema["description"]
        .as_str()
        .unwrap_or_default()
        .to_owned()
}
