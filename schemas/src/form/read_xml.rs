//! Element tree → form.

use super::allowance::Allowance;
use super::write_yaml::flow_of;
use super::{Beside, FieldKind, FieldType, Form, Place, Slot, Stray, Vocabulary};
use crate::span::Text;
use crate::xml::{Attribute, Element, Node, is_blank};
use crate::yaml;

/// Name of the instruction that keeps keys of YAML.
pub(super) const X_YAML: &str = "x-yaml";

/// Fills a form from an element; what has no field is kept beside.
pub fn read_element(from: Element, form: &mut dyn Form, words: &Vocabulary) {
    read_some(from, form, words, &mut Allowance::unlimited());
}

/// As [`read_element`], until the allowance is spent.
pub(super) fn read_some(
    from: Element,
    form: &mut dyn Form,
    words: &Vocabulary,
    allowance: &mut Allowance,
) {
    read(from, form, words, false, allowance);
}

/// `preserved`: blanks are no layout here (`xml:space`).
fn read(
    from: Element,
    form: &mut dyn Form,
    words: &Vocabulary,
    preserved: bool,
    allowance: &mut Allowance,
) {
    let preserved = from.preserves_blanks().unwrap_or(preserved);
    form.stand(from.span);
    for attribute in from.attributes {
        read_attribute(attribute, form, words);
    }
    let fields: Vec<Option<u16>> = from
        .children
        .iter()
        .map(|node| child_field(form, node))
        .collect();
    if !reserve(&fields, form, allowance) {
        return;
    }
    for (node, at) in from.children.into_iter().zip(fields) {
        if allowance.is_spent() {
            return;
        }
        read_child(node, at, form, words, preserved, allowance);
    }
    form.extra_mut().tidy();
    if !form.extra().is_empty() {
        allowance.take(1, size_of::<Beside>());
    }
}

/// The field of a child element.
fn child_field(form: &dyn Form, node: &Node) -> Option<u16> {
    let Node::Element(element) = node else {
        return None;
    };
    let mut fields = form.form_type().fields.iter();
    let at = fields.position(|f| {
        !f.kind.is_attribute() && f.local == element.local() && *f.namespace == *element.namespace
    })?;
    u16::try_from(at).ok()
}

/// Room for exactly what comes: a growing list would take up to three times as much.
fn reserve(children: &[Option<u16>], form: &mut dyn Form, allowance: &mut Allowance) -> bool {
    let fields = form.form_type().fields;
    let mut counts = vec![0_usize; fields.len()];
    for at in children.iter().flatten() {
        counts[usize::from(*at)] += 1;
    }
    for (at, count) in counts.into_iter().enumerate().filter(|(_, n)| *n > 0) {
        let Some(of) = fields[at].kind.form_type() else {
            continue;
        };
        if !allowance.take(count, of.size) {
            return false;
        }
        if let Some(Slot::Forms(slot)) = form.slot(at) {
            slot.reserve(count);
        }
    }
    true
}

fn read_attribute(attribute: Attribute, form: &mut dyn Form, words: &Vocabulary) {
    let fields = form.form_type().fields;
    let at = attribute_field(fields, &attribute, words);
    if let Some(at) = at
        && let Some(Slot::Text(slot @ None)) = form.slot(usize::from(at))
    {
        *slot = Some(Text::new(attribute.value, attribute.span));
        let own = *attribute.namespace == *fields[usize::from(at)].namespace;
        let beside = form.extra_mut().edit();
        let place = match own && is_usual(&fields[usize::from(at)], &attribute.qname, words) {
            true => Place::Field(at, 0),
            false => beside.spell(at, 0, &attribute.qname),
        };
        beside.attribute_order.push(place);
    } else {
        let beside = form.extra_mut().edit();
        beside.attributes.push(attribute);
        beside.attribute_order.push(Place::Other);
    }
}

/// The field of an attribute: in its own namespace, or, as hand-written files have it, in none or a related one. Then a
/// field of the profile's own namespace goes first: `type` of a port is its data type, not `xsi:type`.
fn attribute_field(fields: &[FieldType], attribute: &Attribute, words: &Vocabulary) -> Option<u16> {
    let named = |f: &FieldType| f.kind.is_attribute() && f.local == attribute.local();
    let within = |namespace: &str| {
        let mut fields = fields.iter();
        fields.position(|f| named(f) && f.namespace == namespace)
    };
    let related = attribute.namespace.is_empty() || words.knows(&attribute.namespace);
    let at = within(&attribute.namespace)
        .or_else(|| within(words.namespace).filter(|_| related))
        .or_else(|| fields.iter().position(|f| related && named(f)))?;
    u16::try_from(at).ok()
}

