//! Form → YAML, under the keys of the reference library.

use super::place::declared_prefix;
use super::print_yaml::{self, Out};
use super::read_yaml::X_XML;
use super::{
    Beside, FieldKind, FieldType, Form, Held, Scalar, Scope, Stray, Value, Vocabulary, date,
};
use crate::span::Text;
use crate::{xml, yaml};

/// The mapping of a form.
pub fn yaml_of(form: &dyn Form, words: &Vocabulary) -> Out {
    let mut entries: Vec<(String, Out)> = Vec::new();
    for (at, field) in form.form_type().fields.iter().enumerate() {
        let path = field.key().split_once('/');
        // The reference library wants the outer mapping even where there is nothing in it.
        if let Some((outer, _)) = path
            && !entries.iter().any(|(key, _)| key == outer)
            && !form
                .extra()
                .get()
                .keys
                .iter()
                .any(|(key, _)| key.value == outer)
        {
            entries.push((outer.to_owned(), Out::Map(Vec::new())));
        }
        let Some(out) = field_out(field, form.value(at), words) else {
            continue;
        };
        match path {
            None => entries.push((field.key().to_owned(), out)),
            Some((outer, inner)) => {
                let inner = (inner.to_owned(), out);
                match entries.iter_mut().find(|(key, _)| key == outer) {
                    Some((_, Out::Map(entries))) => entries.push(inner),
                    _ => entries.push((outer.to_owned(), Out::Map(vec![inner]))),
                }
            }
        }
    }
    let beside = form.extra().get();
    entries.extend(unknown_xml(beside).map(|out| (X_XML.to_owned(), out)));
    for (key, node) in &beside.keys {
        if !entries.iter().any(|(known, _)| *known == key.value) {
            entries.push((key.value.clone(), node_out(node)));
        }
    }
    Out::Map(entries)
}

fn field_out(field: &FieldType, value: Value<'_>, words: &Vocabulary) -> Option<Out> {
    let list = |forms: &dyn Held| {
        let forms = (0..forms.count()).filter_map(|index| forms.form(index));
        forms.map(|form| yaml_of(form, words)).collect::<Vec<_>>()
    };
    match value {
        Value::Text(text) => text.map(|text| scalar(field.kind, text)),
        Value::Texts([]) => None,
        Value::Texts(texts) => {
            let texts = texts.iter().map(|text| Out::Text(text.value.clone()));
            Some(Out::List(texts.collect()))
        }
        Value::Forms(forms) if forms.count() == 0 => None,
        Value::Forms(forms) => match (field.kind, forms.count()) {
            (FieldKind::One(_) | FieldKind::Some(_), 1) => list(forms).pop(),
            _ => Some(Out::List(list(forms))),
        },
    }
}

pub(super) fn scalar(kind: FieldKind, text: &Text) -> Out {
    let value = text.value.as_str();
    let quoted = || Out::Text(value.to_owned());
    match kind {
        FieldKind::Attribute(Scalar::Number) if is_plain_number(value) => {
            Out::Plain(value.to_owned())
        }
        FieldKind::Attribute(Scalar::Boolean) if matches!(value, "true" | "false") => {
            Out::Plain(value.to_owned())
        }
        FieldKind::Attribute(Scalar::Date) => match date::parts(value) {
            Some(parts) => {
                let part = |(name, value): (&str, String)| (name.to_owned(), Out::Plain(value));
                Out::Map(parts.into_iter().map(part).collect())
            }
            None => quoted(),
        },
        _ => quoted(),
    }
}

/// A number whose spelling every reader of YAML gives back.
fn is_plain_number(value: &str) -> bool {
    let digits = value.strip_prefix('-').unwrap_or(value);
    let (whole, fraction) = match digits.split_once('.') {
        Some((whole, fraction)) => (whole, Some(fraction)),
        None => (digits, None),
    };
    let all = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let plain_fraction = |f: &str| all(f) && f.len() <= 6 && (f == "0" || !f.ends_with('0'));
    all(whole)
        && whole.len() <= 9
        && (whole == "0" || !whole.starts_with('0'))
        && fraction.is_none_or(plain_fraction)
        && !(value.starts_with("-0") && fraction.is_none_or(|f| f == "0"))
}

fn unknown_xml(beside: &Beside) -> Option<Out> {
    let mut entries = Vec::new();
    let attributes = beside.attributes.iter();
    let attributes: Vec<Out> = attributes
        .filter(|a| declared_prefix(&a.qname).is_none())
        .map(|a| {
            let entry = |key: &str, value: &str| (key.to_owned(), Out::Text(value.to_owned()));
            Out::Map(vec![
                entry("name", &a.qname),
                entry("namespace", &a.namespace),
                entry("value", &a.value),
            ])
        })
        .collect();
    let elements = beside.strays.iter().filter_map(|stray| match stray {
        Stray::Element(element) => {
            let mut element = element.clone();
            Scope::default().complete(&mut element);
            Some(Out::Text(xml::print_element(&element, "")))
        }
        _ => None,
    });
    let elements: Vec<Out> = elements.collect();
    let texts = beside.strays.iter().filter_map(|stray| match stray {
        Stray::Text(text) => Some(Out::Text(text.to_string())),
        _ => None,
    });
    let texts: Vec<Out> = texts.collect();
    for (key, list) in [
        ("attributes", attributes),
        ("elements", elements),
        ("texts", texts),
    ] {
        if !list.is_empty() {
            entries.push((key.to_owned(), Out::List(list)));
        }
    }
    (!entries.is_empty()).then_some(Out::Map(entries))
}

/// Keys that no type knows in one line, for an instruction of XML.
pub(super) fn flow_of(keys: &[(Text, yaml::Node)]) -> String {
    let keys = keys
        .iter()
        .map(|(key, node)| (key.value.clone(), node_out(node)));
    // Only a quoted text can hold this letter, and an instruction ends at `?>`.
    print_yaml::flow(&Out::Map(keys.collect())).replace('>', "\\u003E")
}

fn node_out(node: &yaml::Node) -> Out {
    match &node.value {
        yaml::Value::Null => Out::Plain("null".to_owned()),
        yaml::Value::Scalar(text) => Out::Text(text.to_string()),
        yaml::Value::Sequence(items) => Out::List(items.iter().map(node_out).collect()),
        yaml::Value::Mapping(entries) => Out::Map(
            entries
                .iter()
                .map(|(key, node)| (key.value.clone(), node_out(node)))
                .collect(),
        ),
    }
}
