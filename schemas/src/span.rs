//! Where a piece of text lies in its file, so that a finding can point at it long after the file was read.

use std::ops::Range;

/// A byte range in the decoded text of a file. The default, empty range means "place unknown".
///
/// A profile has one for each of its values, so it is kept small: no file that is read has more than 4 GiB of text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub struct Span {
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

impl Span {
    /// The range `start..end`.
    pub fn new(start: usize, end: usize) -> Self {
        let small = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
        Self {
            start: small(start),
            end: small(end),
        }
    }

    /// True when the range says nothing.
    pub fn is_unknown(self) -> bool {
        self == Self::default()
    }

    /// The range of bytes.
    pub fn range(self) -> Range<usize> {
        let large = |at: u32| usize::try_from(at).unwrap_or(usize::MAX);
        large(self.start)..large(self.end)
    }
}

/// A text as the file writes it, with its place.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Text {
    /// The text, unescaped.
    pub value: String,
    /// Where it is.
    pub span: Span,
}

impl Text {
    /// A text at a place.
    pub fn new(value: impl Into<String>, span: Span) -> Self {
        Self {
            value: value.into(),
            span,
        }
    }

    /// The text without blanks around it.
    pub fn trimmed(&self) -> &str {
        self.value.trim()
    }
}
