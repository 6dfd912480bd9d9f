//! Whether two forms say the same, wherever and in whatever layout they were written.

use super::place::declared_prefix;
use super::{Beside, Form, Slot, Stray, Value};
use crate::span::Span;
use crate::xml::{Element, Node, is_blank};
use crate::yaml;

/// True when both forms have the same values, unknown elements and unknown attributes. Places, comments, prefixes and
/// the order of different elements do not count.
pub fn same(a: &dyn Form, b: &dyn Form) -> bool {
    let (kind, other) = (a.form_type(), b.form_type());
    std::ptr::eq(kind, other)
        && (0..kind.fields.len()).all(|at| same_value(a.value(at), b.value(at)))
        && same_beside(a.extra().get(), b.extra().get())
}

pub(super) fn same_value(a: Value<'_>, b: Value<'_>) -> bool {
    match (a, b) {
        (Value::Text(a), Value::Text(b)) => a.map(|t| &t.value) == b.map(|t| &t.value),
        (Value::Texts(a), Value::Texts(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.value == b.value)
        }
        (Value::Forms(a), Value::Forms(b)) => {
            a.count() == b.count()
                && (0..a.count()).all(|index| match (a.form(index), b.form(index)) {
                    (Some(a), Some(b)) => same(a, b),
                    _ => false,
                })
        }
        _ => false,
    }
}

pub(super) fn same_beside(a: &Beside, b: &Beside) -> bool {
    let elements = |beside: &Beside| -> Vec<Said> {
        let strays = beside.strays.iter();
        let element = |stray: &Stray| match stray {
            Stray::Element(element) => Some(said(element)),
            _ => None,
        };
        strays.filter_map(element).collect()
    };
    // Two texts become one when nothing is left between them.
    let texts = |beside: &Beside| -> String {
        let strays = beside.strays.iter();
        let text = |stray: &Stray| match stray {
            Stray::Text(text) => text.split_ascii_whitespace().collect(),
            _ => String::new(),
        };
        strays.map(text).collect()
    };
    let same_key = |(a, b): (&(_, yaml::Node), &(_, yaml::Node))| same_node(&a.1, &b.1);
    attributes(&a.attributes) == attributes(&b.attributes)
        && elements(a) == elements(b)
        && texts(a) == texts(b)
        && a.keys.len() == b.keys.len()
        && a.keys
            .iter()
            .zip(&b.keys)
            .all(|(a, b)| a.0.value == b.0.value && same_key((a, b)))
}

fn same_node(a: &yaml::Node, b: &yaml::Node) -> bool {
    use yaml::Value as V;
    match (&a.value, &b.value) {
        (V::Sequence(a), V::Sequence(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same_node(a, b))
        }
        (V::Mapping(a), V::Mapping(b)) => {
            let same = |(a, b): (&(crate::span::Text, yaml::Node), &(_, _))| {
                let b: &(crate::span::Text, yaml::Node) = b;
                a.0.value == b.0.value && same_node(&a.1, &b.1)
            };
            a.len() == b.len() && a.iter().zip(b).all(same)
        }
        (a, b) => a == b,
    }
}

/// Namespace, local name and value of each attribute that declares no prefix, sorted.
type Said3 = (String, String, String);

/// An element without its places, prefixes and layout.
#[derive(PartialEq, Eq)]
enum Said {
    Text(String),
    Element(String, String, Vec<Said3>, Vec<Said>),
}

fn attributes(all: &[crate::xml::Attribute]) -> Vec<Said3> {
    let all = all.iter().filter(|a| declared_prefix(&a.qname).is_none());
    let mut all: Vec<Said3> = all
        .map(|a| {
            (
                a.namespace.to_string(),
                a.local().to_owned(),
                a.value.to_string(),
            )
        })
        .collect();
    all.sort();
    all
}

fn said(element: &Element) -> Said {
    let children = element.children.iter().filter_map(|node| match node {
        Node::Element(child) => Some(said(child)),
        Node::Text(text) if is_blank(text) && element.children.len() > 1 => None,
        Node::Text(text) => Some(Said::Text(text.to_string())),
        Node::Comment(_) | Node::Instruction(_) => None,
    });
    Said::Element(
        element.namespace.to_string(),
        element.local().to_owned(),
        attributes(&element.attributes),
        children.collect(),
    )
}

/// Forgets where everything stood, so that two forms can be compared by `==`.
pub fn strip_places(form: &mut dyn Form) {
    form.stand(Span::default());
    if !form.extra().get().node_order.is_empty() {
        for place in &mut form.extra_mut().edit().node_order {
            place.forget_start();
        }
    }
    for at in 0..form.form_type().fields.len() {
        match form.slot(at) {
            Some(Slot::Text(Some(text))) => text.span = Span::default(),
            Some(Slot::Texts(texts)) => texts.iter_mut().for_each(|t| t.span = Span::default()),
            Some(Slot::Forms(forms)) => {
                for index in 0..forms.count() {
                    if let Some(child) = forms.form_mut(index) {
                        strip_places(child);
                    }
                }
            }
            _ => {}
        }
    }
}

/// Gives everything in an element one place.
pub(super) fn forget(element: &mut Element, span: Span) {
    element.span = span;
    for attribute in &mut element.attributes {
        attribute.span = span;
    }
    for node in &mut element.children {
        if let Node::Element(child) = node {
            forget(child, span);
        }
    }
}
