//! Element tree → form.

use super::{FieldKind, FieldType, Form, Place, Slot, Stray, Vocabulary};
use crate::span::Span;
use crate::span::Text;
use crate::xml::{Attribute, Element, Node, is_blank};

/// Fills a form from an element; what has no field is kept beside.
pub fn read_element(from: Element, form: &mut dyn Form, words: &Vocabulary) {
    read(from, form, words, false);
}

/// `preserved`: blanks are no layout here (`xml:space`).
fn read(from: Element, form: &mut dyn Form, words: &Vocabulary, preserved: bool) {
    let preserved = from.preserves_blanks().unwrap_or(preserved);
    form.stand(from.span);
    for attribute in from.attributes {
        read_attribute(attribute, form, words);
    }
    reserve(&from.children, form);
    for node in from.children {
        read_child(node, form, words, preserved);
    }
    form.extra_mut().tidy();
}

/// Room for exactly what comes: a growing list would take up to three times as much.
fn reserve(children: &[Node], form: &mut dyn Form) {
    let fields = form.form_type().fields;
    for (at, field) in fields.iter().enumerate() {
        if !matches!(field.kind, FieldKind::Some(_) | FieldKind::Many(_)) {
            continue;
        }
        let is_own = |node: &&Node| matches!(node, Node::Element(e) if e.local == field.local);
        let count = children.iter().filter(is_own).count();
        if count > 0
            && let Some(Slot::Forms(slot)) = form.slot(at)
        {
            slot.reserve(count);
        }
    }
}

fn read_attribute(attribute: Attribute, form: &mut dyn Form, words: &Vocabulary) {
    let fields = form.form_type().fields;
    let at = attribute_field(fields, &attribute, words);
    if let Some(at) = at
        && let Some(Slot::Text(slot @ None)) = form.slot(at)
    {
        *slot = Some(Text::new(attribute.value, attribute.span));
        let own = *attribute.namespace == *fields[at].namespace;
        let place = place(
            at,
            &fields[at],
            &attribute.qname,
            own,
            Span::default(),
            words,
        );
        form.extra_mut().edit().attribute_order.push(place);
    } else {
        let beside = form.extra_mut().edit();
        beside.attributes.push(attribute);
        beside.attribute_order.push(Place::Other);
    }
}

/// The field of an attribute: in its own namespace, or, as hand-written files have it, in none or a related one.
fn attribute_field(
    fields: &[FieldType],
    attribute: &Attribute,
    words: &Vocabulary,
) -> Option<usize> {
    let named = |f: &FieldType| f.kind.is_attribute() && f.local == attribute.local;
    let related = attribute.namespace.is_empty() || words.knows(&attribute.namespace);
    fields
        .iter()
        .position(|f| named(f) && *f.namespace == *attribute.namespace)
        .or_else(|| fields.iter().position(|f| related && named(f)))
}

fn place(
    at: usize,
    field: &FieldType,
    qname: &str,
    own: bool,
    span: Span,
    words: &Vocabulary,
) -> Place {
    let index = u16::try_from(at).unwrap_or(u16::MAX);
    let start = u32::try_from(span.start).unwrap_or(u32::MAX);
    let usual = own
        && qname.split_once(':').is_some_and(|(prefix, local)| {
            local == field.local && words.prefix(field.namespace) == prefix
        });
    if usual {
        Place::Field(index, start)
    } else {
        Place::Spelled(index, start, qname.into())
    }
}

fn read_child(node: Node, form: &mut dyn Form, words: &Vocabulary, preserved: bool) {
    let stray = match node {
        Node::Comment(text) => Stray::Comment(text),
        Node::Instruction(text) => Stray::Instruction(text),
        Node::Text(text) if is_blank(&text) && !preserved => return,
        Node::Text(text) => Stray::Text(text),
        Node::Element(element) => match fill(element, form, words, preserved) {
            Some(stray) => Stray::Element(stray),
            None => return,
        },
    };
    let beside = form.extra_mut().edit();
    beside.strays.push(stray);
    beside.node_order.push(Place::Other);
}

/// Gives the element back when it has no field, or no more room in it.
fn fill(
    element: Box<Element>,
    form: &mut dyn Form,
    words: &Vocabulary,
    preserved: bool,
) -> Option<Box<Element>> {
    let fields = form.form_type().fields;
    let found = fields.iter().position(|f| {
        !f.kind.is_attribute() && f.local == element.local && *f.namespace == *element.namespace
    });
    let Some(at) = found else {
        return Some(element);
    };
    let place = place(at, &fields[at], &element.qname, true, element.span, words);
    match form.slot(at) {
        Some(Slot::Text(slot @ None)) if is_text(&element) => *slot = Some(text_of(*element)),
        Some(Slot::Texts(slot)) if is_text(&element) => slot.push(text_of(*element)),
        Some(Slot::Forms(slot)) => match slot.add(usize::MAX) {
            Some(child) => read(*element, child, words, preserved),
            None => return Some(element),
        },
        _ => return Some(element),
    }
    form.extra_mut().edit().node_order.push(place);
    None
}

fn is_text(element: &Element) -> bool {
    element.attributes.is_empty() && matches!(element.children.as_slice(), [] | [Node::Text(_)])
}

fn text_of(element: Element) -> Text {
    match element.children.into_iter().next() {
        Some(Node::Text(text)) => Text::new(text, element.span),
        _ => Text::new(String::new(), element.span),
    }
}

/// True when elements of the field may stand only once.
pub(super) fn is_single(kind: FieldKind) -> bool {
    matches!(kind, FieldKind::Text | FieldKind::One(_))
}
