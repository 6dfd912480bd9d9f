//! Profiles as no editor writes them: comments, instructions, texts, unknown elements and attributes at every place,
//! other prefixes, and any layout.

use rts_schemas::xml::{Attribute, Element, Node, Tree, escape_attribute, escape_text, is_blank};

use super::Tape;

/// Puts what no type knows into a tree, at places that the tape says.
pub fn spoil(tree: &mut Tree, tape: &mut Tape<'_>) {
    rename(tree, tape);
    for _ in 0..tape.choose(3) {
        tree.before.push(around(tape));
    }
    for _ in 0..tape.choose(3) {
        tree.after.push(around(tape));
    }
    element(&mut tree.root, tape);
}

fn around(tape: &mut Tape<'_>) -> Node {
    match tape.choose(3) {
        0 => Node::Instruction("xml-stylesheet href='a.xsl'".into()),
        _ => comment(tape),
    }
}

fn comment(tape: &mut Tape<'_>) -> Node {
    const TEXTS: [&str; 6] = [
        " a ",
        "",
        "日本語 &amp; <b/>",
        "two\n    lines\n",
        "]]>",
        "\u{3000}",
    ];
    Node::Comment(TEXTS[tape.choose(TEXTS.len())].into())
}

fn element(element: &mut Element, tape: &mut Tape<'_>) {
    for node in &mut element.children {
        if let Node::Element(child) = node {
            self::element(child, tape);
        }
    }
    if tape.choose(6) == 5 {
        let stranger = attribute(tape);
        let at = tape.choose(element.attributes.len() + 1);
        let known = |a: &Attribute| stranger.iter().any(|s| s.qname == a.qname);
        if !element.attributes.iter().any(known) {
            element.attributes.splice(at..at, stranger);
        }
    }
    if tape.choose(8) == 7 && element.attributes.len() > 1 {
        let count = element.attributes.len();
        element.attributes.swap(tape.choose(count), count - 1);
    }
    let mut at = 0;
    while at <= element.children.len() {
        if tape.choose(5) == 4 {
            let node = stranger(element, tape);
            element.children.insert(at, node);
            at += 1;
        }
        at += 1;
    }
    if tape.choose(12) == 11 && element.children.len() > 1 {
        let last = element.children.len() - 1;
        element.children.swap(tape.choose(last), last);
    }
}

fn plain(qname: &str, value: &str) -> Attribute {
    Attribute {
        namespace: "".into(),
        qname: qname.into(),
        value: value.into(),
        span: Default::default(),
    }
}

fn attribute(tape: &mut Tape<'_>) -> Vec<Attribute> {
    let value = tape.text();
    match tape.choose(5) {
        0 => vec![plain("unknown", &value)],
        1 => vec![plain("xmlns:x", "urn:x"), plain("x:k", &value)],
        2 => vec![plain("xml:lang", "ja")],
        3 => vec![plain("xml:space", ["preserve", "default"][tape.choose(2)])],
        // A name that a field has, in no namespace.
        _ => vec![plain("name", &value)],
    }
}

fn leaf(qname: &str, attributes: Vec<Attribute>, children: Vec<Node>) -> Node {
    Node::Element(Box::new(Element {
        namespace: "".into(),
        qname: qname.into(),
        attributes,
        children,
        span: Default::default(),
    }))
}

/// A node that has no field: what it is, is said by the tape.
fn stranger(parent: &Element, tape: &mut Tape<'_>) -> Node {
    let prefix = parent
        .qname
        .split_once(':')
        .map_or("", |(prefix, _)| prefix);
    let text = |tape: &mut Tape<'_>| Node::Text(tape.text().into());
    match tape.choose(9) {
        0..=2 => comment(tape),
        3 => Node::Instruction("php echo \"<x>\"".into()),
        4 => leaf("x:a", vec![plain("xmlns:x", "urn:x")], vec![text(tape)]),
        5 => {
            let inner = leaf(
                "b",
                vec![plain("k", &tape.text())],
                vec![text(tape), comment(tape)],
            );
            let space = plain("xml:space", "preserve");
            let blank = Node::Text("\n   ".into());
            leaf(
                "a",
                vec![plain("xmlns", "urn:y"), space],
                vec![blank.clone(), inner, blank],
            )
        }
        6 => match prefix {
            "" => leaf("Mistake", Vec::new(), Vec::new()),
            prefix => leaf(
                &format!("{prefix}:Mistake"),
                Vec::new(),
                vec![comment(tape)],
            ),
        },
        7 => match parent.elements().next() {
            // Once more what may stand only once.
            Some(first) => Node::Element(Box::new(first.clone())),
            None => comment(tape),
        },
        _ => Node::Text("words\n  and \u{3000} ".into()),
    }
}

