//! Lines of a file or FIFO, without waiting and within bounds.

use std::collections::VecDeque;
use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Read};
use std::os::unix::fs::OpenOptionsExt;

use rustix::fs::OFlags;

/// Bytes that are read at a time.
const CHUNK: usize = 4096;
/// Longest line; what is longer is cut there and so becomes several.
const MAX_LINE: usize = 256;

/// A source of lines.
pub struct Lines {
    file: File,
    /// Lines that were read and not taken yet.
    ready: VecDeque<String>,
    /// A line whose end has not come yet.
    rest: Vec<u8>,
}

impl Lines {
    /// Opens a file or FIFO. A FIFO that nobody writes to is no error.
    pub fn open(path: &str) -> io::Result<Self> {
        let flags = (OFlags::NONBLOCK | OFlags::CLOEXEC).bits();
        let file = OpenOptions::new()
            .read(true)
            .custom_flags(flags as i32)
            .open(path)?;
        if file.metadata()?.is_dir() {
            return Err(ErrorKind::IsADirectory.into());
        }
        Ok(Self {
            file,
            ready: VecDeque::new(),
            rest: Vec::new(),
        })
    }

    /// The next line, if it is complete by now. Reads one chunk at most.
    pub fn next_line(&mut self) -> io::Result<Option<String>> {
        if self.ready.is_empty() {
            let mut chunk = [0; CHUNK];
            // No bytes: the end of a file that may grow, or a FIFO whose writer is gone and may come back.
            let len = match self.file.read(&mut chunk) {
                Ok(len) => len,
                Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => 0,
                Err(error) => return Err(error),
            };
            self.split(&chunk[..len]);
        }
        Ok(self.ready.pop_front())
    }

    fn split(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            if byte != b'\n' {
                self.rest.push(byte);
            }
            if byte == b'\n' || self.rest.len() == MAX_LINE {
                let line = std::mem::take(&mut self.rest);
                self.ready
                    .push_back(String::from_utf8_lossy(&line).into_owned());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_without_end_is_cut() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), vec![b'x'; MAX_LINE * 2 + 1]).unwrap();
        let mut lines = Lines::open(file.path().to_str().unwrap()).unwrap();
        for _ in 0..2 {
            assert_eq!(lines.next_line().unwrap().unwrap().len(), MAX_LINE);
        }
        assert_eq!(lines.next_line().unwrap(), None);
        assert_eq!(lines.rest.len(), 1);
    }

    #[test]
    fn a_folder_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let error = Lines::open(dir.path().to_str().unwrap()).err().unwrap();
        assert_eq!(error.kind(), ErrorKind::IsADirectory);
    }
}
