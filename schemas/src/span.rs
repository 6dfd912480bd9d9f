//! Where a piece of text lies in its file, so that a finding can point at it long after the file was read.

/// A byte range in the decoded text of a file. The default, empty range means "place unknown".
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub struct Span {
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

impl Span {
    /// The range `start..end`.
    pub fn new(start: usize, end: usize) -> Self {
        Self { start, end }
    }

    /// True when the range says nothing.
    pub fn is_unknown(self) -> bool {
        self == Self::default()
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
