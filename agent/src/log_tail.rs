//! The last lines of a log, read from its end, with a bound on lines and bytes.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

/// Most lines that are given.
pub(crate) const MAX_LINES: usize = 10_000;
/// Most bytes that are read.
pub(crate) const MAX_BYTES: u64 = 4 * 1024 * 1024;
/// Bytes read at once.
const BLOCK: u64 = 64 * 1024;

/// The last `lines` lines of a file, at most [`MAX_LINES`] and [`MAX_BYTES`]. Bytes that are not UTF-8 are replaced.
pub(crate) fn tail(path: &Path, lines: usize) -> io::Result<String> {
    tail_from(path, 0, lines)
}

/// The last lines of a log that may have been rotated: what lies in `<path>.1` goes before, when there are not enough.
pub(crate) fn tail_of_log(path: &Path, lines: usize) -> io::Result<String> {
    let lines = lines.min(MAX_LINES);
    let mut old = path.as_os_str().to_owned();
    old.push(".1");
    let now = match tail(path, lines) {
        // It may be between its two names.
        Err(e) if e.kind() == io::ErrorKind::NotFound && Path::new(&old).exists() => String::new(),
        other => other?,
    };
    let missing = lines.saturating_sub(now.lines().count());
    if missing == 0 || now.len() as u64 >= MAX_BYTES {
        return Ok(now);
    }
    match tail(Path::new(&old), missing) {
        Ok(before) => Ok(before + &now),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(now),
        Err(e) => Err(e),
    }
}

/// The same, without what lies before the byte `from`.
pub(crate) fn tail_from(path: &Path, from: u64, lines: usize) -> io::Result<String> {
    let lines = lines.min(MAX_LINES);
    let mut file = File::open(path)?;
    let end = file.metadata()?.len();
    let floor = from.min(end).max(end.saturating_sub(MAX_BYTES));
    let mut start = end;
    let mut blocks = Vec::new();
    let mut breaks = 0;
    // One break more than lines: the one before the first of them.
    while start > floor && breaks <= lines {
        let size = BLOCK.min(start - floor);
        start -= size;
        file.seek(SeekFrom::Start(start))?;
        let mut block = Vec::with_capacity(size as usize);
        file.by_ref().take(size).read_to_end(&mut block)?;
        breaks += block.iter().filter(|b| **b == b'\n').count();
        blocks.push(block);
    }
    blocks.reverse();
    let bytes = blocks.concat();
    let mut skip = start_of(&bytes, lines);
    if skip == 0 && start > from.min(end) {
        // Cut by the byte bound: leave out the line of which only the end was read.
        skip = bytes
            .iter()
            .position(|b| *b == b'\n')
            .map_or(0, |at| at + 1);
    }
    Ok(String::from_utf8_lossy(&bytes[skip..]).into_owned())
}

/// Where the last `lines` lines start; 0 when all bytes are needed, or more.
fn start_of(bytes: &[u8], lines: usize) -> usize {
    if lines == 0 {
        return bytes.len();
    }
    let body = bytes.strip_suffix(b"\n").unwrap_or(bytes);
    let breaks = body.iter().enumerate().rev().filter(|(_, b)| **b == b'\n');
    breaks.map(|(at, _)| at + 1).nth(lines - 1).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(text: &[u8]) -> tempfile::NamedTempFile {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        file
    }

    #[test]
    fn the_last_lines_come_whole() {
        let file = log(b"one\ntwo\nthree\n");
        assert_eq!(tail(file.path(), 2).unwrap(), "two\nthree\n");
        assert_eq!(tail(file.path(), 3).unwrap(), "one\ntwo\nthree\n");
        assert_eq!(tail(file.path(), 99).unwrap(), "one\ntwo\nthree\n");
        assert_eq!(tail(file.path(), 0).unwrap(), "");
        assert_eq!(tail(log(b"a\nb").path(), 1).unwrap(), "b");
        assert_eq!(tail(log(b"").path(), 1).unwrap(), "");
        assert_eq!(tail(log(b"\n\n").path(), 1).unwrap(), "\n");
        assert_eq!(tail_from(file.path(), 8, 9).unwrap(), "three\n");
        assert_eq!(tail_from(file.path(), 999, 9).unwrap(), "");
    }

    #[test]
    fn a_rotated_log_gives_what_is_missing() {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("x.log");
        assert!(tail_of_log(&log, 9).is_err());
        std::fs::write(folder.path().join("x.log.1"), "one\ntwo\n").unwrap();
        assert_eq!(tail_of_log(&log, 1).unwrap(), "two\n");
        std::fs::write(&log, "three\n").unwrap();
        assert_eq!(tail_of_log(&log, 1).unwrap(), "three\n");
        assert_eq!(tail_of_log(&log, 2).unwrap(), "two\nthree\n");
        assert_eq!(tail_of_log(&log, 9).unwrap(), "one\ntwo\nthree\n");
    }

    #[test]
    fn lines_across_blocks_and_both_bounds_hold() {
        let line = format!("{}\n", "x".repeat(99));
        let file = log(line.repeat(60_000).as_bytes());
        let text = tail(file.path(), 1500).unwrap();
        assert_eq!(text, line.repeat(1500));
        assert_eq!(
            tail(file.path(), usize::MAX).unwrap(),
            line.repeat(MAX_LINES)
        );

        let long = format!("{}\n", "y".repeat(999));
        let text = tail(log(long.repeat(9000).as_bytes()).path(), MAX_LINES).unwrap();
        assert!(text.len() as u64 <= MAX_BYTES);
        assert_eq!(text, long.repeat(text.len() / long.len()));
        assert!(text.len() as u64 > MAX_BYTES - 1000);
    }
}
