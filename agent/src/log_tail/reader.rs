//! Reads the wanted lines of a log: those that are there, then, when it is followed, those that are added.

use std::collections::VecDeque;
use std::io;
use std::path::{Path, PathBuf};

use jiff::Timestamp;

use super::cut::Cutter;
use super::files::{self, Part};
use super::live::{Live, News};
use super::pick::{Last, Previous, Since};
use super::{MAX_BYTES, MAX_LINES};

/// Lines that are given when nothing else was asked for.
const DEFAULT_TAIL: usize = 200;
/// Most bytes of each file that are searched.
const MAX_SEARCH: u64 = 64 * 1024 * 1024;
/// About so many bytes are given at once.
const CHUNK: usize = 64 * 1024;

/// Which lines.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Wanted {
    /// The last so many of what is there; none for [`DEFAULT_TAIL`], or all that were searched for.
    pub tail: Option<usize>,
    /// Also those that are added.
    pub follow: bool,
    /// Those of the incarnation before the newest.
    pub previous: bool,
    /// From this time on.
    pub since: Option<Timestamp>,
}

/// What comes next.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Whole lines.
    Text(String),
    /// Nothing at the moment.
    Nothing,
    /// There is no more.
    End,
}

/// A log that cannot be read as it is wanted.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ReadError {
    /// There is but one incarnation.
    #[error(
        "the log has no previous incarnation: it was made only once, or the log was rotated since"
    )]
    NoPrevious,
    /// A file cannot be read.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// A log that is read.
#[derive(Debug)]
pub(crate) struct LogReader {
    path: PathBuf,
    follow: bool,
    stage: Stage,
    cutter: Cutter,
    since: Since,
    ready: VecDeque<String>,
}

#[derive(Debug)]
enum Stage {
    /// What was there at the start, the older file first.
    Past {
        parts: VecDeque<Part>,
        keep: Keep,
    },
    Live(Live),
    Over,
}

/// What is done with the lines that are there.
#[derive(Debug)]
enum Keep {
    All,
    Last(Last),
    Previous(Previous),
}

impl LogReader {
    /// Opens the files that are there. None need be there.
    pub fn open(path: &Path, wanted: Wanted) -> io::Result<Self> {
        let mut parts = files::open(path)?;
        let searched = wanted.previous || wanted.since.is_some();
        let limit = if searched { MAX_SEARCH } else { MAX_BYTES };
        for part in &mut parts {
            part.shorten(limit);
        }
        let last = |most: usize| Last::new(most.min(MAX_LINES), MAX_BYTES as usize);
        let keep = match wanted.tail {
            tail if wanted.previous => {
                Keep::Previous(Previous::new(last(tail.unwrap_or(MAX_LINES))))
            }
            None if searched => Keep::All,
            tail => Keep::Last(last(tail.unwrap_or(DEFAULT_TAIL))),
        };
        let parts = parts.into();
        Ok(Self {
            path: path.to_owned(),
            follow: wanted.follow && !wanted.previous,
            stage: Stage::Past { parts, keep },
            cutter: Cutter::default(),
            since: Since::new(wanted.since),
            ready: VecDeque::new(),
        })
    }

    /// True when there was a file.
    pub fn is_there(&self) -> bool {
        !matches!(&self.stage, Stage::Past { parts, .. } if parts.is_empty())
    }

    /// The next lines. Reads files: may block.
    pub fn next(&mut self) -> Result<Step, ReadError> {
        loop {
            let mut text = String::new();
            while text.len() < CHUNK
                && let Some(line) = self.ready.pop_front()
            {
                text.push_str(&line);
                text.push('\n');
            }
            if !text.is_empty() {
                return Ok(Step::Text(text));
            }
            match &mut self.stage {
                Stage::Over => return Ok(Step::End),
                Stage::Past { .. } => self.past()?,
                Stage::Live(live) => match live.next()? {
                    News::Nothing => return Ok(Step::Nothing),
                    News::Bytes(bytes) => {
                        let (ready, since) = (&mut self.ready, &mut self.since);
                        self.cutter.push(&bytes, |line| {
                            if since.takes(&line) {
                                ready.push_back(line);
                            }
                        });
                    }
                    News::Break => {
                        let line = self.cutter.finish();
                        self.ready
                            .extend(line.filter(|line| self.since.takes(line)));
                    }
                },
            }
        }
    }

    /// Reads a block of what is there, or goes on to the next stage.
    fn past(&mut self) -> Result<(), ReadError> {
        let Stage::Past { parts, keep } = &mut self.stage else {
            return Ok(());
        };
        let (ready, since) = (&mut self.ready, &mut self.since);
        let Some(part) = parts.front_mut() else {
            return self.past_is_over(None);
        };
        let mut torn = std::mem::take(&mut part.torn);
        let mut take = |line: String| {
            if std::mem::take(&mut torn) {
                return;
            }
            let wanted = since.takes(&line);
            match keep {
                Keep::Previous(previous) => previous.push(line, wanted),
                _ if !wanted => {}
                Keep::All => ready.push_back(line),
                Keep::Last(last) => last.push(line),
            }
        };
        let bytes = part.read()?;
        self.cutter.push(&bytes, &mut take);
        if !bytes.is_empty() {
            part.torn = torn;
            return Ok(());
        }
        if parts.len() == 1 && self.follow {
            // A line without an end may still get it.
            let last = parts.pop_front();
            return self.past_is_over(last);
        }
        if let Some(line) = self.cutter.finish() {
            take(line);
        }
        parts.pop_front();
        Ok(())
    }

    /// `last` is the file that is followed.
    fn past_is_over(&mut self, last: Option<Part>) -> Result<(), ReadError> {
        let next = if self.follow {
            Stage::Live(Live::new(self.path.clone(), last)?)
        } else {
            Stage::Over
        };
        let Stage::Past { keep, .. } = std::mem::replace(&mut self.stage, next) else {
            return Ok(());
        };
        match keep {
            Keep::All => {}
            Keep::Last(mut last) => self.ready.extend(last.take()),
            Keep::Previous(previous) => {
                self.ready
                    .extend(previous.end().ok_or(ReadError::NoPrevious)?);
            }
        }
        Ok(())
    }
}
