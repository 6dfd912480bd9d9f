//! A component's log that is followed: each line once, also when the stream breaks on its way.

use std::collections::VecDeque;
use std::hash::{BuildHasher, RandomState};
use std::time::Duration;

use jiff::Timestamp;
use rts_agent_api::messages::LogQuery;
use rts_controller_api::ClientError;
use rts_controller_api::client::Controller;
use rts_http::lines::Lines;
use tokio::time::{sleep, timeout};

/// First pause before another try; it doubles.
const FIRST: Duration = Duration::from_millis(200);
/// Longest pause.
const LONGEST: Duration = Duration::from_secs(5);
/// Tries before giving up: about five minutes.
const TRIES: u32 = 64;
/// How long a log may take to open, and how long a line of one that is not followed.
const ANSWER: Duration = Duration::from_secs(30);
/// Lines that are remembered.
const RECENT: usize = 4096;

/// What comes of a log.
#[derive(Debug)]
pub enum LogNews {
    /// A line.
    Line(String),
    /// The stream broke, for this reason; told once, trying goes on.
    Broke(String),
    /// It is there again; true when lines may be missing between.
    Back(bool),
    /// That was all.
    End,
}

/// The log of one component.
pub struct Log {
    controller: Controller,
    node: String,
    instance: String,
    query: LogQuery,
    lines: Option<Lines>,
    printed: Printed,
    /// Tries since it broke.
    tries: u32,
    opened: bool,
}

impl Log {
    /// Nothing is asked yet.
    pub fn new(controller: &Controller, node: &str, instance: &str, query: LogQuery) -> Self {
        Self {
            controller: controller.clone(),
            node: node.to_owned(),
            instance: instance.to_owned(),
            query,
            lines: None,
            printed: Printed::default(),
            tries: 0,
            opened: false,
        }
    }

    /// What comes next.
    pub async fn next(&mut self) -> Result<LogNews, ClientError> {
        loop {
            let broke = match &mut self.lines {
                None => match self.open().await {
                    Ok(None) => continue,
                    Ok(Some(news)) => return Ok(news),
                    Err(e) if !self.opened || self.tries >= TRIES || is_final(&e) => return Err(e),
                    Err(e) => e.to_string(),
                },
                Some(lines) => match next(lines, self.query.follow).await {
                    Some(Ok(line)) if self.printed.is_new(&line) => {
                        return Ok(LogNews::Line(line));
                    }
                    Some(Ok(_)) => continue,
                    None if !self.query.follow => return Ok(LogNews::End),
                    Some(Err(reason)) if !self.query.follow => {
                        return Err(self.controller.silent(&reason));
                    }
                    None => "it ended".to_owned(),
                    Some(Err(reason)) => reason,
                },
            };
            self.lines = None;
            self.tries += 1;
            if self.tries == 1 {
                return Ok(LogNews::Broke(broke));
            }
        }
    }

    /// Opens the stream where it broke; tells when it is back.
    async fn open(&mut self) -> Result<Option<LogNews>, ClientError> {
        let mut query = self.query.clone();
        let mut gap = false;
        if self.tries > 0 {
            let pause = FIRST * 2u32.saturating_pow(self.tries - 1).min(64);
            sleep(pause.min(LONGEST)).await;
            match self.printed.resume() {
                Resume::Start => {}
                Resume::At(time) => {
                    query.since = Some(time.to_string());
                    query.tail = None;
                }
                Resume::Unknown => {
                    query.tail = Some(0);
                    gap = true;
                }
            }
        }
        let open = self.controller.log(&self.node, &self.instance, &query);
        let lines = timeout(ANSWER, open).await;
        self.lines = Some(lines.map_err(|_| self.controller.silent("it does not open the log"))??);
        self.opened = true;
        let back = std::mem::take(&mut self.tries) > 0;
        Ok(back.then_some(LogNews::Back(gap)))
    }
}

/// The next line, or why there is none.
async fn next(lines: &mut Lines, follow: bool) -> Option<Result<String, String>> {
    let line = if follow {
        lines.next().await
    } else {
        match timeout(ANSWER, lines.next()).await {
            Ok(line) => line,
            Err(_) => return Some(Err("the log does not go on".to_owned())),
        }
    };
    Some(line?.map_err(|e| e.to_string()))
}

