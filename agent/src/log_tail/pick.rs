//! Which lines of a log are wanted.

use std::collections::VecDeque;

use jiff::Timestamp;

use crate::log_mark::is_mark;

/// The RFC 3339 time that a line begins with.
fn time_of(line: &str) -> Option<Timestamp> {
    let word = line.split(' ').next()?;
    word.starts_with(|c: char| c.is_ascii_digit())
        .then(|| word.parse().ok())?
}

/// Lines from a time on. A line without a time belongs to the line before.
#[derive(Debug)]
pub(super) struct Since {
    from: Option<Timestamp>,
    open: bool,
}

impl Since {
    pub fn new(from: Option<Timestamp>) -> Self {
        let open = from.is_none();
        Self { from, open }
    }

    pub fn takes(&mut self, line: &str) -> bool {
        if let (Some(from), Some(time)) = (self.from, time_of(line)) {
            self.open = time >= from;
        }
        self.open
    }
}

/// The last lines, with a bound on lines and bytes.
#[derive(Debug)]
pub(super) struct Last {
    most: usize,
    most_bytes: usize,
    lines: VecDeque<String>,
    bytes: usize,
}

impl Last {
    pub fn new(most: usize, most_bytes: usize) -> Self {
        Self {
            most,
            most_bytes,
            lines: VecDeque::new(),
            bytes: 0,
        }
    }

    pub fn push(&mut self, line: String) {
        self.bytes += line.len() + 1;
        self.lines.push_back(line);
        while self.lines.len() > self.most || self.bytes > self.most_bytes {
            let Some(first) = self.lines.pop_front() else {
                return;
            };
            self.bytes -= first.len() + 1;
        }
    }

    pub fn take(&mut self) -> VecDeque<String> {
        self.bytes = 0;
        std::mem::take(&mut self.lines)
    }
}

/// The lines between the last two marks.
#[derive(Debug)]
pub(super) struct Previous {
    newest: Last,
    before: Option<VecDeque<String>>,
}

impl Previous {
    /// `newest` keeps the lines of an incarnation.
    pub fn new(newest: Last) -> Self {
        Self {
            newest,
            before: None,
        }
    }

    /// Tells of a line; it is kept when it is also wanted for other reasons.
    pub fn push(&mut self, line: String, wanted: bool) {
        if is_mark(&line) {
            self.before = Some(self.newest.take());
        } else if wanted {
            self.newest.push(line);
        }
    }

    /// None when there is but one incarnation.
    pub fn end(self) -> Option<VecDeque<String>> {
        self.before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_without_a_time_belong_to_the_one_before() {
        let mut since = Since::new(Some("2026-01-02T03:04:05Z".parse().unwrap()));
        let log = [
            ("torn line", false),
            ("2026-01-02T03:04:04.999Z INFO a", false),
            ("  goes on", false),
            ("2026-01-02T03:04:05.000Z INFO b", true),
            ("  goes on", true),
            ("12 monkeys", true),
            (
                "2026-01-02T03:04:01.000Z INFO the clock was set back",
                false,
            ),
            ("2026-01-02T12:04:06+09:00 INFO c", true),
            ("2026-01-02T12:04:04+09:00 INFO d", false),
            ("2026-01-02T03:04:06Z INFO e", true),
        ];
        for (line, wanted) in log {
            assert_eq!(since.takes(line), wanted, "{line}");
        }
        assert!(Since::new(None).takes("anything"));
    }

    #[test]
    fn the_last_lines_are_bounded_by_number_and_bytes() {
        let mut last = Last::new(2, 8);
        for line in ["a", "b", "c"] {
            last.push(line.to_owned());
        }
        assert_eq!(last.take(), ["b", "c"]);
        last.push("1234".to_owned());
        last.push("567".to_owned());
        assert_eq!(last.take(), ["567"]);
        let mut none = Last::new(0, 8);
        none.push("a".to_owned());
        assert!(none.take().is_empty());
    }

    #[test]
    fn the_incarnation_before_the_newest_lies_between_two_marks() {
        let mark = "2026-01-02T03:04:05.000Z INFO --- a new incarnation of A begins here ---";
        let of = |log: &[&str]| {
            let mut previous = Previous::new(Last::new(9, 999));
            for line in log {
                previous.push((*line).to_owned(), *line != "unwanted");
            }
            previous.end()
        };
        assert_eq!(of(&["one", "two"]), None);
        assert_eq!(of(&["one", mark, "two"]).unwrap(), ["one"]);
        assert_eq!(
            of(&["one", mark, "two", "unwanted", mark]).unwrap(),
            ["two"]
        );
        assert_eq!(of(&["one", mark, mark, "three"]).unwrap(), [""; 0]);
    }
}
