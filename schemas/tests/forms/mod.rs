//! What the tests of forms share: the corpus, and comparing trees up to layout.

#![allow(dead_code, clippy::disallowed_methods)] // Each test takes what it needs; tests read files.

pub mod changes;
pub mod noise;
pub mod versions;

use std::path::PathBuf;

use rts_schemas::form::{Form, Slot};
use rts_schemas::span::{Span, Text};
use rts_schemas::xml::{Element, Node, Tree, is_blank};

/// Files of the corpus, or `None` where there is none.
pub fn files(folder: &str) -> Option<Vec<(String, Vec<u8>)>> {
    let Some(corpus) = std::env::var_os("RTSCTL_CORPUS").map(PathBuf::from) else {
        println!("skipped: RTSCTL_CORPUS is not set");
        return None;
    };
    let mut files: Vec<_> = std::fs::read_dir(corpus.join(folder))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e != "tsv"))
        .collect();
    files.sort();
    let read = |path: PathBuf| {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        (name, std::fs::read(path).unwrap())
    };
    Some(files.into_iter().map(read).collect())
}

/// RTS Profiles anywhere in a folder of the corpus, by their whole path.
pub fn systems(folder: &std::path::Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(systems(&path));
            continue;
        }
        let bytes = std::fs::read(&path).unwrap();
        let has = |word: &[u8]| bytes.windows(word.len()).any(|piece| piece == word);
        if has(b"RtsProfile") || has(b"rtsProfile:") {
            found.push((path, bytes));
        }
    }
    found.sort();
    found
}

/// A tree without what layout is: places, and blanks between elements.
pub fn bare(mut tree: Tree) -> Tree {
    strip(&mut tree.root, false);
    tree
}

/// The same, with the attributes of each element sorted.
pub fn sorted(mut tree: Tree) -> Tree {
    fn sort(element: &mut Element) {
        element.attributes.sort_by(|a, b| a.qname.cmp(&b.qname));
        for node in &mut element.children {
            if let Node::Element(child) = node {
                sort(child);
            }
        }
    }
    sort(&mut tree.root);
    bare(tree)
}

/// The same, without any blanks between elements, whatever `xml:space` says.
pub fn loose(mut tree: Tree) -> Tree {
    fn drop_blanks(element: &mut Element) {
        let blank = |node: &Node| matches!(node, Node::Text(text) if is_blank(text));
        element.children.retain(|node| !blank(node));
        // Two texts become one when nothing is left between them.
        element.children.dedup_by(|next, node| match (node, next) {
            (Node::Text(text), Node::Text(more)) => {
                *text = format!("{text}{more}").into();
                true
            }
            _ => false,
        });
        for node in &mut element.children {
            if let Node::Element(child) = node {
                drop_blanks(child);
            }
        }
    }
    drop_blanks(&mut tree.root);
    sorted(tree)
}

fn strip(element: &mut Element, preserved: bool) {
    let preserved = element.preserves_blanks().unwrap_or(preserved);
    element.span = Span::default();
    for attribute in &mut element.attributes {
        attribute.span = Span::default();
    }
    // Blanks alone are a text in some elements; there the forms are compared.
    let layout = |node: &Node| matches!(node, Node::Text(text) if is_blank(text));
    element.children.retain(|node| preserved || !layout(node));
    for node in &mut element.children {
        if let Node::Element(child) = node {
            strip(child, preserved);
        }
    }
}

/// Bytes that choices are made of; when they run out every choice is the first.
pub struct Tape<'a> {
    bytes: std::slice::Iter<'a, u8>,
    /// Gives each made form its own place, as reading does.
    pub made: usize,
}

impl<'a> Tape<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes: bytes.iter(),
            made: 0,
        }
    }

    /// A number below `count`.
    pub fn choose(&mut self, count: usize) -> usize {
        usize::from(self.bytes.next().copied().unwrap_or(0)) % count
    }

    /// A text, of those that are hard to write.
    pub fn text(&mut self) -> String {
        const TEXTS: [&str; 29] = [
            "a",
            "true",
            "false",
            "1000.0",
            "0.2",
            "1.10",
            "007",
            "-1",
            "",
            " ",
            "  two  words ",
            "<&>\"'",
            "a: b # c",
            "- x",
            "null",
            "~",
            "日本語 ①",
            "2013-08-01T15:23:27",
            "2013-08-01T15:23:27+09:00",
            "0001-01-01T00:00:00",
            "line\nline\r\n\ttab\r",
            "\u{85}\u{2028}\u{feff}\u{1f600}",
            "*alias &anchor !tag",
            "{a: [b]}",
            "]]>",
            "&#10;&amp;",
            "x::y",
            "\\\"",
            "\u{0}\u{1b}[0m\u{7f}",
        ];
        let first = self.choose(TEXTS.len());
        let mut text = TEXTS[first].to_owned();
        if self.choose(8) == 7 {
            text.push_str(TEXTS[self.choose(TEXTS.len())]);
        }
        text
    }
}

/// Fills a form by chance.
pub fn fill(form: &mut dyn Form, tape: &mut Tape<'_>, depth: usize) {
    tape.made += 1;
    form.stand(Span::new(tape.made, tape.made + 1));
    for at in 0..form.form_type().fields.len() {
        // Each choice costs a byte, so few fields are filled.
        let choice = tape.choose(6);
        match form.slot(at) {
            Some(Slot::Text(slot)) if choice >= 3 => {
                *slot = Some(Text::new(tape.text(), Span::default()));
            }
            Some(Slot::Texts(slot)) => {
                for _ in 3..choice {
                    slot.push(Text::new(tape.text(), Span::default()));
                }
            }
            Some(Slot::Forms(slot)) if depth > 0 => {
                for _ in 3..choice {
                    if let Some(child) = slot.add(usize::MAX) {
                        fill(child, tape, depth - 1);
                    }
                }
            }
            _ => {}
        }
    }
}

/// Changes one thing in a form: a text, an attribute more or less, an element more or less.
pub fn edit(form: &mut dyn Form, tape: &mut Tape<'_>) {
    let count = form.form_type().fields.len();
    let at = tape.choose(count);
    let choice = tape.choose(4);
    let deeper = tape.choose(3) > 0;
    match form.slot(at) {
        Some(Slot::Text(slot)) => match choice {
            0 => *slot = None,
            _ => *slot = Some(Text::new(tape.text(), Span::default())),
        },
        Some(Slot::Texts(slot)) => match choice {
            0 if !slot.is_empty() => {
                let index = tape.choose(slot.len());
                slot.remove(index);
            }
            _ => {
                let index = tape.choose(slot.len() + 1);
                slot.insert(index, Text::new(tape.text(), Span::default()));
            }
        },
        Some(Slot::Forms(slot)) => {
            let held = slot.count();
            let index = tape.choose(held.max(1));
            if deeper && let Some(child) = slot.form_mut(index) {
                edit(child, tape);
            } else if choice == 0 && held > 0 {
                slot.remove(index);
            } else if let Some(child) = slot.add(tape.choose(held + 1)) {
                fill(child, tape, 2);
                forget(child);
            }
        }
        None => {}
    }
}

/// What is new has no place in the file.
fn forget(form: &mut dyn Form) {
    rts_schemas::form::strip_places(form);
}