/// Another prefix for the first namespace, or none.
fn rename(tree: &mut Tree, tape: &mut Tape<'_>) {
    let Some(old) = tree.root.qname.split_once(':').map(|(p, _)| p.to_owned()) else {
        return;
    };
    let new = match tape.choose(6) {
        4 => "",
        5 => "other",
        _ => return,
    };
    fn named(qname: &str, old: &str, new: &str) -> String {
        match qname.split_once(':') {
            Some((prefix, local)) if prefix == old && new.is_empty() => local.to_owned(),
            Some((prefix, local)) if prefix == old => format!("{new}:{local}"),
            Some(("xmlns", prefix)) if prefix == old && new.is_empty() => "xmlns".to_owned(),
            Some(("xmlns", prefix)) if prefix == old => format!("xmlns:{new}"),
            _ => qname.to_owned(),
        }
    }
    fn all(element: &mut Element, old: &str, new: &str) {
        element.qname = named(&element.qname, old, new).into();
        for attribute in &mut element.attributes {
            attribute.qname = named(&attribute.qname, old, new).into();
        }
        // Without a prefix two names may be one.
        let mut seen = Vec::new();
        element.attributes.retain(|attribute| {
            let first = !seen.contains(&attribute.qname);
            seen.push(attribute.qname.clone());
            first
        });
        for node in &mut element.children {
            if let Node::Element(child) = node {
                all(child, old, new);
            }
        }
    }
    all(&mut tree.root, &old, new);
}

/// The tree as text, in a layout that the tape says.
pub fn scribble(tree: &Tree, tape: &mut Tape<'_>) -> String {
    let heads = [
        "",
        "<?xml version='1.0'?>",
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n\n",
    ];
    let mut text = heads[tape.choose(heads.len())].to_owned();
    for item in &tree.before {
        node(item, tape, 0, &mut text);
        text.push('\n');
    }
    tag(&tree.root, tape, 0, false, &mut text);
    for item in &tree.after {
        text.push('\n');
        node(item, tape, 0, &mut text);
    }
    match tape.choose(3) {
        2 => text.replace('\n', "\r\n"),
        _ => text,
    }
}

fn tag(element: &Element, tape: &mut Tape<'_>, depth: usize, kept: bool, text: &mut String) {
    let kept = element.preserves_blanks().unwrap_or(kept);
    text.push('<');
    text.push_str(&element.qname);
    for attribute in &element.attributes {
        text.push_str([" ", "\n\t", "  "][tape.choose(3)]);
        let (equals, quote) = ([" = ", "="][tape.choose(2)], ['"', '\''][tape.choose(2)]);
        text.push_str(&attribute.qname);
        text.push_str(equals);
        text.push(quote);
        escape_attribute(&attribute.value, quote, text);
        text.push(quote);
    }
    if element.children.is_empty() && tape.choose(3) < 2 {
        text.push_str([" />", "/>"][tape.choose(2)]);
        return;
    }
    text.push_str([">", " >"][tape.choose(2)]);
    let has_text = element
        .children
        .iter()
        .any(|node| matches!(node, Node::Text(_)));
    let layout = !kept && !has_text && !element.children.is_empty();
    for child in &element.children {
        if layout && tape.choose(4) < 3 {
            text.push('\n');
            (0..=depth).for_each(|_| text.push_str("  "));
        }
        match child {
            Node::Element(child) => tag(child, tape, depth + 1, kept, text),
            other => node(other, tape, depth + 1, text),
        }
    }
    if layout {
        text.push('\n');
        (0..depth).for_each(|_| text.push_str("  "));
    }
    text.push_str(&format!("</{}>", element.qname));
}

fn node(node: &Node, tape: &mut Tape<'_>, depth: usize, text: &mut String) {
    match node {
        Node::Element(element) => tag(element, tape, depth, false, text),
        Node::Comment(comment) => text.push_str(&format!("<!--{comment}-->")),
        Node::Instruction(instruction) => text.push_str(&format!("<?{instruction}?>")),
        Node::Text(piece) => {
            let plain = !piece.contains("]]>") && !piece.contains('\r') && !is_blank(piece);
            match tape.choose(4) {
                3 if plain => text.push_str(&format!("<![CDATA[{piece}]]>")),
                // No reference may name this one, and some programs write it all the same.
                2 if !piece.contains('\0') => piece
                    .chars()
                    .for_each(|c| text.push_str(&format!("&#{};", u32::from(c)))),
                _ => escape_text(piece, text),
            }
        }
    }
}
