//! Element tree → XML text: one element a line, everything else as it is.

use super::{Element, Node, Tree, is_blank};

const INDENT: &str = "    ";

/// A whole document in UTF-8, indented by four blanks. Blanks between elements are layout, and made anew; an element
/// with text among its children is written as it is.
pub fn print(tree: &Tree) -> String {
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"yes\"?>\n");
    for node in &tree.before {
        print_node(node, 0, &mut text);
        text.push('\n');
    }
    print_at(&tree.root, 0, &mut text);
    text.push('\n');
    for node in &tree.after {
        print_node(node, 0, &mut text);
        text.push('\n');
    }
    text
}

/// One element, indented as if it stood at a depth; without a line end.
pub fn print_element(element: &Element, indent: &str) -> String {
    let mut text = String::new();
    print_at(element, 0, &mut text);
    if indent.is_empty() {
        return text;
    }
    // Line ends in values are written as references, so these are all layout, unless the element has mixed text.
    match is_layout(element) {
        true => text.replace('\n', &format!("\n{indent}")),
        false => text,
    }
}

/// True when every line end of the printed element is layout.
fn is_layout(element: &Element) -> bool {
    let kept = element.preserves_blanks() == Some(true);
    element.children.iter().all(|node| match node {
        Node::Text(text) if kept => !text.contains('\n'),
        Node::Element(element) => is_layout(element),
        Node::Text(text) => !text.contains('\n') || is_blank(text),
        Node::Comment(text) | Node::Instruction(text) => !text.contains('\n'),
    })
}

fn print_at(element: &Element, depth: usize, text: &mut String) {
    text.push('<');
    text.push_str(&element.qname);
    for attribute in &element.attributes {
        text.push(' ');
        text.push_str(&attribute.qname);
        text.push_str("=\"");
        escape_attribute(&attribute.value, '"', text);
        text.push('"');
    }
    let blank = |node: &Node| matches!(node, Node::Text(text) if is_blank(text));
    let only_text = matches!(element.children.as_slice(), [Node::Text(_)]);
    let preserved = element.preserves_blanks() == Some(true);
    let nothing = element.children.iter().all(blank) && !only_text && !preserved;
    if nothing || element.children.is_empty() {
        text.push_str("/>");
        return;
    }
    text.push('>');
    let is_text = |node: &Node| matches!(node, Node::Text(_)) && !blank(node);
    let mixed = preserved || element.children.iter().any(is_text);
    for node in &element.children {
        if mixed || only_text {
            print_inline(node, text);
        } else if !blank(node) {
            line(depth + 1, text);
            print_node(node, depth + 1, text);
        }
    }
    if !mixed && !only_text {
        line(depth, text);
    }
    text.push_str("</");
    text.push_str(&element.qname);
    text.push('>');
}

fn line(depth: usize, text: &mut String) {
    text.push('\n');
    for _ in 0..depth {
        text.push_str(INDENT);
    }
}

fn print_node(node: &Node, depth: usize, text: &mut String) {
    match node {
        Node::Element(element) => print_at(element, depth, text),
        other => print_inline(other, text),
    }
}

/// With nothing but what is there: among text every blank counts.
fn print_inline(node: &Node, text: &mut String) {
    match node {
        Node::Text(piece) => escape_text(piece, text),
        Node::Comment(comment) => {
            text.push_str("<!--");
            text.push_str(comment);
            text.push_str("-->");
        }
        Node::Instruction(instruction) => {
            text.push_str("<?");
            text.push_str(instruction);
            text.push_str("?>");
        }
        Node::Element(element) => {
            text.push('<');
            text.push_str(&element.qname);
            for attribute in &element.attributes {
                text.push(' ');
                text.push_str(&attribute.qname);
                text.push_str("=\"");
                escape_attribute(&attribute.value, '"', text);
                text.push('"');
            }
            if element.children.is_empty() {
                text.push_str("/>");
                return;
            }
            text.push('>');
            for child in &element.children {
                print_inline(child, text);
            }
            text.push_str("</");
            text.push_str(&element.qname);
            text.push('>');
        }
    }
}

/// Adds an attribute's value for between these quotes; line ends and tabs survive as references.
pub fn escape_attribute(value: &str, quote: char, text: &mut String) {
    for c in value.chars() {
        match c {
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '&' => text.push_str("&amp;"),
            '"' if quote == '"' => text.push_str("&quot;"),
            '\'' if quote == '\'' => text.push_str("&apos;"),
            '\t' => text.push_str("&#9;"),
            '\n' => text.push_str("&#10;"),
            '\r' => text.push_str("&#13;"),
            c => text.push(c),
        }
    }
}

/// Adds an element's text.
pub fn escape_text(value: &str, text: &mut String) {
    for c in value.chars() {
        match c {
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '&' => text.push_str("&amp;"),
            '\r' => text.push_str("&#13;"),
            c => text.push(c),
        }
    }
}
