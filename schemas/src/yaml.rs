//! YAML text → tree with byte places, and values → text. The one file that names the YAML crates.
//!
//! The parser gives one event after the other, so the tree is the only thing that is kept. Scalars keep the spelling of
//! the file (`1.10`, `0.2`), since a profile's values are texts.

mod build;
mod characters;
mod comments;
mod density;

pub use comments::{first_comment, remarks};

use saphyr_parser::{Event, Parser, ScalarStyle, ScanError, Span as Range, Tag};

use crate::diagnostic::{Finding, Source};
use crate::span::{Span, Text};

use build::{Builder, Fault};
use characters::Cursor;

/// Deepest nesting of lists and mappings that is read.
pub const DEPTH_LIMIT: usize = 128;

/// A YAML value with its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Node {
    /// The value.
    pub value: Value,
    /// First token of the value, without quotes; of an alias the alias.
    pub span: Span,
}

/// What a node holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Value {
    /// `null`, `~` or nothing.
    Null,
    /// A text, number or truth value, as the file spells it.
    Scalar(Box<str>),
    /// A list.
    Sequence(Box<[Node]>),
    /// Keys and values in the order of the file; keys are unique.
    Mapping(Box<[(Text, Node)]>),
}

/// Reads a YAML document.
///
/// # Errors
/// `malformed-yaml` with the place that the parser names: syntax, duplicate key, more than one document. `too-deep` and
/// `too-dense` where a file would cost much more than its size.
pub fn parse(source: &Source) -> Result<Node, Box<Finding>> {
    let text = source.text();
    if let Some((at, c)) = text.char_indices().find(|(_, c)| !is_readable(*c)) {
        let message = format!(
            "the control character U+{:04X} is not allowed",
            u32::from(c)
        );
        let place = source.place(at, at + 1);
        let finding = Finding::error("malformed-yaml", message).at(Some(place));
        return Err(Box::new(
            finding.help("remove it, or write it as `\"\\x…\"`"),
        ));
    }
    if density::is_too_dense(text) {
        let message = "the brackets of the file hold more values than a file of its size can have";
        let finding = Finding::error("too-dense", message);
        return Err(Box::new(finding.help("is this the right file?")));
    }
    let mut cursor = Cursor::new(text);
    let mut builder = Builder::new(text);
    let mut documents = 0;
    for event in Parser::new_from_str(text) {
        let (event, range) = event.map_err(|error| malformed(source, &error))?;
        if matches!(event, Event::DocumentStart(_)) {
            documents += 1;
        }
        let span = place_of(text, &event, range, &mut cursor);
        if documents > 1 {
            let message = "the file holds more than one YAML document";
            let help = "remove `---` and what follows it, or make two files of it";
            let fault = Fault::malformed(message, help, span);
            return Err(fault.finding(source));
        }
        take(event, span, &mut builder).map_err(|fault| fault.finding(source))?;
    }
    Ok(builder.finish())
}

/// The text of a value: keys in alphabetical order, texts quoted where they need it.
pub fn print(value: &serde_json::Value) -> String {
    // A JSON value is always a YAML value.
    serde_yaml::to_string(value).unwrap_or_default()
}

/// Reads a YAML document that is right, or not at all.
pub fn parse_quietly(text: &str) -> Option<Node> {
    parse(&Source::new("", text)).ok()
}

fn take(event: Event<'_>, span: Span, builder: &mut Builder) -> Result<(), Fault> {
    match event {
        Event::Scalar(text, style, anchor, tag) => {
            let is_text = style != ScalarStyle::Plain || tag.is_some_and(|tag| is_str(&tag));
            let is_null = !is_text && matches!(&*text, "" | "~" | "null" | "Null" | "NULL");
            let value = match is_null && !builder.wants_key() {
                true => Value::Null,
                false => Value::Scalar(text.into()),
            };
            builder.value(Node { value, span }, anchor)
        }
        Event::SequenceStart(anchor, _) => builder.open(false, anchor, span),
        Event::MappingStart(anchor, _) => builder.open(true, anchor, span),
        Event::SequenceEnd | Event::MappingEnd => builder.close(),
        Event::Alias(anchor) => builder.alias(anchor, span),
        Event::DocumentStart(_)
        | Event::DocumentEnd
        | Event::StreamStart
        | Event::StreamEnd
        | Event::Nothing => Ok(()),
    }
}

fn is_str(tag: &Tag) -> bool {
    tag.is_yaml_core_schema() && tag.suffix == "str"
}

/// The bytes of an event: a text without its quotes, the first token of a list or mapping.
fn place_of(text: &str, event: &Event<'_>, range: Range, cursor: &mut Cursor<'_>) -> Span {
    let start = cursor.byte(range.start.index());
    match event {
        Event::Scalar(_, style, ..) => {
            let end = cursor.byte(range.end.index()).max(start);
            match style {
                ScalarStyle::SingleQuoted | ScalarStyle::DoubleQuoted if end >= start + 2 => {
                    let inner = text.get(start + 1..end).unwrap_or_default();
                    Span::new(start + 1, start + 1 + quoted(inner.as_bytes(), style))
                }
                _ => Span::new(start, end),
            }
        }
        Event::Alias(_) => Span::new(start, cursor.byte(range.end.index())),
        Event::SequenceStart(..) | Event::MappingStart(..) => {
            Span::new(start, token_end(text, start))
        }
        _ => Span::new(start, start),
    }
}

