//! Finds the keys and scalars of a parsed document again in its text, in document order.

use serde_yaml::Value as Parsed;

use super::{Node, Value, spells};
use crate::span::{Span, Text};

/// A cursor over the text. It only moves forward, so a whole document costs one pass.
pub(super) struct Locator<'a> {
    text: &'a str,
    at: usize,
    /// Aliases repeat what stands elsewhere: then no place can be told.
    lost: bool,
}

impl<'a> Locator<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        let lost = text.lines().any(|line| {
            line.split_whitespace()
                .any(|word| word.len() > 1 && word.starts_with('*'))
        });
        Self { text, at: 0, lost }
    }

    pub(super) fn node(&mut self, parsed: &Parsed) -> Node {
        match parsed {
            Parsed::Null => self.leaf(Value::Null, self.at, self.at),
            Parsed::Bool(_) | Parsed::Number(_) => self.plain(parsed),
            Parsed::String(text) => self.string(text),
            Parsed::Sequence(items) => {
                let start = self.opening();
                let items = items.iter().map(|item| self.node(item)).collect();
                self.leaf(Value::Sequence(items), start, self.token_end(start))
            }
            Parsed::Mapping(entries) => {
                let start = self.opening();
                let entries = entries
                    .iter()
                    .map(|(key, value)| (self.key(key), self.node(value)))
                    .collect();
                self.leaf(Value::Mapping(entries), start, self.token_end(start))
            }
            Parsed::Tagged(tagged) => self.node(&tagged.value),
        }
    }

    fn leaf(&self, value: Value, start: usize, end: usize) -> Node {
        Node {
            value,
            span: self.span(start, end),
        }
    }

    fn span(&self, start: usize, end: usize) -> Span {
        if self.lost {
            Span::default()
        } else {
            Span::new(start, end)
        }
    }

    /// A number or truth value: spelled as in the file, if the file's token means the same.
    fn plain(&mut self, parsed: &Parsed) -> Node {
        let start = self.next_token();
        let end = self.token_end(start);
        let raw = &self.text[start..end];
        if spells(raw, parsed) {
            self.at = end;
            return self.leaf(Value::Scalar(raw.to_owned()), start, end);
        }
        let text = match parsed {
            Parsed::Bool(value) => value.to_string(),
            Parsed::Number(number) => number.to_string(),
            _ => String::new(),
        };
        self.leaf(Value::Scalar(text), start, end)
    }

    fn string(&mut self, text: &str) -> Node {
        let start = self.next_token();
        let rest = &self.text[start..];
        let quoted = rest
            .starts_with(['"', '\''])
            .then(|| rest.get(1..))
            .flatten()
            .is_some_and(|inner| inner.starts_with(text));
        let (start, end) = if quoted {
            (start + 1, start + 1 + text.len())
        } else if !text.is_empty() && rest.starts_with(text) {
            (start, start + text.len())
        } else {
            (start, self.line_end(start))
        };
        // Escaped and folded texts end somewhere later: the search for the next key goes on from their first line.
        self.at = end;
        self.leaf(Value::Scalar(text.to_owned()), start, end)
    }

    fn key(&mut self, key: &Parsed) -> Text {
        let name = match key {
            Parsed::String(text) => text.clone(),
            Parsed::Number(number) => number.to_string(),
            Parsed::Bool(value) => value.to_string(),
            _ => String::new(),
        };
        let Some(start) = self.find_key(&name) else {
            return Text::new(name, Span::default());
        };
        let end = start + name.len();
        self.at = end + self.text[end..].find(':').map_or(0, |colon| colon + 1);
        let span = self.span(start, end);
        Text::new(name, span)
    }

    /// The next place where `name` is followed by a colon and does not stand in a comment.
    fn find_key(&self, name: &str) -> Option<usize> {
        // A key that was written differently (escapes) must not make the search quadratic.
        const REACH: usize = 64 * 1024;
        let end = self
            .text
            .floor_char_boundary((self.at + REACH).min(self.text.len()));
        let window = self.text.get(self.at..end)?;
        window
            .match_indices(name)
            .map(|(found, _)| self.at + found)
            .find(|start| {
                let before = self.text[..*start].chars().next_back();
                let after = self.text[start + name.len()..].trim_start_matches(['"', '\'', ' ']);
                before.is_none_or(|c| c.is_whitespace() || matches!(c, '"' | '\'' | '{' | ','))
                    && after.starts_with(':')
                    && !self.in_comment(*start)
            })
    }

    fn in_comment(&self, at: usize) -> bool {
        let line_start = self.text[..at].rfind('\n').map_or(0, |newline| newline + 1);
        let before = &self.text[line_start.max(self.at)..at];
        before.starts_with('#') || before.contains(" #") || before.contains("\t#")
    }

    /// Start of a list or mapping: its bracket if it has one.
    fn opening(&mut self) -> usize {
        let start = self.next_token_but(&[' ', '\t', '\r', '\n', ',', '}', ']']);
        if self.text[start..].starts_with(['[', '{']) {
            self.at = start + 1;
        }
        start
    }

    /// Start of the next token: blanks, list dashes, opening brackets, commas and comments are skipped.
    fn next_token(&mut self) -> usize {
        self.next_token_but(&[' ', '\t', '\r', '\n', '[', '{', ',', '}', ']'])
    }

    fn next_token_but(&mut self, skipped: &[char]) -> usize {
        loop {
            let rest = &self.text[self.at..];
            let trimmed = rest.trim_start_matches(skipped);
            self.at += rest.len() - trimmed.len();
            if trimmed.starts_with('#') {
                self.at = self.line_end(self.at);
            } else if trimmed.starts_with("- ")
                || trimmed.starts_with("-\n")
                || trimmed.starts_with("-\r")
            {
                self.at += 1;
            } else if trimmed.starts_with("---") && self.at == line_start(self.text, self.at) {
                self.at += 3;
            } else if trimmed.starts_with(['!', '&']) {
                self.at = self.token_end(self.at).max(self.at + 1);
            } else {
                return self.at;
            }
        }
    }

    fn token_end(&self, start: usize) -> usize {
        self.text[start..]
            .find(|c: char| c.is_whitespace() || matches!(c, ',' | '}' | ']'))
            .map_or(self.text.len(), |length| start + length)
    }

    fn line_end(&self, start: usize) -> usize {
        self.text[start..]
            .find(['\r', '\n'])
            .map_or(self.text.len(), |length| start + length)
    }
}

fn line_start(text: &str, at: usize) -> usize {
    text[..at].rfind('\n').map_or(0, |newline| newline + 1)
}
