//! Problems with their places in one of several files.

use std::rc::Rc;

use super::limits;
use super::token::At;
use crate::diagnostic::{Finding, Report, Source};

/// Files, and what was found in them.
#[derive(Debug, Default)]
pub(super) struct Findings {
    /// Every file that was opened, once.
    pub files: Vec<Rc<Source>>,
    found: Vec<(Option<At>, Finding)>,
    more: bool,
}

impl Findings {
    /// Notes an error.
    pub fn error(
        &mut self,
        code: &str,
        at: At,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.push(Some(at), Finding::error(code, message).help(help));
    }

    /// Notes something.
    pub fn push(&mut self, at: Option<At>, finding: Finding) {
        // One slip is told once, whoever stumbles over it.
        let same = |(other, known): &(Option<At>, Finding)| {
            *other == at && known.message == finding.message
        };
        if self.found.iter().any(same) {
            return;
        }
        match self.found.len() < limits::PROBLEMS {
            true => self.found.push((at, finding)),
            false => self.more = true,
        }
    }

    /// More was found than is told: reading on is of no use.
    pub fn is_full(&self) -> bool {
        self.more
    }

    /// `file:line:column` of a place.
    pub fn shown(&self, at: At) -> String {
        let Some(source) = self.files.get(at.file) else {
            return "an unknown place".to_owned();
        };
        let place = source.place(at.span.start, at.span.end);
        format!("{}:{}:{}", place.file, place.line, place.column)
    }

    /// All in the order of the files.
    pub fn report(mut self) -> Report {
        let key = |at: &Option<At>| at.map_or((usize::MAX, 0), |at| (at.file, at.span.start));
        self.found.sort_by_key(|(at, _)| key(at));
        let mut report = Report::default();
        for (at, finding) in self.found {
            let place = at.and_then(|at| {
                let source = self.files.get(at.file)?;
                Some(source.place(at.span.start, at.span.end))
            });
            report.push(finding.at(place));
        }
        if self.more {
            let message = format!(
                "there are more than {} problems; the rest is not shown",
                limits::PROBLEMS
            );
            report.push(Finding::error("too-many-problems", message).help("mend these first"));
        }
        report
    }
}
