//! Form → element tree: in the order in which it was read, and what is new where the schema has it.

use super::order::{attribute_order, node_order};
use super::place::{declaration, prefix_of};
use super::read_xml::X_YAML;
use super::write_yaml::flow_of;
use super::{FieldType, Form, Scope, Stray, Value, Vocabulary};
use crate::span::{Span, Text};
use crate::xml::{Attribute, Element, Node};

/// The element of a form, under a name, with the declarations in force around it.
pub fn element_of(
    form: &dyn Form,
    (namespace, qname): (&str, &str),
    scope: &mut Scope,
    words: &Vocabulary,
) -> Element {
    let depth = scope.depth();
    let beside = form.extra().get();
    scope.enter(&beside.attributes);
    let mut element = Element {
        namespace: namespace.into(),
        qname: qname.into(),
        attributes: Vec::new(),
        children: Vec::new(),
        span: Span::default(),
    };
    attributes(form, &mut element, scope, words);
    children(form, &mut element, scope, words);
    scope.leave(depth);
    element
}

fn attributes(form: &dyn Form, element: &mut Element, scope: &mut Scope, words: &Vocabulary) {
    let beside = form.extra().get();
    let fields = form.form_type().fields;
    let mut others = beside.attributes.iter();
    for place in attribute_order(form, &beside.attribute_order, beside.attributes.len()) {
        let Some(at) = place.field() else {
            if let Some(other) = others.next() {
                need(prefix_of(&other.qname), &other.namespace, element, scope);
                element.attributes.push(other.clone());
            }
            continue;
        };
        let Value::Text(Some(text)) = form.value(at) else {
            continue;
        };
        let name = Name::of(&fields[at], beside.spelling(place), true, scope, words);
        if let Some(prefix) = &name.new_prefix {
            scope.declare(prefix, &name.namespace);
            let made = declaration(prefix, &name.namespace);
            element.attributes.push(made);
        }
        element.attributes.push(Attribute {
            namespace: name.namespace.as_str().into(),
            qname: name.qname.into(),
            value: text.value.as_str().into(),
            span: Span::default(),
        });
    }
}

/// Declares a prefix that an attribute without a field brings with it.
fn need(prefix: &str, namespace: &str, element: &mut Element, scope: &mut Scope) {
    if !matches!(prefix, "" | "xmlns") && scope.namespace(prefix) != Some(namespace) {
        scope.declare(prefix, namespace);
        element.attributes.push(declaration(prefix, namespace));
    }
}

fn children(form: &dyn Form, element: &mut Element, scope: &mut Scope, words: &Vocabulary) {
    let beside = form.extra().get();
    let fields = form.form_type().fields;
    // XML has no place for keys of YAML, but every reader of XML passes over instructions.
    if !beside.keys.is_empty() {
        let text = format!("{X_YAML} {}", flow_of(&beside.keys));
        element.children.push(Node::Instruction(text.into()));
    }
    let mut strays = beside.strays.iter();
    let mut next = vec![0; fields.len()];
    for place in node_order(form, &beside.node_order, beside.strays.len()) {
        let Some(at) = place.field() else {
            element
                .children
                .extend(strays.next().map(|s| stray(s, scope)));
            continue;
        };
        let number = next[at];
        next[at] += 1;
        let name = Name::of(&fields[at], beside.spelling(place), false, scope, words);
        // It is declared out here: an element of text has no attributes of its own.
        if let Some(prefix) = &name.new_prefix {
            scope.declare(prefix, &name.namespace);
            element
                .attributes
                .push(declaration(prefix, &name.namespace));
        }
        let full = (name.namespace.as_str(), name.qname.as_str());
        let child = match form.value(at) {
            Value::Text(text) => text.map(|text| text_element(full, text)),
            Value::Texts(texts) => texts.get(number).map(|text| text_element(full, text)),
            Value::Forms(forms) => forms
                .form(number)
                .map(|child| element_of(child, full, scope, words)),
        };
        element
            .children
            .extend(child.map(|child| Node::Element(Box::new(child))));
    }
}

fn stray(stray: &Stray, scope: &mut Scope) -> Node {
    match stray {
        Stray::Element(element) => {
            let mut element = element.clone();
            scope.complete(&mut element);
            Node::Element(element)
        }
        Stray::Comment(text) => Node::Comment(text.clone()),
        Stray::Instruction(text) => Node::Instruction(text.clone()),
        Stray::Text(text) => Node::Text(text.clone()),
    }
}

fn text_element((namespace, qname): (&str, &str), text: &Text) -> Element {
    let children = match text.value.as_str() {
        "" => Vec::new(),
        text => vec![Node::Text(text.into())],
    };
    Element {
        namespace: namespace.into(),
        qname: qname.into(),
        attributes: Vec::new(),
        children,
        span: Span::default(),
    }
}

/// How a field is called here.
pub(super) struct Name {
    pub(super) namespace: String,
    pub(super) qname: String,
    /// A prefix that has to be declared.
    pub(super) new_prefix: Option<String>,
}

impl Name {
    pub(super) fn of(
        field: &FieldType,
        spelling: Option<&str>,
        attribute: bool,
        scope: &Scope,
        words: &Vocabulary,
    ) -> Self {
        if let Some(qname) = spelling
            && let Some(namespace) = spelled(qname, field, attribute, scope, words)
        {
            return Self {
                namespace,
                qname: qname.to_owned(),
                new_prefix: None,
            };
        }
        let usual = words.prefix(field.namespace);
        let (prefix, new_prefix) = match scope.prefix(field.namespace, usual, attribute) {
            Some(prefix) => (prefix.to_owned(), None),
            None => {
                let prefix = scope.free(usual);
                (prefix.clone(), Some(prefix))
            }
        };
        let qname = match prefix.as_str() {
            "" => field.local.to_owned(),
            prefix => format!("{prefix}:{}", field.local),
        };
        Self {
            namespace: field.namespace.to_owned(),
            qname,
            new_prefix,
        }
    }
}

/// The namespace of a spelling, when it still means the field here.
fn spelled(
    qname: &str,
    field: &FieldType,
    attribute: bool,
    scope: &Scope,
    words: &Vocabulary,
) -> Option<String> {
    let namespace = match prefix_of(qname) {
        "" if attribute => "",
        prefix => scope.namespace(prefix)?,
    };
    let means = namespace == field.namespace
        || (attribute && (namespace.is_empty() || words.knows(namespace)));
    means.then(|| namespace.to_owned())
}
