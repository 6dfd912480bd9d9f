use std::path::PathBuf;

use super::*;

struct Log {
    folder: tempfile::TempDir,
}

impl Log {
    fn new(text: impl AsRef<[u8]>) -> Self {
        let log = Self {
            folder: tempfile::tempdir().unwrap(),
        };
        std::fs::write(log.path(), text).unwrap();
        log
    }

    fn former(self, text: impl AsRef<[u8]>) -> Self {
        std::fs::write(files::former(&self.path()), text).unwrap();
        self
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("x.log")
    }

    fn read(&self, wanted: Wanted) -> Result<String, ReadError> {
        let mut reader = LogReader::open(&self.path(), wanted)?;
        all(&mut reader)
    }

    fn tail(&self, lines: usize) -> String {
        let tail = Some(lines);
        self.read(Wanted {
            tail,
            ..Wanted::default()
        })
        .unwrap()
    }
}

/// Everything until nothing comes.
fn all(reader: &mut LogReader) -> Result<String, ReadError> {
    let mut text = String::new();
    while let Step::Text(more) = reader.next()? {
        assert!(more.ends_with('\n'), "whole lines");
        text.push_str(&more);
    }
    Ok(text)
}

#[test]
fn the_end_of_a_file_comes_whole() {
    let file = Log::new(b"one\ntwo\nthree\n");
    let tail = |lines| tail_from(&file.path(), 0, lines).unwrap();
    assert_eq!(tail(2), "two\nthree\n");
    assert_eq!(tail(3), "one\ntwo\nthree\n");
    assert_eq!(tail(99), "one\ntwo\nthree\n");
    assert_eq!(tail(0), "");
    assert_eq!(tail_from(&file.path(), 8, 9).unwrap(), "three\n");
    assert_eq!(tail_from(&file.path(), 999, 9).unwrap(), "");
    assert_eq!(tail_from(&Log::new("a\nb").path(), 0, 1).unwrap(), "b");
    assert_eq!(tail_from(&Log::new("\n\n").path(), 0, 1).unwrap(), "\n");
}

#[test]
fn the_last_lines_come_whole() {
    let log = Log::new("one\ntwo\nthree\n");
    assert_eq!(log.tail(2), "two\nthree\n");
    assert_eq!(log.tail(3), "one\ntwo\nthree\n");
    assert_eq!(log.tail(99), "one\ntwo\nthree\n");
    assert_eq!(log.tail(0), "");
    assert_eq!(Log::new("a\nb").tail(1), "b\n");
    assert_eq!(Log::new("").tail(1), "");
    assert_eq!(Log::new("\n\n").tail(1), "\n");
    assert_eq!(Log::new(b"a\xff\n").tail(1), "a\u{fffd}\n");
}

#[test]
fn a_rotated_log_gives_what_is_missing() {
    let log = Log::new("three\n").former("one\ntwo\n");
    assert_eq!(log.tail(1), "three\n");
    assert_eq!(log.tail(2), "two\nthree\n");
    assert_eq!(log.tail(9), "one\ntwo\nthree\n");
    std::fs::remove_file(log.path()).unwrap();
    assert_eq!(log.tail(1), "two\n");
    std::fs::remove_file(files::former(&log.path())).unwrap();
    let reader = LogReader::open(&log.path(), Wanted::default()).unwrap();
    assert!(!reader.is_there());
}

#[test]
fn both_bounds_hold() {
    let line = format!("{}\n", "x".repeat(99));
    let log = Log::new(line.repeat(60_000));
    assert_eq!(log.tail(1500), line.repeat(1500));
    assert_eq!(log.tail(usize::MAX), line.repeat(MAX_LINES));

    let long = format!("{}\n", "y".repeat(999));
    let text = Log::new(long.repeat(9000)).tail(MAX_LINES);
    assert!(text.len() as u64 <= MAX_BYTES);
    assert_eq!(text, long.repeat(text.len() / long.len()));
    assert!(text.len() as u64 > MAX_BYTES - 1000);
}

const MARK: &str = "2026-01-02T03:04:05.000Z INFO --- a new incarnation of A begins here ---\n";

#[test]
fn the_previous_incarnation_is_found_across_a_rotation() {
    let previous = Wanted {
        previous: true,
        follow: true,
        ..Wanted::default()
    };
    let log = Log::new(format!("c\n{MARK}d\n")).former(format!("a\n{MARK}b\n"));
    assert_eq!(log.read(previous).unwrap(), "b\nc\n");
    let tail = Some(1);
    assert_eq!(log.read(Wanted { tail, ..previous }).unwrap(), "c\n");
    assert!(matches!(
        Log::new("a\n").read(previous),
        Err(ReadError::NoPrevious)
    ));
}

#[test]
fn from_a_time_on_all_lines_come_unless_fewer_are_wanted() {
    let old = "2026-01-02T03:04:05.000Z INFO old\n goes on\n";
    let new = "2026-01-02T03:04:06.000Z INFO new\n goes on\n";
    let log = Log::new(new.repeat(9000)).former(format!("{old}{new}"));
    let since = "2026-01-02T03:04:06Z".parse().ok();
    let wanted = Wanted {
        since,
        ..Wanted::default()
    };
    assert_eq!(log.read(wanted).unwrap(), new.repeat(9001));
    let tail = Some(3);
    let few = log.read(Wanted { tail, ..wanted }).unwrap();
    assert_eq!(few, format!(" goes on\n{new}"));
}

#[test]
fn a_follower_gets_the_end_and_what_is_added_each_line_once() {
    use std::io::Write;
    let log = Log::new("one\ntwo\nthr").former("zero\n");
    let wanted = Wanted {
        follow: true,
        tail: Some(1),
        ..Wanted::default()
    };
    let mut reader = LogReader::open(&log.path(), wanted).unwrap();
    assert_eq!(all(&mut reader).unwrap(), "two\n");
    assert_eq!(reader.next().unwrap(), Step::Nothing);
    let append = std::fs::OpenOptions::new().append(true).open(log.path());
    append.unwrap().write_all(b"ee\nfour\nfi").unwrap();
    assert_eq!(all(&mut reader).unwrap(), "three\nfour\n");
    // Cut: the torn line has come to its end.
    std::fs::write(log.path(), "six\n").unwrap();
    assert_eq!(all(&mut reader).unwrap(), "fi\nsix\n");
}
