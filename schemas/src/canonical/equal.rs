//! Whether two documents say the same, up to layout: elements, attributes, texts, comments, instructions, prefixes, order.

use crate::xml::{Element, Node, Tree, is_blank};

/// What is different first; nothing when only layout is.
pub(super) fn difference(old: &Tree, new: &Tree) -> Option<String> {
    if !nodes(&old.before, &new.before, true) {
        return Some("a comment or instruction before the root would be lost".to_owned());
    }
    if !nodes(&old.after, &new.after, true) {
        return Some("a comment or instruction after the root would be lost".to_owned());
    }
    element(&old.root, &new.root, false)
}

/// The innermost element that differs.
fn element(old: &Element, new: &Element, preserved: bool) -> Option<String> {
    let preserved = old.preserves_blanks().unwrap_or(preserved);
    let said = |element: &Element| (element.qname.clone(), element.namespace.clone());
    let attributes = |element: &Element| -> Vec<_> {
        let all = element.attributes.iter();
        all.map(|a| (a.qname.clone(), a.namespace.clone(), a.value.clone()))
            .collect()
    };
    if said(old) != said(new) || attributes(old) != attributes(new) {
        return Some(format!("`<{}>` would have other attributes", old.qname));
    }
    if nodes(&old.children, &new.children, preserved) {
        return None;
    }
    let inner = old.elements().zip(new.elements());
    inner
        .filter(|(old, new)| said(old) == said(new))
        .find_map(|(old, new)| element(old, new, preserved))
        .or_else(|| Some(format!("`<{}>` would hold other nodes", old.qname)))
}

fn nodes(old: &[Node], new: &[Node], preserved: bool) -> bool {
    let counts = |node: &&Node| preserved || !matches!(node, Node::Text(text) if is_blank(text));
    let (mut old, mut new) = (old.iter().filter(counts), new.iter().filter(counts));
    loop {
        let same = match (old.next(), new.next()) {
            (None, None) => return true,
            (Some(Node::Element(a)), Some(Node::Element(b))) => element(a, b, preserved).is_none(),
            (a, b) => a == b,
        };
        if !same {
            return false;
        }
    }
}
