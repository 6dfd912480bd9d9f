//! YAML text that every reader of YAML 1.1 and 1.2 understands the same.

/// Most characters of a key that has only its colon (YAML 1.2.2, 7.4 and 8.2.2: 1024, quotes included).
const LONGEST_KEY: usize = 1024;

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
                if print_key(key, text) {
                    text.push(' ');
                }
                text.push_str(": ");
                print_flow(value, text);
            }
            text.push('}');
        }
        leaf => print_leaf(leaf, text),
    }
}

fn entry(key: &str, value: &Out, indent: usize, text: &mut String) {
    if print_key(key, text) {
        line(indent, text);
    }
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

/// A key before its colon; true when it is one that begins with `?`, as YAML wants it of long ones.
fn print_key(key: &str, text: &mut String) -> bool {
    let begin = text.len();
    scalar(key, text);
    let is_long = text[begin..].chars().count() > LONGEST_KEY;
    if is_long {
        text.insert_str(begin, "? ");
    }
    is_long
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::yaml::parse_quietly;

    #[test]
    fn keys_of_any_length_are_read_back() {
        let shape = |key: &str| {
            let inner = Out::Map(vec![(key.to_owned(), Out::Text("v".to_owned()))]);
            let list = Out::List(vec![inner.clone(), Out::List(vec![inner.clone()])]);
            Out::Map(vec![
                (key.to_owned(), inner),
                (format!("{key}!"), list),
                (format!("{key}?"), Out::Plain("1".to_owned())),
            ])
        };
        for length in [1, 1021, 1022, 1023, 1024, 1025, 5000] {
            for letter in ["a", "\"", "é", "\u{7}"] {
                let key = letter.repeat(length);
                let value = shape(&key);
                for text in [document(&key, &value), flow(&value)] {
                    let read = parse_quietly(&text).map(|node| format!("{node:?}"));
                    let seen = read.map(|node| node.matches("\"v\"").count());
                    assert_eq!(seen, Some(3), "{length} {letter}: {text}");
                }
            }
        }
    }
}
