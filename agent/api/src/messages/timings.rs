//! Where the time goes.

use std::time::Duration;

use rts_host::timing::Kept;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Which spans are asked for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TimingsQuery {
    /// Those that ended within so many microseconds.
    pub micros: u64,
}

/// Spans of a program, and its clock: microseconds since it began.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Timings {
    /// What its clock says while it answers.
    pub now: u64,
    /// The spans, in the order of their ends.
    pub spans: Vec<TimedSpan>,
}

/// Something that took time.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct TimedSpan {
    /// Who did it: `rtsctl`, `controller`, or `agent NODE`. Empty for who answers.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub program: String,
    /// What was done.
    pub what: String,
    /// To whom.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub of: String,
    /// Spans of the same program around it.
    pub depth: u32,
    /// Start, by the clock of who answers.
    pub start: u64,
    /// End.
    pub end: u64,
}

impl Timings {
    /// What a program has kept, when its clock says `now`.
    pub fn of(kept: Vec<Kept>, now: Duration) -> Self {
        let spans = kept.into_iter().map(|kept| TimedSpan {
            program: String::new(),
            what: kept.what,
            of: kept.of,
            depth: kept.depth,
            start: micros(kept.start),
            end: micros(kept.end),
        });
        Self {
            now: micros(now),
            spans: spans.collect(),
        }
    }

    /// Its spans by another clock that says `now` when this one says what it says, and in somebody's name.
    pub fn by(self, now: u64, program: &str) -> impl Iterator<Item = TimedSpan> {
        let theirs = self.now;
        let program = program.to_owned();
        let shift = move |at: u64| (at + now).saturating_sub(theirs);
        self.spans.into_iter().map(move |span| TimedSpan {
            program: match span.program.is_empty() {
                true => program.clone(),
                false => span.program.clone(),
            },
            start: shift(span.start),
            end: shift(span.end),
            ..span
        })
    }
}

/// Whole microseconds.
pub fn micros(time: Duration) -> u64 {
    u64::try_from(time.as_micros()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_move_to_another_clock() {
        let span = |program: &str, start, end| TimedSpan {
            program: program.to_owned(),
            what: "x".to_owned(),
            of: String::new(),
            depth: 0,
            start,
            end,
        };
        let spans = vec![span("", 10, 70), span("agent a", 40, 50)];
        let timings = Timings { now: 100, spans };
        let moved: Vec<_> = timings.by(60, "controller").collect();
        // What began before the other clock did begins with it.
        let expected = [span("controller", 0, 30), span("agent a", 0, 10)];
        assert_eq!(moved, expected);
    }
}
