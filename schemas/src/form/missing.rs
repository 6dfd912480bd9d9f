//! What one form says and another does not, which was made from it.

use std::collections::BTreeMap;

use super::place::declared_prefix;
use super::{Beside, FieldType, Form, FormType, Held, Stray, Value};
use crate::span::{Span, Text};
use crate::xml::is_blank;

/// Something that is missing.
#[derive(Debug, Clone, Copy)]
pub struct Missing<'a> {
    /// Where it stood.
    pub span: Span,
    /// The type that had it.
    pub of: &'static FormType,
    /// What it is.
    pub what: What<'a>,
}

/// What is missing.
#[derive(Debug, Clone, Copy)]
pub enum What<'a> {
    /// A text, or an element with all in it.
    Value(&'static FieldType, Option<&'a Text>),
    /// All elements are there, in another order.
    Order(&'static FieldType),
    /// An attribute that no type knows.
    Attribute(&'a str),
    /// An element that no type knows.
    Element(&'a str),
    /// A key of YAML that no type knows.
    Key(&'a str),
    /// Text between elements.
    Text,
    /// A comment or an instruction.
    Comment,
}

/// What counts as the same.
pub struct Alike<'a> {
    /// Fields (name of the type, name of the field) that are not compared.
    pub ignored: &'a [(&'static str, &'static str)],
    /// Whether two different texts of a field mean the same.
    pub texts: &'a dyn Fn(&FormType, &FieldType, &str, &str) -> bool,
}

/// All that `old` says and `new` does not: each element once, with all in it. What is new is not named.
pub fn missing<'a>(old: &'a dyn Form, new: &dyn Form, alike: &Alike<'_>) -> Vec<Missing<'a>> {
    let mut all = Vec::new();
    compare(old, new, alike, &mut all);
    all
}

fn compare<'a>(old: &'a dyn Form, new: &dyn Form, alike: &Alike<'_>, all: &mut Vec<Missing<'a>>) {
    let of = old.form_type();
    for (at, field) in of.fields.iter().enumerate() {
        if alike.ignored.contains(&(of.name, field.name)) {
            continue;
        }
        let lacks = |text: &'a Text| Missing {
            span: known(text.span, old),
            of,
            what: What::Value(field, Some(text)),
        };
        let same =
            |a: &Text, b: &Text| a.value == b.value || (alike.texts)(of, field, &a.value, &b.value);
        match (old.value(at), new.value(at)) {
            (Value::Text(Some(text)), Value::Text(other)) => {
                let kept = other.is_some_and(|other| same(text, other));
                all.extend((!kept).then(|| lacks(text)));
            }
            (Value::Texts(texts), Value::Texts(others)) => {
                let mut others: Vec<&Text> = others.iter().collect();
                let gone = texts.iter().filter(|text| {
                    let at = others.iter().position(|other| same(text, other));
                    at.map(|at| others.remove(at)).is_none()
                });
                all.extend(gone.map(lacks));
            }
            (Value::Forms(forms), Value::Forms(others)) => {
                compare_forms((old, field), forms, others, alike, all);
            }
            _ => {}
        }
    }
    beside(old, new.extra().get(), all);
}

fn compare_forms<'a>(
    (old, field): (&'a dyn Form, &'static FieldType),
    forms: &'a dyn Held,
    others: &dyn Held,
    alike: &Alike<'_>,
    all: &mut Vec<Missing<'a>>,
) {
    let of = old.form_type();
    let mut last = 0;
    let mut sorted = true;
    let pairs = pairs(forms, others);
    for (index, other) in pairs.into_iter().enumerate() {
        let Some(form) = forms.form(index) else {
            continue;
        };
        match other.and_then(|at| Some((at, others.form(at)?))) {
            Some((at, other)) => {
                sorted &= at >= last;
                last = at;
                compare(form, other, alike, all);
            }
            None => all.push(Missing {
                span: known(form.span(), old),
                of,
                what: What::Value(field, None),
            }),
        }
    }
    if !sorted {
        let first = forms.form(0).map_or(old.span(), Form::span);
        all.push(Missing {
            span: known(first, old),
            of,
            what: What::Order(field),
        });
    }
}

/// For each of the old forms the new one that came of it: they stood at the same place, or else come in the same order.
fn pairs(old: &dyn Held, new: &dyn Held) -> Vec<Option<usize>> {
    let start = |form: &dyn Form| (!form.span().is_unknown()).then_some(form.span().start);
    let mut places: BTreeMap<u32, usize> = BTreeMap::new();
    for index in (0..new.count()).rev() {
        if let Some(at) = new.form(index).and_then(start) {
            places.insert(at, index);
        }
    }
    let mut pairs: Vec<Option<usize>> = (0..old.count())
        .map(|index| places.remove(&start(old.form(index)?)?))
        .collect();
    let mut used = vec![false; new.count()];
    for index in pairs.iter().flatten() {
        used[*index] = true;
    }
    let mut free = (0..new.count()).filter(|index| !used[*index]);
    for pair in pairs.iter_mut().filter(|pair| pair.is_none()) {
        *pair = free.next();
    }
    pairs
}

fn beside<'a>(old: &'a dyn Form, new: &Beside, all: &mut Vec<Missing<'a>>) {
    let beside = old.extra().get();
    let mut lacks = |span, what| {
        all.push(Missing {
            span: known(span, old),
            of: old.form_type(),
            what,
        });
    };
    for attribute in &beside.attributes {
        let has = |other: &crate::xml::Attribute| {
            (&other.namespace, other.local(), &other.value)
                == (&attribute.namespace, attribute.local(), &attribute.value)
        };
        if declared_prefix(&attribute.qname).is_none() && !new.attributes.iter().any(has) {
            lacks(attribute.span, What::Attribute(&attribute.qname));
        }
    }
    let mut others: Vec<&Stray> = new.strays.iter().collect();
    for stray in &beside.strays {
        if let Some(at) = others.iter().position(|other| *other == stray) {
            others.remove(at);
            continue;
        }
        match stray {
            Stray::Element(element) => lacks(element.span, What::Element(&element.qname)),
            Stray::Comment(_) | Stray::Instruction(_) => lacks(Span::default(), What::Comment),
            Stray::Text(text) if is_blank(text) => {}
            Stray::Text(_) => lacks(Span::default(), What::Text),
        }
    }
    for (key, node) in &beside.keys {
        let has = |(other, value): &(Text, _)| other.value == key.value && value == node;
        if !new.keys.iter().any(has) {
            lacks(key.span, What::Key(&key.value));
        }
    }
}

/// The place of the form around it where its own is not known.
fn known(span: Span, form: &dyn Form) -> Span {
    match span.is_unknown() {
        true => form.span(),
        false => span,
    }
}
