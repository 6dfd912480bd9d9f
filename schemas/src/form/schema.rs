//! JSON Schema (2020-12) of the YAML form of a profile.

use serde_json::{Map, Value, json};

use super::{FieldKind, FieldType, FormType, Scalar, Vocabulary};

/// The schema of a document: a mapping with the root key. Elements that no type knows are allowed, since they are kept.
pub fn schema(root: &'static FormType, words: &Vocabulary) -> Value {
    let mut definitions = Map::new();
    let reference = refer(root, &mut definitions);
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": format!("{} (YAML)", words.title),
        "type": "object",
        "properties": {words.key: reference},
        "required": [words.key],
        "$defs": definitions,
    })
}

fn refer(form: &'static FormType, definitions: &mut Map<String, Value>) -> Value {
    if !definitions.contains_key(form.name) {
        // Before its description: a type may lead back to itself.
        definitions.insert(form.name.to_owned(), Value::Null);
        let described = describe(form, definitions);
        definitions.insert(form.name.to_owned(), described);
    }
    json!({"$ref": format!("#/$defs/{}", form.name)})
}

fn describe(form: &'static FormType, definitions: &mut Map<String, Value>) -> Value {
    let mut properties = Map::new();
    for field in form.fields {
        let schema = schema_of(field, definitions);
        for (index, path) in field.keys.split('|').enumerate() {
            let mut schema = schema.clone();
            schema["description"] = crate::docs::text(field.doc).into();
            if index > 0 {
                schema["deprecated"] = true.into();
            }
            insert(&mut properties, path, schema);
        }
    }
    let object = json!({"type": "object", "properties": properties});
    let mut own = form.fields.iter().filter(|field| field.local != "type");
    let mut described = match (own.next(), own.next()) {
        // `or: [...]` for `or: {constraint: [...]}`.
        (Some(only), None) => json!({"anyOf": [object, schema_of(only, definitions)]}),
        _ => object,
    };
    described["description"] = crate::docs::text(form.doc).into();
    described
}

/// `a/b` is the key `b` in a mapping under `a`.
fn insert(properties: &mut Map<String, Value>, path: &str, schema: Value) {
    match path.split_once('/') {
        None => {
            properties.insert(path.to_owned(), schema);
        }
        Some((outer, inner)) => {
            let entry = properties
                .entry(outer)
                .or_insert_with(|| json!({"type": "object"}));
            entry["properties"][inner] = schema;
        }
    }
}

fn schema_of(field: &FieldType, definitions: &mut Map<String, Value>) -> Value {
    match field.kind {
        FieldKind::Attribute(Scalar::Date) => json!({"type": ["string", "object", "null"]}),
        FieldKind::Attribute(_) | FieldKind::Text => {
            json!({"type": ["string", "number", "boolean", "null"]})
        }
        FieldKind::Texts => {
            let text = json!({"type": ["string", "number", "boolean", "null"]});
            json!({"anyOf": [text, {"type": "array", "items": text}]})
        }
        FieldKind::One(of) => {
            json!({"anyOf": [refer(of(), definitions), {"type": "null"}]})
        }
        FieldKind::Some(of) | FieldKind::Many(of) => {
            let one = refer(of(), definitions);
            json!({"anyOf": [one, {"type": "array", "items": one}, {"type": "null"}]})
        }
    }
}
