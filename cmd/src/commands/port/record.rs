//! A recording: JSON Lines, one for each sample, in the order in which they came.

use std::io::{BufRead, Read};
use std::path::Path;

use jiff::Timestamp;
use serde::Deserialize;
use serde_json::{Value, json};

use super::inject::invalid;
use crate::error::CliError;

/// Longest line in bytes.
const MAX_LINE: u64 = 64 * 1024 * 1024;

/// A sample that was recorded.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// When it was written.
    pub time: Timestamp,
    /// The port that wrote it (`Sine0.out`).
    pub port: String,
    /// IDL repository id.
    #[serde(rename = "type")]
    pub data_type: String,
    /// What it says.
    pub value: Value,
}

/// The line of a sample, whose value is JSON already.
pub fn line(time: &str, port: &str, data_type: &str, value: &str) -> String {
    let (time, port, data_type) = (json!(time), json!(port), json!(data_type));
    format!(r#"{{"time":{time},"port":{port},"type":{data_type},"value":{value}}}"#)
}

/// Reads a recording from its beginning.
pub struct Reader {
    lines: Box<dyn BufRead>,
    file: String,
    number: u64,
}

impl Reader {
    /// Of a file; `-` is standard input.
    pub fn open(path: &Path) -> Result<Self, CliError> {
        let lines: Box<dyn BufRead> = match path.to_str() {
            Some("-") => Box::new(std::io::stdin().lock()),
            _ => {
                let file = std::fs::File::open(path).map_err(|source| CliError::Read {
                    path: path.to_owned(),
                    source,
                })?;
                Box::new(std::io::BufReader::new(file))
            }
        };
        Ok(Self {
            lines,
            file: crate::input::shown(path),
            number: 0,
        })
    }

    /// The next sample, and its place in the file.
    pub fn next(&mut self) -> Result<Option<(Record, String)>, CliError> {
        loop {
            let mut line = String::new();
            let read = self.lines.by_ref().take(MAX_LINE).read_line(&mut line);
            self.number += 1;
            let place = format!("{}:{}", self.file, self.number);
            match read {
                Ok(0) => return Ok(None),
                Ok(_) if line.trim().is_empty() => {}
                Ok(_) => {
                    let record = serde_json::from_str(&line);
                    let why = |e| format!("this is no line of a recording: {e}");
                    let record = record.map_err(|e| invalid(&place, &why(e)))?;
                    return Ok(Some((record, place)));
                }
                Err(e) => return Err(invalid(&place, &e.to_string())),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reader(text: &'static str) -> Reader {
        Reader {
            lines: Box::new(text.as_bytes()),
            file: "a.jsonl".to_owned(),
            number: 0,
        }
    }

    #[test]
    fn a_line_is_read_as_it_was_written() {
        let line = line(
            "2026-01-31T12:00:00.000000001Z",
            "A\".out",
            "IDL:RTC/TimedLong:1.0",
            r#"{"data":3}"#,
        );
        let record: Record = serde_json::from_str(&line).unwrap();
        assert_eq!(record.time.as_nanosecond() % 1_000_000_000, 1);
        assert_eq!(record.port, "A\".out");
        assert_eq!(record.value, json!({"data": 3}));
    }

    #[test]
    fn what_is_no_recording_tells_the_line() {
        let mut reader = reader("\n{\"time\": 3}\n");
        let error = reader.next().unwrap_err();
        assert!(
            error
                .line()
                .starts_with("a.jsonl:2: this is no line of a recording"),
            "{}",
            error.line()
        );
        assert_eq!(error.exit().code(), 3);
    }
}
