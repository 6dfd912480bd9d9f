//! YAML text that every reader of YAML 1.1 and 1.2 understands the same.

/// A value to print.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Out {
    /// A number or truth value, as it is.
    Plain(String),
    /// A text.
    Text(String),
    /// A list.
    List(Vec<Out>),
    /// Keys and values.
    Map(Vec<(String, Out)>),
}

/// A document with one key.
pub(super) fn document(key: &str, value: &Out) -> String {
    let mut text = String::new();
    entry(key, value, 0, &mut text);
    text
}

/// A value in one line, in brackets.
pub(super) fn flow(value: &Out) -> String {
    let mut text = String::new();
    print_flow(value, &mut text);
    text
}

fn print_flow(value: &Out, text: &mut String) {
    match value {
        Out::List(items) => {
            text.push('[');
            for (index, item) in items.iter().enumerate() {
                text.push_str(if index > 0 { ", " } else { "" });
                print_flow(item, text);
            }
            text.push(']');
        }
        Out::Map(entries) => {
            text.push('{');
            for (index, (key, value)) in entries.iter().enumerate() {
                text.push_str(if index > 0 { ", " } else { "" });
                scalar(key, text);
                text.push_str(": ");
                print_flow(value, text);
            }
            text.push('}');
        }
        leaf => print_leaf(leaf, text),
    }
}

fn entry(key: &str, value: &Out, indent: usize, text: &mut String) {
    scalar(key, text);
    text.push(':');
    match value {
        Out::Map(entries) if !entries.is_empty() => {
            for (key, value) in entries {
                line(indent + 2, text);
                entry(key, value, indent + 2, text);
            }
        }
        Out::List(items) if !items.is_empty() => {
            for item in items {
                line(indent + 2, text);
                list_item(item, indent + 2, text);
            }
        }
        leaf => {
            text.push(' ');
            print_leaf(leaf, text);
        }
    }
    if indent == 0 {
        text.push('\n');
    }
}

fn list_item(item: &Out, indent: usize, text: &mut String) {
    text.push_str("- ");
    match item {
        Out::Map(entries) if !entries.is_empty() => {
            for (index, (key, value)) in entries.iter().enumerate() {
                if index > 0 {
                    line(indent + 2, text);
                }
                entry(key, value, indent + 2, text);
            }
        }
        Out::List(items) if !items.is_empty() => {
            for (index, item) in items.iter().enumerate() {
                if index > 0 {
                    line(indent + 2, text);
                }
                list_item(item, indent + 2, text);
            }
        }
        leaf => print_leaf(leaf, text),
    }
}

fn line(indent: usize, text: &mut String) {
    text.push('\n');
    text.extend(std::iter::repeat_n(' ', indent));
}

fn print_leaf(leaf: &Out, text: &mut String) {
    match leaf {
        Out::Plain(value) => text.push_str(value),
        Out::Text(value) => scalar(value, text),
        Out::List(_) => text.push_str("[]"),
        Out::Map(_) => text.push_str("{}"),
    }
}

fn scalar(value: &str, text: &mut String) {
    if is_plain(value) {
        text.push_str(value);
        return;
    }
    text.push('"');
    for c in value.chars() {
        match c {
            '"' => text.push_str("\\\""),
            '\\' => text.push_str("\\\\"),
            '\n' => text.push_str("\\n"),
            '\r' => text.push_str("\\r"),
            '\t' => text.push_str("\\t"),
            c if is_printable(c) => text.push(c),
            c if u32::from(c) > 0xffff => text.push_str(&format!("\\U{:08X}", u32::from(c))),
            c => text.push_str(&format!("\\u{:04X}", u32::from(c))),
        }
    }
    text.push('"');
}

/// What PyYAML reads without an escape.
fn is_printable(c: char) -> bool {
    matches!(c, ' '..='~' | '\u{a0}'..='\u{2027}' | '\u{202a}'..='\u{d7ff}' | '\u{e000}'..='\u{fefe}' | '\u{ff00}'..='\u{fffd}' | '\u{10000}'..='\u{10ffff}')
}

/// A word that cannot be taken for anything but a text.
fn is_plain(value: &str) -> bool {
    const WORDS: [&str; 9] = ["true", "false", "yes", "no", "on", "off", "null", "y", "n"];
    let first = value
        .bytes()
        .next()
        .is_some_and(|b| b.is_ascii_alphabetic());
    let rest = |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'-' | b'.' | b'/');
    first && value.bytes().all(rest) && !WORDS.contains(&value.to_ascii_lowercase().as_str())
}
