//! JSON Schema (2020-12) of the types.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use super::{YamlType, text_of};

/// The dialect of the schemas.
const DIALECT: &str = "https://json-schema.org/draft/2020-12/schema";

/// Types with a name.
#[derive(Debug, Default)]
pub struct Definitions(BTreeMap<String, Value>);

impl Definitions {
    /// A reference to a type, which is described once.
    pub fn refer(&mut self, name: &str, describe: impl FnOnce(&mut Self) -> Object) -> Value {
        if !self.0.contains_key(name) {
            // Before the description: a type may lead back to itself.
            self.0.insert(name.to_owned(), Value::Null);
            let object = describe(self).value;
            self.0.insert(name.to_owned(), object);
        }
        json!({"$ref": format!("#/$defs/{name}")})
    }
}

/// The schema of a mapping with known keys.
#[derive(Debug)]
pub struct Object {
    value: Value,
}

impl Object {
    /// Without keys. Keys may be written with the prefix too, when there is one.
    pub fn new(doc: &str, prefix: Option<&str>) -> Self {
        let mut value = json!({
            "type": "object",
            "description": text_of(doc),
            "properties": {},
            "additionalProperties": false,
        });
        if let Some(prefix) = prefix {
            let pattern = format!("^{}", prefix.replace('.', "\\."));
            let old =
                json!({"deprecated": true, "description": "The same key without the prefix."});
            value["patternProperties"] = json!({pattern: old});
        }
        Self { value }
    }

    /// Adds a key.
    pub fn key(&mut self, key: &str, doc: &str, schema: Value, required: bool) {
        let mut schema = if required { schema } else { nullable(schema) };
        if let Some(object) = schema.as_object_mut() {
            object.insert("description".to_owned(), Value::String(text_of(doc)));
        }
        self.value["properties"][key] = schema;
        if required {
            let list = self.value.as_object_mut().map(|object| {
                object
                    .entry("required")
                    .or_insert_with(|| Value::Array(Vec::new()))
            });
            if let Some(Value::Array(keys)) = list {
                keys.push(Value::String(key.to_owned()));
            }
        }
    }
}

/// The schema, or `null`.
pub(super) fn nullable(schema: Value) -> Value {
    match schema {
        Value::Object(mut object) => match object.get_mut("anyOf") {
            Some(Value::Array(choices)) => {
                choices.push(json!({"type": "null"}));
                Value::Object(object)
            }
            _ => json!({"anyOf": [Value::Object(object), {"type": "null"}]}),
        },
        other => other,
    }
}

/// The schema of a document.
pub fn schema_of<T: YamlType>(title: &str) -> Value {
    let mut definitions = Definitions::default();
    let root = T::schema(&mut definitions);
    let mut schema = Map::new();
    schema.insert("$schema".to_owned(), DIALECT.into());
    schema.insert("title".to_owned(), title.into());
    if let Value::Object(root) = root {
        schema.extend(root);
    }
    schema.insert("$defs".to_owned(), json!(definitions.0));
    Value::Object(schema)
}