/// True when a name is written as this program writes it.
fn is_usual(field: &FieldType, qname: &str, words: &Vocabulary) -> bool {
    qname.split_once(':').is_some_and(|(prefix, local)| {
        local == field.local && words.prefix(field.namespace) == prefix
    })
}

fn read_child(
    node: Node,
    at: Option<u16>,
    form: &mut dyn Form,
    words: &Vocabulary,
    preserved: bool,
    allowance: &mut Allowance,
) {
    let stray = match node {
        Node::Comment(text) => Stray::Comment(text),
        Node::Instruction(text) => match yaml_keys(&text) {
            // Only the first of them: keys are unique.
            Some(keys) if form.extra().get().keys.is_empty() => {
                form.extra_mut().edit().keys = keys.into_vec();
                return;
            }
            _ => Stray::Instruction(text),
        },
        Node::Text(text) if is_blank(&text) && !preserved => return,
        Node::Text(text) => Stray::Text(text),
        Node::Element(element) => match at {
            None => Stray::Element(element),
            Some(at) => match fill(element, at, form, words, preserved, allowance) {
                Some(stray) => Stray::Element(stray),
                None => return,
            },
        },
    };
    let beside = form.extra_mut().edit();
    beside.strays.push(stray);
    beside.node_order.push(Place::Other);
}

/// Keys of YAML that an instruction keeps, as this program writes it; their places are not known.
fn yaml_keys(instruction: &str) -> Option<Box<[(Text, yaml::Node)]>> {
    let text = instruction.strip_prefix(X_YAML)?.strip_prefix(' ')?;
    let node = yaml::parse_quietly(text)?.without_places();
    let known = flow_of(node.entries()) == text;
    match node.value {
        yaml::Value::Mapping(entries) if known && !entries.is_empty() => Some(entries),
        _ => None,
    }
}

/// Gives the element back when there is no more room in its field.
fn fill(
    element: Box<Element>,
    at: u16,
    form: &mut dyn Form,
    words: &Vocabulary,
    preserved: bool,
    allowance: &mut Allowance,
) -> Option<Box<Element>> {
    let fields = form.form_type().fields;
    let start = element.span.start;
    let unusual = match is_usual(&fields[usize::from(at)], &element.qname, words) {
        true => None,
        false => Some(element.qname.clone()),
    };
    match form.slot(usize::from(at)) {
        Some(Slot::Text(slot @ None)) if is_text(&element) => *slot = Some(text_of(*element)),
        Some(Slot::Texts(slot)) if is_text(&element) => slot.push(text_of(*element)),
        Some(Slot::Forms(slot)) => match slot.add(usize::MAX) {
            Some(child) => read(*element, child, words, preserved, allowance),
            None => return Some(element),
        },
        _ => return Some(element),
    }
    let beside = form.extra_mut().edit();
    let place = match unusual {
        None => Place::Field(at, start),
        Some(qname) => beside.spell(at, start, &qname),
    };
    beside.node_order.push(place);
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

#[cfg(test)]
mod tests {
    use crate::form::{Format, same};
    use crate::rts_profile::{format, read};

    #[test]
    fn keys_of_yaml_come_back_from_xml() {
        let yaml = "rtsProfile:\n  id: \"RTSystem:a:b:1\"\n  mine: {list: [1, null, \"a?>b\\n<\"], empty: {}}\n  components:\n    - instanceName: A0\n      x-note: kept\n";
        let by_yaml = read("f.yaml", yaml.as_bytes()).unwrap();
        let xml = format(&by_yaml.shape, &by_yaml.around, Format::Xml);
        assert!(xml.contains("<?x-yaml {x-note: kept}?>"), "{xml}");
        let by_xml = read("f.xml", xml.as_bytes()).unwrap();
        assert!(same(by_yaml.shape.form(), by_xml.shape.form()), "{xml}");
        assert_eq!(format(&by_xml.shape, &by_xml.around, Format::Xml), xml);
        // What another program writes under this name stays as it is.
        let other = xml.replace("{x-note: kept}", "[x-note]");
        let read = read("f.xml", other.as_bytes()).unwrap();
        assert_eq!(format(&read.shape, &read.around, Format::Xml), other);
    }
}
