//! What was done and when, what it came to, and how long healing took.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Lines of it that a failure shows.
const SHOWN: usize = 80;

/// Shared by all that act.
#[derive(Debug, Clone)]
pub struct Journal(Arc<Mutex<Inner>>);

#[derive(Debug)]
struct Inner {
    begin: Instant,
    lines: Vec<String>,
    actions: BTreeMap<String, u32>,
    faults: BTreeMap<String, u32>,
    healing: Vec<Duration>,
    looks: u64,
    unjudged: u64,
}

impl Journal {
    /// Begins now.
    pub fn begin() -> Self {
        Self(Arc::new(Mutex::new(Inner {
            begin: Instant::now(),
            lines: Vec::new(),
            actions: BTreeMap::new(),
            faults: BTreeMap::new(),
            healing: Vec::new(),
            looks: 0,
            unjudged: 0,
        })))
    }

    fn with<T>(&self, act: impl FnOnce(&mut Inner) -> T) -> T {
        act(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Notes a line with its time.
    pub fn note(&self, text: &str) {
        self.with(|inner| {
            let line = format!("{:8.3} {text}", inner.begin.elapsed().as_secs_f64());
            inner.lines.push(line);
        });
    }

    /// Counts something that the user did.
    pub fn count_action(&self, kind: &str) {
        self.with(|inner| *inner.actions.entry(kind.to_owned()).or_default() += 1);
    }

    /// Counts a fault.
    pub fn count_fault(&self, kind: &str) {
        self.with(|inner| *inner.faults.entry(kind.to_owned()).or_default() += 1);
    }

    /// A round healed in this time.
    pub fn count_healing(&self, time: Duration) {
        self.with(|inner| inner.healing.push(time));
    }

    /// The watcher looked; `judged`: also at the samples.
    pub fn count_look(&self, judged: bool) {
        self.with(|inner| {
            inner.looks += 1;
            inner.unjudged += u64::from(!judged);
        });
    }

    /// Since the begin.
    pub fn elapsed(&self) -> Duration {
        self.with(|inner| inner.begin.elapsed())
    }

    /// One line of progress.
    pub fn progress(&self) -> String {
        self.with(|inner| {
            let sum = |counts: &BTreeMap<String, u32>| counts.values().sum::<u32>();
            format!(
                "{:6.1} s: {} rounds, {} actions, {} faults, {} looks, longest healing {:.1} s",
                inner.begin.elapsed().as_secs_f64(),
                inner.healing.len(),
                sum(&inner.actions),
                sum(&inner.faults),
                inner.looks,
                longest(&inner.healing).as_secs_f64(),
            )
        })
    }

    /// The last lines, for a failure.
    pub fn last_lines(&self) -> String {
        self.with(|inner| {
            let from = inner.lines.len().saturating_sub(SHOWN);
            inner.lines[from..].join("\n")
        })
    }

    /// Writes all lines to a file.
    pub fn save(&self, file: &Path) -> std::io::Result<()> {
        let text = self.with(|inner| inner.lines.join("\n") + "\n");
        std::fs::write(file, text)
    }

    /// The table at the end.
    pub fn table(&self, violations: usize) -> String {
        self.with(|inner| {
            let mut text = String::new();
            for (title, counts) in [("actions", &inner.actions), ("faults", &inner.faults)] {
                let _ = writeln!(text, "{title:<40} {:>6}", counts.values().sum::<u32>());
                for (kind, count) in counts {
                    let _ = writeln!(text, "  {kind:<38} {count:>6}");
                }
            }
            let rows = [
                ("rounds", inner.healing.len().to_string()),
                ("looks of the watcher", inner.looks.to_string()),
                (
                    "looks without samples (machine too slow)",
                    inner.unjudged.to_string(),
                ),
                (
                    "longest healing",
                    format!("{:.1} s", longest(&inner.healing).as_secs_f64()),
                ),
                ("violations", violations.to_string()),
            ];
            for (name, value) in rows {
                let _ = writeln!(text, "{name:<40} {value:>6}");
            }
            text
        })
    }
}

fn longest(times: &[Duration]) -> Duration {
    times.iter().max().copied().unwrap_or_default()
}
