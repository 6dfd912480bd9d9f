//! Findings: every problem that a reader or a check sees, with its place and a way to mend it.
//!
//! A finding carries the text of its line, so that it can travel over the API and still be shown as a compiler would.

mod render;

pub use render::render;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// How bad a finding is.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema,
)]
#[serde(rename_all = "camelCase")]
pub enum Severity {
    /// Worth knowing; nothing is wrong.
    Note,
    /// Accepted, but probably not meant.
    Warning,
    /// The system cannot be deployed.
    Error,
}

/// Where in a file a finding is. Lines and columns count from 1; columns count Unicode scalar values.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Place {
    /// File name as the user gave it.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1.
    pub column: usize,
    /// Number of characters to underline, at least 1.
    pub length: usize,
    /// The line itself, cut to 240 characters around the place.
    pub text: String,
    /// Column of `text`'s first character in the real line, from 1 (not 1 when the line was cut).
    pub text_column: usize,
}

/// One problem.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Finding {
    /// How bad it is.
    pub severity: Severity,
    /// Stable code in kebab case (`unknown-port`).
    pub code: String,
    /// What is wrong, one sentence, lower case, no full stop.
    pub message: String,
    /// Where, when it comes from a file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<Place>,
    /// How to mend it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
}

impl Finding {
    /// A finding without place or help.
    pub fn new(severity: Severity, code: &str, message: impl Into<String>) -> Self {
        Self {
            severity,
            code: code.to_owned(),
            message: message.into(),
            place: None,
            help: None,
        }
    }

    /// An error.
    pub fn error(code: &str, message: impl Into<String>) -> Self {
        Self::new(Severity::Error, code, message)
    }

    /// A warning.
    pub fn warning(code: &str, message: impl Into<String>) -> Self {
        Self::new(Severity::Warning, code, message)
    }

    /// The same finding with its place.
    #[must_use]
    pub fn at(mut self, place: Option<Place>) -> Self {
        self.place = place;
        self
    }

    /// The same finding with advice.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// All findings of one input, in the order of the file.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(transparent)]
pub struct Report {
    /// The findings.
    pub findings: Vec<Finding>,
}

impl Report {
    /// Adds a finding.
    pub fn push(&mut self, finding: Finding) {
        self.findings.push(finding);
    }

    /// Adds all findings of another report.
    pub fn extend(&mut self, other: Report) {
        self.findings.extend(other.findings);
    }

    /// Puts the findings of one file in the order of its lines; those without a place come last.
    pub fn sort_by_place(&mut self) {
        self.findings.sort_by_key(|finding| {
            let place = finding.place.as_ref();
            place.map_or((usize::MAX, 0), |place| (place.line, place.column))
        });
    }

    /// True when at least one finding is an error.
    pub fn has_errors(&self) -> bool {
        self.findings.iter().any(|f| f.severity == Severity::Error)
    }
}

/// A source text that can turn byte offsets into places.
#[derive(Debug, Clone)]
pub struct Source {
    name: String,
    text: String,
    line_starts: Vec<usize>,
    /// Characters before each [`STEP`] of bytes: a file may be one line of a megabyte, and is not walked for each place.
    counts: Vec<usize>,
}

/// Bytes between two counts.
const STEP: usize = 4096;

/// Longest piece of a line that a place carries, in characters.
const TEXT_LIMIT: usize = 240;

impl Source {
    /// Keeps the text and finds its lines.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        let text = text.into();
        let line_starts = std::iter::once(0)
            .chain(text.match_indices('\n').map(|(at, _)| at + 1))
            .collect();
        let counts = counts(text.as_bytes());
        Self {
            name: name.into(),
            text,
            line_starts,
            counts,
        }
    }

    /// Characters before a byte, which starts a character.
    fn chars_before(&self, at: usize) -> usize {
        let step = (at / STEP).min(self.counts.len() - 1);
        let rest = self.text.as_bytes().get(step * STEP..at);
        self.counts[step] + rest.map_or(0, characters)
    }

    /// A line without its end.
    fn line(&self, index: usize) -> &str {
        let from = self.line_starts[index];
        let next = self.line_starts.get(index + 1);
        let line = &self.text[from..next.map_or(self.text.len(), |next| next - 1)];
        // As `lines` has it: only the end of a line may be `\r\n`.
        match next {
            Some(_) => line.strip_suffix('\r').unwrap_or(line),
            None => line,
        }
    }

    /// The text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The name that places show.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The place of a byte range; offsets past the end or inside a character are moved back.
    pub fn place(&self, start: usize, end: usize) -> Place {
        let start = self.text.floor_char_boundary(start);
        let index = self
            .line_starts
            .partition_point(|at| *at <= start)
            .saturating_sub(1);
        let from = self.line_starts[index];
        let line = self.line(index);
        let start_in_line = (start - from).min(line.len());
        let end_in_line =
            (self.text.floor_char_boundary(end.max(start)) - from).clamp(start_in_line, line.len());
        let chars = |to: usize| self.chars_before(from + to) - self.chars_before(from);
        let column = chars(start_in_line) + 1;
        let length = (chars(end_in_line) + 1 - column).max(1);
        // A file may be one line of a megabyte: of it only this piece is walked.
        let cut = (chars(line.len()) > TEXT_LIMIT)
            .then(|| line[..start_in_line].char_indices().rev().nth(39))
            .flatten();
        let (cut_at, skip) = cut.map_or((0, 0), |(at, _)| (at, column - 1 - 40));
        let text: String = line[cut_at..].chars().take(TEXT_LIMIT).collect();
        let room = text
            .chars()
            .count()
            .saturating_sub(column - 1 - skip)
            .max(1);
        Place {
            file: self.name.clone(),
            line: index + 1,
            column,
            length: length.min(room),
            text,
            text_column: skip + 1,
        }
    }

    /// The place of a line and column, both from 1.
    pub fn place_at(&self, line: usize, column: usize) -> Place {
        let index = line.saturating_sub(1).min(self.line_starts.len() - 1);
        let from = self.line_starts[index];
        let line = self.line(index);
        let offset = line
            .char_indices()
            .nth(column.saturating_sub(1))
            .map_or(line.len(), |(at, _)| at);
        self.place(from + offset, from + offset + 1)
    }
}

/// Characters of UTF-8.
fn characters(bytes: &[u8]) -> usize {
    bytes.iter().filter(|byte| **byte & 0xC0 != 0x80).count()
}

/// Characters before each step of bytes.
fn counts(bytes: &[u8]) -> Vec<usize> {
    let mut counts = vec![0];
    let mut sum = 0;
    for chunk in bytes.chunks_exact(STEP) {
        sum += characters(chunk);
        counts.push(sum);
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_count_characters_on_lines_of_any_length() {
        for lead in [0, 1, 4095, 4096, 9000] {
            let text = format!("one\r\n{}日本語", "é".repeat(lead));
            let start = text.find('本').unwrap();
            let place = Source::new("f", text).place(start, start + 6);
            assert_eq!((place.line, place.column, place.length), (2, lead + 2, 2));
            let shown = place.text.chars().nth(place.column - place.text_column);
            assert_eq!(shown, Some('本'));
        }
    }

    #[test]
    fn ends_of_lines_are_no_part_of_them() {
        let place = Source::new("f", "a\r\nb").place(0, 3);
        assert_eq!((place.length, place.text.as_str()), (1, "a"));
        let place = Source::new("f", "a\n").place(2, 2);
        assert_eq!((place.line, place.text.as_str()), (2, ""));
    }
}
