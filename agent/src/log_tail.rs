//! Logs of components: which lines are wanted, read from files that are written and rotated meanwhile, with a bound on
//! everything.

mod cut;
mod files;
mod live;
mod pick;
mod reader;

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

pub(crate) use self::reader::{LogReader, ReadError, Step, Wanted};

/// Most lines that are given of what is there.
const MAX_LINES: usize = 10_000;
/// Most bytes that are read, or kept, for the last lines.
const MAX_BYTES: u64 = 4 * 1024 * 1024;
/// Bytes read at once.
const BLOCK: u64 = 64 * 1024;

/// The last lines of a file from the byte `from` on, at most [`MAX_LINES`] and [`MAX_BYTES`]. Bytes that are not UTF-8
/// are replaced.
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
mod tests;
