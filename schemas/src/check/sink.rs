//! Where checks put what they find: at most so many findings, each with its place.

use crate::diagnostic::{Finding, Report, Severity, Source};
use crate::span::{Span, Text};

/// Most findings of one file: nobody reads more, and each costs its line.
const FINDINGS_LIMIT: usize = 500;

/// The findings of one file.
pub(super) struct Sink<'a> {
    source: &'a Source,
    pub(super) report: Report,
}

impl<'a> Sink<'a> {
    pub(super) fn new(source: &'a Source, report: Report) -> Self {
        Self { source, report }
    }

    /// True when nothing more is taken: then no advice need be thought of.
    pub(super) fn is_full(&self) -> bool {
        self.report.findings.len() > FINDINGS_LIMIT
    }

    pub(super) fn push(&mut self, finding: Finding, span: Span) {
        match self.report.findings.len() {
            0..FINDINGS_LIMIT => {}
            FINDINGS_LIMIT => {
                let message = format!(
                    "there are more than {FINDINGS_LIMIT} problems; the others are not shown"
                );
                return self
                    .report
                    .push(Finding::error("too-many-problems", message).help("mend these first"));
            }
            _ => return,
        }
        let place = (!span.is_unknown()).then(|| self.source.place(span.start, span.end));
        self.report.push(finding.at(place));
    }

    pub(super) fn say(
        &mut self,
        severity: Severity,
        code: &str,
        message: String,
        span: Span,
        help: impl Into<String>,
    ) {
        self.push(Finding::new(severity, code, message).help(help), span);
    }

    pub(super) fn error(
        &mut self,
        code: &str,
        message: String,
        span: Span,
        help: impl Into<String>,
    ) {
        self.say(Severity::Error, code, message, span, help);
    }

    pub(super) fn warning(
        &mut self,
        code: &str,
        message: String,
        span: Span,
        help: impl Into<String>,
    ) {
        self.say(Severity::Warning, code, message, span, help);
    }
}

/// The trimmed text of an attribute that says something.
pub(super) fn said(text: &Option<Text>) -> Option<&Text> {
    text.as_ref().filter(|text| !text.trimmed().is_empty())
}