/// Trying again would not help. A node that is not there may greet in a moment.
fn is_final(error: &ClientError) -> bool {
    match error {
        ClientError::Unreachable { .. } => false,
        ClientError::Protocol { .. } => true,
        ClientError::Problem(problem) => matches!(problem.status, 400 | 401 | 403),
    }
}

/// The RFC 3339 time that a line begins with.
pub fn time_of(line: &str) -> Option<Timestamp> {
    let word = line.split(' ').next()?;
    word.starts_with(|c: char| c.is_ascii_digit())
        .then(|| word.parse().ok())?
}

/// From where a stream that broke goes on.
#[derive(Debug, PartialEq, Eq)]
enum Resume {
    /// Nothing came yet.
    Start,
    /// From this time on; what came already is left out.
    At(Timestamp),
    /// No line had a time.
    Unknown,
}

/// The lines that came last.
#[derive(Debug, Default)]
struct Printed {
    hasher: RandomState,
    recent: VecDeque<(Option<Timestamp>, u64)>,
    time: Option<Timestamp>,
    /// Lines that will come again.
    expected: VecDeque<u64>,
}

impl Printed {
    /// False for a line that comes again; others are remembered.
    fn is_new(&mut self, line: &str) -> bool {
        let hash = self.hasher.hash_one(line);
        if let Some(expected) = self.expected.pop_front() {
            if expected == hash {
                return false;
            }
            // The log is another one by now.
            self.expected.clear();
        }
        let time = time_of(line);
        self.time = time.or(self.time);
        self.recent.push_back((time, hash));
        if self.recent.len() > RECENT {
            self.recent.pop_front();
        }
        true
    }

    /// The stream begins again. A line without a time belongs to the one before.
    fn resume(&mut self) -> Resume {
        let Some(since) = self.time else {
            return if self.recent.is_empty() {
                Resume::Start
            } else {
                Resume::Unknown
            };
        };
        let mut open = false;
        let again = self.recent.iter().filter(|(time, _)| {
            open = time.map_or(open, |time| time >= since);
            open
        });
        self.expected = again.map(|(_, hash)| *hash).collect();
        Resume::At(since)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What the agent sends from a time on.
    fn since(log: &[String], since: Timestamp) -> Vec<String> {
        let mut open = false;
        let wanted = log.iter().filter(|line| {
            open = time_of(line).map_or(open, |time| time >= since);
            open
        });
        wanted.cloned().collect()
    }

    #[test]
    fn without_times_it_is_not_known_where_to_go_on() {
        let mut printed = Printed::default();
        assert_eq!(printed.resume(), Resume::Start);
        assert!(printed.is_new("a") && printed.is_new("a"));
        assert_eq!(printed.resume(), Resume::Unknown);
        assert!(printed.is_new("2026-01-02T03:04:05.000Z INFO b"));
        assert!(matches!(printed.resume(), Resume::At(_)));
    }

    proptest! {
        /// However often a stream breaks, and however alike the lines are.
        #[test]
        fn each_line_comes_once(
            lines in proptest::collection::vec((proptest::option::of(0i64..2), 0u8..2), 1..60),
            breaks in proptest::collection::vec(1usize..20, 0..6),
        ) {
            let mut now = 0;
            let mut log = vec![format!("{} INFO first", Timestamp::UNIX_EPOCH)];
            for (passed, word) in lines {
                log.push(match passed {
                    Some(passed) => {
                        now += passed;
                        format!("{} INFO {word}", Timestamp::from_second(now).unwrap())
                    }
                    None => format!("  {word}"),
                });
            }
            let mut printed = Printed::default();
            let mut shown = Vec::new();
            let (mut written, mut from) = (0, None);
            for more in breaks.into_iter().chain([log.len()]) {
                written = log.len().min(written + more);
                let sent = &log[..written];
                let sent = from.map_or_else(|| sent.to_vec(), |from| since(sent, from));
                shown.extend(sent.into_iter().filter(|line| printed.is_new(line)));
                if let Resume::At(time) = printed.resume() {
                    from = Some(time);
                }
            }
            prop_assert_eq!(shown, log);
        }
    }
}
