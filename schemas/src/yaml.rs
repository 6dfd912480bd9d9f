//! YAML text → tree with byte places. The one file that names the YAML crate.
//!
//! The crate gives values without places, so a second pass finds each key and scalar again in the text, in the order
//! of the file. Scalars keep the spelling of the file (`1.10`, `0.2`), since a profile's values are texts.

mod comments;
mod locate;

pub use comments::first_comment;

use crate::diagnostic::{Finding, Place, Source};
use crate::span::{Span, Text};

use locate::Locator;

/// A YAML value with its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Node {
    /// The value.
    pub value: Value,
    /// First token of the value; unknown in a file that uses aliases.
    pub span: Span,
}

/// What a node holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Value {
    /// `null`, `~` or nothing.
    Null,
    /// A text, number or truth value, as the file spells it.
    Scalar(String),
    /// A list.
    Sequence(Vec<Node>),
    /// Keys and values in the order of the file; keys are unique.
    Mapping(Vec<(Text, Node)>),
}

/// Reads a YAML document.
///
/// # Errors
/// `malformed-yaml` with the place that the parser names: syntax, duplicate key, more than one document.
pub fn parse(source: &Source) -> Result<Node, Box<Finding>> {
    let value: serde_yaml::Value =
        serde_yaml::from_str(source.text()).map_err(|error| malformed(source, &error))?;
    Ok(Locator::new(source.text()).node(&value))
}

/// The text of a value: keys in alphabetical order, texts quoted where they need it.
pub fn print(value: &serde_json::Value) -> String {
    // A JSON value is always a YAML value.
    serde_yaml::to_string(value).unwrap_or_default()
}

fn malformed(source: &Source, error: &serde_yaml::Error) -> Box<Finding> {
    let message = error.to_string();
    let place = error.location().map(|at| {
        duplicate_key(&message)
            .and_then(|key| second_key(source, key, at.line(), at.column()))
            .unwrap_or_else(|| source.place_at(at.line(), at.column()))
    });
    // The place is shown by the finding; said twice it only blurs the message.
    let message = match message.split_once(" at line ") {
        Some((what, _)) => what.to_owned(),
        None => message,
    };
    Box::new(Finding::error("malformed-yaml", message).at(place))
}

fn duplicate_key(message: &str) -> Option<&str> {
    let (_, key) = message.split_once("duplicate entry with key \"")?;
    key.split('"').next()
}

/// The parser names the start of the mapping; the mistake is where its key stands for the second time.
fn second_key(source: &Source, key: &str, line: usize, column: usize) -> Option<Place> {
    let is_key = |text: &str| {
        let indent: usize = text
            .char_indices()
            .nth(column.checked_sub(1)?)
            .map(|(at, _)| at)?;
        let (before, rest) = text.split_at(indent);
        let blank = before.chars().all(|c| c == ' ' || c == '-');
        let rest = rest.trim_start_matches(['"', '\'']).strip_prefix(key)?;
        let colon = rest.trim_start_matches(['"', '\'', ' ']).starts_with(':');
        (blank && colon).then_some(())
    };
    let lines = source
        .text()
        .lines()
        .enumerate()
        .skip(line.saturating_sub(1));
    let (index, _) = lines.filter(|(_, text)| is_key(text).is_some()).nth(1)?;
    let mut place = source.place_at(index + 1, column);
    place.length = key.chars().count().max(1);
    Some(place)
}

impl Node {
    /// The value under a key, when this is a mapping that has it.
    pub fn get(&self, key: &str) -> Option<&Node> {
        self.entries()
            .iter()
            .find(|(name, _)| name.value == key)
            .map(|(_, node)| node)
    }

    /// The value under a key, and the key; the node again when it has no such key.
    ///
    /// # Errors
    /// The node itself.
    pub fn take(self, key: &str) -> Result<(Text, Self), Self> {
        let at = self
            .entries()
            .iter()
            .position(|(name, _)| name.value == key);
        match (at, self) {
            (
                Some(at),
                Self {
                    value: Value::Mapping(mut entries),
                    ..
                },
            ) => Ok(entries.swap_remove(at)),
            (_, node) => Err(node),
        }
    }

    /// The entries of a mapping; nothing for other nodes.
    pub fn entries(&self) -> &[(Text, Node)] {
        match &self.value {
            Value::Mapping(entries) => entries,
            _ => &[],
        }
    }

    /// The items of a sequence; nothing for other nodes.
    pub fn items(&self) -> &[Node] {
        match &self.value {
            Value::Sequence(items) => items,
            _ => &[],
        }
    }

    /// The text of a scalar; `None` for other nodes and for null.
    pub fn text(&self) -> Option<Text> {
        match &self.value {
            Value::Scalar(text) => Some(Text::new(text.clone(), self.span)),
            _ => None,
        }
    }

    /// What kind of node this is, for messages.
    pub fn kind(&self) -> &'static str {
        match self.value {
            Value::Null => "nothing",
            Value::Scalar(_) => "a plain value",
            Value::Sequence(_) => "a list",
            Value::Mapping(_) => "a mapping",
        }
    }
}

/// The number or truth value that a plain scalar is spelled as, if `raw` spells exactly that.
fn spells(raw: &str, value: &serde_yaml::Value) -> bool {
    serde_yaml::from_str::<serde_yaml::Value>(raw).is_ok_and(|other| other == *value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Node {
        parse(&Source::new("t.yaml", text)).unwrap()
    }

    fn at(text: &str, node: &Node) -> String {
        text[node.span.start..node.span.end].to_owned()
    }

    #[test]
    fn scalars_keep_their_spelling_and_place() {
        let text = "# a: comment\na: 1.10\nb:\n  - c: \"x # y\"\n    d: true # no\n  - {c: 'it', d: 0x10}\n";
        let root = read(text);
        let a = root.get("a").unwrap();
        assert_eq!(a.text().unwrap().value, "1.10");
        assert_eq!(a.span.start, 16);
        let items = root.get("b").unwrap().items();
        assert_eq!(at(text, items[0].get("c").unwrap()), "x # y");
        assert_eq!(items[0].get("d").unwrap().text().unwrap().value, "true");
        assert_eq!(items[1].get("d").unwrap().text().unwrap().value, "0x10");
        assert_eq!(at(text, items[1].get("c").unwrap()), "it");
    }

    #[test]
    fn faults_have_places() {
        let fault = |text: &str| {
            let finding = parse(&Source::new("t.yaml", text)).unwrap_err();
            let place = finding.place.unwrap();
            format!("{}:{} {}", place.line, place.column, finding.message)
        };
        insta::assert_snapshot!(fault("b:\n  - a: 1\n    c: 0\n    a: 2\n"), @r#"4:5 b[0]: duplicate entry with key "a""#);
        insta::assert_snapshot!(fault("a: [1,\nb: }"), @"2:4 did not find expected node content");
    }

    #[test]
    fn aliases_have_no_place() {
        let root = read("a: &x 1\nb: *x\n");
        assert!(root.get("b").unwrap().span.is_unknown());
        assert_eq!(root.get("b").unwrap().text().unwrap().value, "1");
    }
}
