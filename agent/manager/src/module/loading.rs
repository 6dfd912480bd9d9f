//! One dlopen at a time, and what was opened: an initialiser may hang for ever, and dlopen gives the old code for a
//! path that it knows, whatever lies there now.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::sync::lock;

/// An initialiser that runs for this long hangs, most likely.
const STUCK: Duration = Duration::from_millis(500);

/// The turn to open a library, and all that had it.
#[derive(Debug, Default)]
pub struct Loading {
    state: Mutex<State>,
    free: Condvar,
}

#[derive(Debug, Default)]
struct State {
    now: Option<(String, Instant)>,
    opened: BTreeMap<String, Stamp>,
}

/// One version of a file. As long as it is mapped, no other file gets its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stamp {
    file: (u64, u64),
    modified: (i64, i64),
    size: u64,
}

impl Stamp {
    /// Of what lies at a path now; none when nothing does.
    pub fn of(path: &str) -> Option<Self> {
        let file = fs::metadata(path).ok()?;
        Some(Self {
            file: (file.dev(), file.ino()),
            modified: (file.mtime(), file.mtime_nsec()),
            size: file.size(),
        })
    }
}

/// The turn; given back on drop.
pub struct Turn(Arc<Loading>);

impl Loading {
    /// Waits for the turn to open `path`; the refusal names the path whose opening does not return.
    pub fn turn(self: &Arc<Self>, path: &str, deadline: Instant) -> Result<Turn, String> {
        let left = deadline.saturating_duration_since(Instant::now());
        let (mut state, _) = self
            .free
            .wait_timeout_while(lock(&self.state), left, |state| state.now.is_some())
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(hangs) = state.hangs() {
            return Err(hangs);
        }
        state.now = Some((path.to_owned(), Instant::now()));
        Ok(Turn(Arc::clone(self)))
    }

    /// Says what is being opened, and for how long; none when nothing is.
    pub fn hangs(&self) -> Option<String> {
        lock(&self.state).hangs()
    }

    /// True when opening a module takes longer than any sound initialiser does.
    pub fn is_stuck(&self) -> bool {
        let state = lock(&self.state);
        state
            .now
            .as_ref()
            .is_some_and(|(_, since)| since.elapsed() >= STUCK)
    }

    /// Remembers that a file was opened.
    pub fn opened(&self, path: &str, stamp: Stamp) {
        lock(&self.state).opened.insert(path.to_owned(), stamp);
    }

    /// True when dlopen would give the code of a former file for the one that lies there now.
    pub fn is_stale(&self, path: &str, now: Stamp) -> bool {
        let state = lock(&self.state);
        state
            .opened
            .iter()
            .any(|(known, stamp)| (known == path || stamp.file == now.file) && *stamp != now)
    }
}

impl State {
    fn hangs(&self) -> Option<String> {
        let (path, since) = self.now.as_ref()?;
        let seconds = since.elapsed().as_secs_f64();
        Some(format!(
            "{path} has been in dlopen for {seconds:.1} s: an initialiser of the library hangs"
        ))
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        lock(&self.0.state).now = None;
        self.0.free.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_turn_is_had_by_one_and_the_others_are_told_by_whom() {
        let loading = Arc::new(Loading::default());
        let turn = loading.turn("/a.so", Instant::now()).unwrap();
        let refusal = loading.turn("/b.so", Instant::now()).err().unwrap();
        assert!(
            refusal.starts_with("/a.so has been in dlopen for 0."),
            "{refusal}"
        );
        drop(turn);
        assert_eq!(loading.hangs(), None);
        assert!(loading.turn("/b.so", Instant::now()).is_ok());
    }

    #[test]
    fn another_file_at_a_path_that_was_opened_is_stale() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).display().to_string();
        let (a, b) = (path("a.so"), path("b.so"));
        let loading = Loading::default();
        fs::write(&a, "one").unwrap();
        let first = Stamp::of(&a).unwrap();
        assert!(!loading.is_stale(&a, first));
        loading.opened(&a, first);
        assert!(!loading.is_stale(&a, first));

        // Written in place, it is stale by every name.
        fs::hard_link(&a, &b).unwrap();
        fs::write(&a, "longer").unwrap();
        let second = Stamp::of(&a).unwrap();
        assert!(loading.is_stale(&a, second));
        assert!(loading.is_stale(&b, second));

        fs::write(path("c.so"), "one").unwrap();
        let third = Stamp::of(&path("c.so")).unwrap();
        assert!(!loading.is_stale(&path("c.so"), third));
        assert!(loading.is_stale(&a, third));
    }
}
