//! Lines of a log, and the manager's own log on standard error.

use std::fmt;
use std::io::{self, Write};

use jiff::Timestamp;
use rts_schemas::names::is_hidden;

/// Longest line in bytes, line end included.
pub const MAX_LINE: usize = 8 * 1024;
const CUT: &str = "…";

/// Severity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Finest detail.
    Trace,
    /// Detail for a developer.
    Debug,
    /// Normal.
    Info,
    /// Suspicious.
    Warn,
    /// Failed.
    Error,
}

impl Level {
    /// The level with this number in the ABI; unknown numbers are errors, so that nobody overlooks them.
    pub fn from_abi(level: u32) -> Self {
        match level {
            0 => Self::Trace,
            1 => Self::Debug,
            2 => Self::Info,
            3 => Self::Warn,
            _ => Self::Error,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Trace => "TRACE",
            Self::Debug => "DEBUG",
            Self::Info => "INFO",
            Self::Warn => "WARN",
            Self::Error => "ERROR",
        }
    }
}

/// Formats one line. Control characters are escaped, what is too long is cut.
pub fn line(time: Timestamp, level: Level, message: &str) -> String {
    let mut line = format!("{time:.3} {} ", level.name());
    let limit = MAX_LINE - CUT.len() - 1;
    for character in message.chars() {
        let before = line.len();
        if is_hidden(character) && character != '\t' {
            line.extend(character.escape_default());
        } else {
            line.push(character);
        }
        if line.len() > limit {
            line.truncate(before);
            line.push_str(CUT);
            break;
        }
    }
    line.push('\n');
    line
}

/// Writes an error to the manager's log.
pub fn error(message: fmt::Arguments<'_>) {
    own(Level::Error, message);
}

/// Writes a warning to the manager's log.
pub fn warn(message: fmt::Arguments<'_>) {
    own(Level::Warn, message);
}

/// Writes a remark to the manager's log.
pub fn info(message: fmt::Arguments<'_>) {
    own(Level::Info, message);
}

fn own(level: Level, message: fmt::Arguments<'_>) {
    let _ = io::stderr().write(line(Timestamp::now(), level, &message.to_string()).as_bytes());
}

/// Writes a bare line on standard error, for who started this process to show.
pub fn plain(message: fmt::Arguments<'_>) {
    let _ = writeln!(io::stderr(), "{message}");
}

/// Prints text for a person on standard output.
pub fn print(text: &str) {
    let _ = io::stdout().write_all(text.as_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(message: &str) -> String {
        let time = "2026-11-22T01:02:03.456789Z".parse().unwrap();
        line(time, Level::Info, message)
    }

    #[test]
    fn a_line_has_time_level_and_message() {
        assert_eq!(at("hello"), "2026-11-22T01:02:03.456Z INFO hello\n");
    }

    #[test]
    fn a_message_stays_on_one_line() {
        assert_eq!(
            at("a\nb\r\u{1b}[31m\tc\u{202e}"),
            "2026-11-22T01:02:03.456Z INFO a\\nb\\r\\u{1b}[31m\tc\\u{202e}\n"
        );
    }

    #[test]
    fn a_long_message_is_cut_at_a_character() {
        let cut = at(&"あ".repeat(MAX_LINE));
        assert!(cut.len() <= MAX_LINE);
        assert!(cut.len() > MAX_LINE - 16);
        assert!(cut.ends_with("あ…\n"));
    }
}
