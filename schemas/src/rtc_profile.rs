//! RTC Profile (XML or YAML, versions 0.1, 0.2 and 0.3): what one type of component is, its ports and parameters.

pub mod forms;
pub mod versions;

use crate::diagnostic::{Place, Report, Source};
use crate::form::{self, Around, Format, Opened};
use crate::span::Span;
use crate::xml::document::{Document, EditError};
use forms::{RtcProfile, WORDS};

/// A profile as the file says it, with the text to point at.
#[derive(Debug, Clone)]
pub struct ReadRtcProfile {
    /// The decoded text.
    pub source: Source,
    /// What it says.
    pub profile: RtcProfile,
    /// What stands around the root element.
    pub around: Around,
    /// XML or YAML.
    pub format: Format,
    /// Name of the encoding that was found (`UTF-8`).
    pub encoding: &'static str,
    /// What was noticed while reading: warnings, and errors that left the rest readable.
    pub findings: Report,
}

impl ReadRtcProfile {
    /// Keeps the comments of YAML as comments of XML, which YAML is never written with.
    pub fn keep_remarks(&mut self) {
        form::keep_all_remarks(
            self.format,
            &self.source,
            &mut self.profile,
            &mut self.around,
        );
    }

    /// The place of a range; `None` when it is unknown.
    pub fn place(&self, span: Span) -> Option<Place> {
        (!span.is_unknown()).then(|| self.source.place(span.start, span.end))
    }
}

/// Reads a profile; the format is seen from the content, never from the file's name.
///
/// # Errors
/// A report with one error when the file cannot be read at all: encoding, syntax, or another kind of document.
pub fn read(file_name: &str, bytes: &[u8]) -> Result<ReadRtcProfile, Report> {
    let Opened {
        source,
        encoding,
        mut findings,
        tree,
    } = form::open(file_name, bytes, &WORDS)?;
    let mut profile = RtcProfile::default();
    let (format, around) = tree.fill(&mut profile, &WORDS, &source, &mut findings);
    Ok(ReadRtcProfile {
        source,
        profile,
        around,
        format,
        encoding,
        findings,
    })
}

/// The text of a profile in a format: canonical layout, with everything that the profile keeps.
pub fn format(profile: &RtcProfile, around: &Around, format: Format) -> String {
    form::format(profile, around, &WORDS, format)
}

/// The YAML text with every value that differs between what was read from it and an edited copy; see
/// [`form::patch_yaml`].
///
/// # Errors
/// As [`form::patch_yaml`].
pub fn patch_yaml(
    source: &Source,
    old: &RtcProfile,
    new: &RtcProfile,
) -> Result<String, EditError> {
    form::patch_yaml(source, old, new, &WORDS)
}

/// The document with everything that differs between what was read from it and an edited copy; see [`form::patch`].
///
/// # Errors
/// As [`form::patch`].
pub fn patch(
    document: &Document,
    old: &RtcProfile,
    new: &RtcProfile,
) -> Result<Document, EditError> {
    form::patch(document, old, new, &WORDS)
}
