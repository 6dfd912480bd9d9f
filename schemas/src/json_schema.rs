//! JSON Schemas (2020-12) of the files that people write, made from the types that read them.

use serde_json::{Map, Value, json};
use utoipa::{PartialSchema, ToSchema};

use crate::system::SystemSpec;
use crate::{form, overlay, rtc_profile, rts_profile};

/// A kind of document.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Document {
    /// Deployment overlay.
    Overlay,
    /// RTS Profile, as YAML.
    RtsProfile,
    /// RTC Profile, as YAML.
    RtcProfile,
    /// A system, as the API has it.
    System,
}

/// The schema of a kind of document.
pub fn of(document: Document) -> Value {
    match document {
        Document::Overlay => overlay::schema(),
        Document::RtsProfile => {
            let words = &rts_profile::forms::WORDS;
            form::schema(rts_profile::forms::Profile::form_type(), words)
        }
        Document::RtcProfile => {
            let words = &rtc_profile::forms::WORDS;
            form::schema(rtc_profile::forms::RtcProfile::form_type(), words)
        }
        Document::System => system(),
    }
}

/// As the API describes it, with the references of a schema that stands alone.
fn system() -> Value {
    let mut parts = Vec::new();
    SystemSpec::schemas(&mut parts);
    let mut definitions = Map::new();
    for (name, schema) in parts {
        definitions.insert(name, alone(json!(schema)));
    }
    let mut schema = alone(json!(SystemSpec::schema()));
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema".into();
    schema["title"] = "rtsctl system".into();
    schema["$defs"] = Value::Object(definitions);
    schema
}

fn alone(value: Value) -> Value {
    const COMPONENTS: &str = "#/components/schemas/";
    match value {
        Value::Object(fields) => fields.into_iter().map(|(k, v)| (k, alone(v))).collect(),
        Value::Array(items) => items.into_iter().map(alone).collect(),
        Value::String(text) => match text.strip_prefix(COMPONENTS) {
            Some(name) => Value::String(format!("#/$defs/{name}")),
            None => Value::String(text),
        },
        other => other,
    }
}