/// Bytes before the closing quote; the parser's range goes on over the blanks and the comment after it.
fn quoted(rest: &[u8], style: &ScalarStyle) -> usize {
    let mut at = 0;
    while let Some(byte) = rest.get(at) {
        at += match (byte, style) {
            (b'\\', ScalarStyle::DoubleQuoted) => 2,
            (b'\'', ScalarStyle::SingleQuoted) if rest.get(at + 1) == Some(&b'\'') => 2,
            (b'\'', ScalarStyle::SingleQuoted) | (b'"', ScalarStyle::DoubleQuoted) => break,
            _ => 1,
        };
    }
    at.min(rest.len())
}

/// Where the token ends that starts there; of a long one as much as can be shown.
fn token_end(text: &str, start: usize) -> usize {
    const LONGEST: usize = 64;
    let end = text.floor_char_boundary((start + LONGEST).min(text.len()));
    let piece = text.get(start..end).unwrap_or_default();
    let ends = |c: char| c.is_whitespace() || matches!(c, ',' | '}' | ']');
    start + piece.find(ends).unwrap_or(piece.len())
}

/// True for what YAML calls printable; the parser takes U+0000 for the end of the file.
fn is_readable(c: char) -> bool {
    !matches!(c, '\0'..='\u{8}' | '\u{b}' | '\u{c}' | '\u{e}'..='\u{1f}' | '\u{7f}')
}

fn malformed(source: &Source, error: &ScanError) -> Box<Finding> {
    let at = error.marker();
    let place = source.place_at(at.line(), at.col() + 1);
    Box::new(
        Finding::error("malformed-yaml", error.info())
            .at(Some(place))
            .help(MISTAKES),
    )
}

/// What to look for where no YAML can be read.
const MISTAKES: &str = "look for brackets and quotes that are not closed, tabs, and lines that are indented too far or not far enough";

impl Node {
    /// The same, from nowhere.
    #[must_use]
    pub fn without_places(mut self) -> Self {
        self.span = Span::default();
        match &mut self.value {
            Value::Null | Value::Scalar(_) => {}
            Value::Sequence(items) => items.iter_mut().for_each(Self::forget),
            Value::Mapping(entries) => {
                for (key, node) in entries {
                    key.span = Span::default();
                    node.forget();
                }
            }
        }
        self
    }

    fn forget(&mut self) {
        let nothing = Self {
            value: Value::Null,
            span: Span::default(),
        };
        *self = std::mem::replace(self, nothing).without_places();
    }

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
        let Value::Mapping(entries) = self.value else {
            return Err(self);
        };
        let mut entries = entries.into_vec();
        match entries.iter().position(|(name, _)| name.value == key) {
            Some(at) => Ok(entries.swap_remove(at)),
            None => Err(Self {
                value: Value::Mapping(entries.into()),
                span: self.span,
            }),
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
            Value::Scalar(text) => Some(Text::new(&**text, self.span)),
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

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Node {
        parse(&Source::new("t.yaml", text)).unwrap()
    }

    fn at(text: &str, node: &Node) -> String {
        text[node.span.range()].to_owned()
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
        let text = "a: 'it''s' # 'no'\nb: [\"\\\"\" ,'' ]\n";
        let root = read(text);
        assert_eq!(at(text, root.get("a").unwrap()), "it''s");
        let items = root.get("b").unwrap().items();
        assert_eq!(at(text, &items[0]), "\\\"");
        assert_eq!(at(text, &items[1]), "");
    }

    #[test]
    fn faults_have_places() {
        let fault = |text: &str| {
            let finding = parse(&Source::new("t.yaml", text)).unwrap_err();
            let place = finding.place.unwrap();
            format!("{}:{} {}", place.line, place.column, finding.message)
        };
        insta::assert_snapshot!(fault("b:\n  - a: 1\n    c: 0\n    a: 2\n"), @r#"4:5 duplicate entry with key "a""#);
        insta::assert_snapshot!(fault("a: [1,\n  b: }"), @"2:1 while parsing a flow sequence, expected ',' or ']'");
    }

    #[test]
    fn brackets_may_end_at_the_left_margin() {
        for text in [
            "a: {\n  b: 1\n}\nc: 2\n",
            "a: [\n  1,\n]\nc: 2\n",
            "a:\n  - [\n    1,\n  ]\nc: 2\n",
            "{\n\t\"a\": [\n\t1\n\t],\n\"c\": 2}\n",
        ] {
            assert_eq!(read(text).get("c").unwrap().text().unwrap().value, "2");
        }
    }

    #[test]
    fn aliases_have_their_place() {
        let text = "a: &x [1]\nb: *x\n";
        let root = read(text);
        let b = root.get("b").unwrap();
        assert_eq!(at(text, b), "*x");
        assert_eq!(b.items(), root.get("a").unwrap().items());
    }
}
