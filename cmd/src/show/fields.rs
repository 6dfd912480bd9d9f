//! What is said of a field, as `kubectl explain` shows it.

use rts_schemas::docs::{Docs, Facts, Field, Found, Inner};
use serde_json::{Value, json};

/// Width of a line.
const WIDTH: usize = 80;

/// For people.
pub fn text(found: &Found, recursive: bool) -> String {
    let mut text = format!("KIND:    {}\n", found.root.title);
    match &found.field {
        None => text.push_str(&format!("ROOT:    {}\n", found.root.written)),
        Some(field) => {
            let required = required(field);
            text.push_str(&format!(
                "FIELD:   {} <{}>{required}\n",
                found.path, field.kind
            ));
            let xml = field.xml.iter().map(|xml| format!("XML:     {xml}\n"));
            let yaml = field.yaml.iter().map(|yaml| format!("YAML:    {yaml}:\n"));
            text.extend(xml.chain(yaml));
            if field.kind.starts_with("map[") {
                text.push_str(&format!("KEYS:    any name, as in {}.NAME\n", found.path));
            }
            text.push_str(&facts(&field.facts, ""));
        }
    }
    text.push_str("\nDESCRIPTION:\n");
    let field = found.field.as_ref().map(|field| field.text.as_str());
    let docs = found.docs.as_ref().map(|docs| docs.text.as_str());
    let mut said: Vec<&str> = field.into_iter().chain(docs).collect();
    said.dedup();
    for paragraph in said.iter().flat_map(|said| said.lines()) {
        text.push_str(&wrapped(paragraph, "    "));
    }
    if let Some(docs) = &found.docs {
        text.push_str("\nFIELDS:\n");
        match recursive {
            true => tree(docs, 1, &mut vec![docs.name.clone()], &mut text),
            false => list(docs, &mut text),
        }
    }
    text
}

fn head(field: &Field, indent: &str) -> String {
    let required = required(field);
    format!("{indent}{} <{}>{required}\n", field.name, field.kind)
}

/// The schema demands it; readers are more tolerant.
fn required(field: &Field) -> &'static str {
    field.facts.required.as_ref().map_or("", |_| " -required-")
}

fn list(docs: &Docs, text: &mut String) {
    let all: Vec<String> = docs
        .fields
        .iter()
        .map(|field| {
            let mut one = head(field, "  ");
            for paragraph in field.text.lines() {
                one.push_str(&wrapped(paragraph, "    "));
            }
            one + &facts(&field.facts, "    ")
        })
        .collect();
    text.push_str(&all.join("\n"));
}

/// `around` are the types that hold this one: what holds itself is shown once.
fn tree(docs: &Docs, depth: usize, around: &mut Vec<String>, text: &mut String) {
    for field in &docs.fields {
        text.push_str(&head(field, &"  ".repeat(depth)));
        let Some(inner) = field.inner.as_ref().map(Inner::docs) else {
            continue;
        };
        if !around.contains(&inner.name) {
            around.push(inner.name.clone());
            tree(&inner, depth + 1, around, text);
            around.pop();
        }
    }
}

fn facts(facts: &Facts, indent: &str) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: &str| {
        text.push_str(&format!("{indent}{:<9}{value}\n", format!("{name}:")));
    };
    if !facts.values.is_empty() {
        line("ENUM", &facts.values.join(", "));
    }
    let others = [
        ("DEFAULT", &facts.default),
        ("UNIT", &facts.unit),
        ("VERSION", &facts.versions),
    ];
    for (name, value) in others {
        if let Some(value) = value {
            line(name, value);
        }
    }
    text
}

/// Lines of words, all indented.
fn wrapped(text: &str, indent: &str) -> String {
    let mut lines = String::new();
    let mut length = 0;
    for word in text.split_whitespace() {
        let width = word.chars().count();
        if length > 0 && length + 1 + width > WIDTH {
            lines.push('\n');
            length = 0;
        }
        if length == 0 {
            lines.push_str(indent);
            length = indent.len();
        } else {
            lines.push(' ');
            length += 1;
        }
        lines.push_str(word);
        length += width;
    }
    lines.push('\n');
    lines
}

/// For programs.
pub fn value(found: &Found, recursive: bool) -> Value {
    let mut value = match &found.field {
        Some(field) => of_field(field),
        None => json!({ "name": found.root.name }),
    };
    value["kind"] = json!(found.root.title);
    value["path"] = json!(found.path);
    if let Some(docs) = &found.docs {
        let around = recursive.then(|| vec![docs.name.clone()]);
        value["type"] = json!(docs.name);
        value["fields"] = of_docs(docs, around);
        if found.field.is_none() {
            value["description"] = json!(docs.text);
        }
    }
    value
}

fn of_docs(docs: &Docs, around: Option<Vec<String>>) -> Value {
    let fields = docs.fields.iter().map(|field| {
        let mut value = of_field(field);
        if let (Some(around), Some(inner)) = (&around, &field.inner) {
            let inner = inner.docs();
            if !around.contains(&inner.name) {
                let mut around = around.clone();
                around.push(inner.name.clone());
                value["fields"] = of_docs(&inner, Some(around));
            }
        }
        value
    });
    Value::Array(fields.collect())
}

fn of_field(field: &Field) -> Value {
    let facts = &field.facts;
    let mut value = json!({
        "name": field.name,
        "type": field.kind,
        "description": field.text,
        "required": facts.required.is_some(),
    });
    let optional = [
        ("xml", &field.xml),
        ("yaml", &field.yaml),
        ("default", &facts.default),
        ("unit", &facts.unit),
        ("versions", &facts.versions),
    ];
    for (name, said) in optional {
        if let Some(said) = said {
            value[name] = json!(said);
        }
    }
    if !facts.values.is_empty() {
        value["values"] = json!(facts.values);
    }
    value
}
