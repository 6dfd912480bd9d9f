//! Follows a log from file to file: it is rotated, cut, removed and made again.

use std::io;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use super::files::{Part, at, former, open};

/// How long the writer may go on with a file that was moved away: it looks each second.
const GRACE: Duration = Duration::from_millis(1500);

/// What happened to a log.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum News {
    /// Bytes were added.
    Bytes(Vec<u8>),
    /// What follows begins another file, or the same one anew: a line that had no end has it now.
    Break,
    /// Nothing at the moment.
    Nothing,
}

/// A log that is followed.
#[derive(Debug)]
pub(super) struct Live {
    path: PathBuf,
    /// The file that is read; none when there was none yet.
    current: Option<Part>,
    /// Files that come after it, the last one excepted.
    between: Vec<Part>,
    /// What lay at `<path>.1` when it was last looked at. Kept open, so that no other file gets its inode.
    former: Option<Part>,
    /// Since when another file has the path.
    left: Option<Instant>,
    grace: Duration,
}

impl Live {
    /// Goes on behind what was read.
    pub fn new(path: PathBuf, current: Option<Part>) -> io::Result<Self> {
        Ok(Self {
            former: Part::open(&former(&path))?,
            path,
            current,
            between: Vec::new(),
            left: None,
            grace: GRACE,
        })
    }

    /// What comes next.
    pub fn next(&mut self) -> io::Result<News> {
        if let Some(part) = &mut self.current {
            if part.grow()? {
                return Ok(News::Break);
            }
            let bytes = part.read()?;
            if !bytes.is_empty() {
                return Ok(News::Bytes(bytes));
            }
        }
        self.step()
    }

    /// Goes to the next file when there is one.
    fn step(&mut self) -> io::Result<News> {
        if !self.between.is_empty() {
            self.current = Some(self.between.remove(0));
            return Ok(News::Break);
        }
        let own = self.current.as_ref().map(|part| part.identity);
        let there = at(&self.path)?;
        if there.is_none() || there == own {
            self.left = None;
            return Ok(News::Nothing);
        }
        let left = *self.left.get_or_insert_with(Instant::now);
        if own.is_some() && left.elapsed() < self.grace {
            return Ok(News::Nothing);
        }
        self.left = None;
        let known = [own, self.former.as_ref().map(|part| part.identity)];
        let mut files = open(&self.path)?;
        // A former file that is new was written and moved away since the last look: it comes between.
        files.retain(|part| !known.contains(&Some(part.identity)));
        self.former = Part::open(&former(&self.path))?;
        if files.is_empty() {
            return Ok(News::Nothing);
        }
        self.current = Some(files.remove(0));
        self.between = files;
        Ok(News::Break)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{self, File, OpenOptions};
    use std::io::Write;
    use std::path::Path;

    fn live(path: &Path) -> Live {
        let current = Part::open(path).unwrap().map(|mut part| {
            part.at = part.end;
            part
        });
        let mut live = Live::new(path.to_owned(), current).unwrap();
        live.grace = Duration::ZERO;
        live
    }

    fn append(path: &Path, text: &str) -> File {
        let mut file = OpenOptions::new()
            .append(true)
            .create(true)
            .open(path)
            .unwrap();
        file.write_all(text.as_bytes()).unwrap();
        file
    }

    /// Everything until nothing comes; a break is a `|`.
    fn text(live: &mut Live) -> String {
        let mut text = String::new();
        loop {
            match live.next().unwrap() {
                News::Bytes(bytes) => text.push_str(std::str::from_utf8(&bytes).unwrap()),
                News::Break => text.push('|'),
                News::Nothing => return text,
            }
        }
    }

    #[test]
    fn only_what_is_added_comes() {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("x.log");
        append(&log, "old\n");
        let mut live = live(&log);
        assert_eq!(text(&mut live), "");
        append(&log, "a\nb");
        assert_eq!(text(&mut live), "a\nb");
        append(&log, "c\n");
        assert_eq!(text(&mut live), "c\n");
    }

    #[test]
    fn rotations_are_followed_and_a_file_between_is_not_lost() {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("x.log");
        append(&former(&log), "ancient\n");
        append(&log, "old\n");
        let mut live = live(&log);
        let mut old = append(&log, "a\n");
        fs::rename(&log, former(&log)).unwrap();
        old.write_all(b"late\n").unwrap();
        assert_eq!(text(&mut live), "a\nlate\n");
        append(&log, "b\n");
        assert_eq!(text(&mut live), "|b\n");
        // Twice between two looks.
        append(&log, "c\n");
        fs::rename(&log, former(&log)).unwrap();
        append(&log, "d\n");
        fs::rename(&log, former(&log)).unwrap();
        append(&log, "e\n");
        assert_eq!(text(&mut live), "c\n|d\n|e\n");
    }

    #[test]
    fn a_log_that_is_cut_removed_or_not_there_yet_is_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("x.log");
        let mut live = live(&log);
        assert_eq!(text(&mut live), "");
        append(&log, "a long line\n");
        assert_eq!(text(&mut live), "|a long line\n");
        fs::write(&log, "b\n").unwrap();
        assert_eq!(text(&mut live), "|b\n");
        fs::remove_file(&log).unwrap();
        assert_eq!(text(&mut live), "");
        append(&log, "c\n");
        assert_eq!(text(&mut live), "|c\n");
    }

    #[test]
    fn a_writer_may_go_on_for_a_while_with_a_file_that_was_moved_away() {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("x.log");
        let mut old = append(&log, "");
        let mut live = live(&log);
        live.grace = Duration::from_millis(50);
        fs::rename(&log, folder.path().join("elsewhere")).unwrap();
        append(&log, "new\n");
        assert_eq!(text(&mut live), "");
        old.write_all(b"late\n").unwrap();
        assert_eq!(text(&mut live), "late\n");
        std::thread::sleep(Duration::from_millis(60));
        assert_eq!(text(&mut live), "|new\n");
    }
}
