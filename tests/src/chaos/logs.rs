//! What the logs tell: no program panicked, and each component became Active when what it waits for was.
//!
//! A component's log has a line for each change of its state, with the time in milliseconds, written by its manager.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use jiff::{SignedDuration, Timestamp};

/// Times are cut to milliseconds, in each process by itself.
const CUT: SignedDuration = SignedDuration::from_millis(2);
/// So long a death may be unknown to who activates.
const UNKNOWN: SignedDuration = SignedDuration::from_millis(1500);

/// What was read of the logs.
#[derive(Debug)]
pub struct Logs {
    folder: PathBuf,
    read: BTreeMap<PathBuf, u64>,
    changes: BTreeMap<String, Vec<Change>>,
}

/// A change of state.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Change {
    at: Timestamp,
    active: bool,
}

impl Logs {
    /// Of a home; nothing is read yet.
    pub fn of(home: &Path) -> Self {
        Self {
            folder: home.join("logs"),
            read: BTreeMap::new(),
            changes: BTreeMap::new(),
        }
    }

    /// Reads what is new. Gives what must never be there.
    pub fn read(&mut self) -> Vec<String> {
        let mut found = Vec::new();
        for file in files(&self.folder) {
            let text = self.news(&file);
            let panics = text.lines().filter(|line| line.contains("panicked at"));
            let file_name = file.display();
            found.extend(panics.map(|line| format!("{file_name} says: {line}")));
            let is_component = file.parent().is_some_and(|p| p.ends_with("components"));
            if let (true, Some(stem)) = (is_component, file.file_stem()) {
                let changes = text.lines().filter_map(change);
                let all = self.changes.entry(stem.to_string_lossy().into_owned());
                all.or_default().extend(changes);
            }
        }
        found
    }

    /// Whole lines that were written since the last time.
    fn news(&mut self, file: &Path) -> String {
        let bytes = std::fs::read(file).unwrap_or_default();
        let from = self.read.entry(file.to_owned()).or_default();
        if (bytes.len() as u64) < *from {
            *from = 0;
        }
        let new = &bytes[*from as usize..];
        let end = new
            .iter()
            .rposition(|byte| *byte == b'\n')
            .map_or(0, |at| at + 1);
        *from += end as u64;
        String::from_utf8_lossy(&new[..end]).into_owned()
    }

    /// Activations since a time that came before those that they wait for: pairs of (first, then).
    pub fn out_of_order(
        &self,
        pairs: &[(String, String)],
        since: Timestamp,
        deaths: &BTreeMap<String, Vec<String>>,
    ) -> Vec<String> {
        let none = Vec::new();
        let mut found = Vec::new();
        for (first, then) in pairs {
            let firsts = self.changes.get(first).unwrap_or(&none);
            let deaths = deaths.get(first).cloned().unwrap_or_default();
            let deaths: Vec<Timestamp> = deaths.iter().filter_map(|t| t.parse().ok()).collect();
            let thens = self.changes.get(then).unwrap_or(&none);
            for at in thens
                .iter()
                .filter(|c| c.active && c.at >= since)
                .map(|c| c.at)
            {
                if !was_active(firsts, &deaths, at) {
                    found.push(format!(
                        "{then} became Active at {at} before {first}, which the order puts first"
                    ));
                }
            }
        }
        found
    }
}

/// True when a component was Active at some time shortly before.
fn was_active(changes: &[Change], deaths: &[Timestamp], at: Timestamp) -> bool {
    for (place, change) in changes.iter().enumerate() {
        if !change.active || change.at > at + CUT {
            continue;
        }
        let next = changes.get(place + 1).map(|next| next.at);
        let death = deaths
            .iter()
            .copied()
            .filter(|death| *death >= change.at)
            .min();
        let ends = [next, death].into_iter().flatten();
        let end = ends.min();
        if end.is_none_or(|end| end + UNKNOWN >= at) {
            return true;
        }
    }
    false
}

/// `TIME INFO Inactive -> Active`.
fn change(line: &str) -> Option<Change> {
    let mut words = line.split(' ');
    let at = words.next()?.parse().ok()?;
    let [_, _, arrow, to] = [words.next()?, words.next()?, words.next()?, words.next()?];
    (arrow == "->").then_some(Change {
        at,
        active: to == "Active",
    })
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        match entry.file_type() {
            Ok(kind) if kind.is_dir() => found.extend(files(&entry.path())),
            Ok(_) => found.push(entry.path()),
            Err(_) => {}
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(second: &str) -> Timestamp {
        format!("2026-11-22T10:00:{second}Z").parse().unwrap()
    }

    fn logs(first: &[&str], then: &[&str]) -> Logs {
        let folder = tempfile::tempdir().unwrap();
        let components = folder.path().join("logs/local/components");
        std::fs::create_dir_all(&components).unwrap();
        for (name, lines) in [("first", first), ("then", then)] {
            let line = |l: &&str| format!("2026-11-22T10:00:{l}\n");
            let text: String = lines.iter().map(line).collect();
            std::fs::write(components.join(format!("{name}.log")), text).unwrap();
        }
        let mut logs = Logs::of(folder.path());
        assert!(logs.read().is_empty());
        assert!(logs.read().is_empty());
        logs
    }

    fn judged(logs: &Logs, death: Option<&str>) -> usize {
        let pairs = [("first".to_owned(), "then".to_owned())];
        let deaths = death.map(|d| ("first".to_owned(), vec![at(d).to_string()]));
        logs.out_of_order(&pairs, at("00.000"), &deaths.into_iter().collect())
            .len()
    }

    const BORN: &str = "01.000Z INFO Created -> Inactive";
    const ACTIVE: &str = "02.000Z INFO Inactive -> Active";

    #[test]
    fn who_comes_after_is_in_order_and_who_comes_before_is_not() {
        assert_eq!(
            judged(
                &logs(&[BORN, ACTIVE], &["02.001Z INFO Inactive -> Active"]),
                None
            ),
            0
        );
        assert_eq!(
            judged(
                &logs(&[BORN, ACTIVE], &["01.900Z INFO Inactive -> Active"]),
                None
            ),
            1
        );
        assert_eq!(
            judged(&logs(&[], &["01.900Z INFO Inactive -> Active"]), None),
            1
        );
    }

    #[test]
    fn the_dead_are_not_active() {
        let late = logs(&[BORN, ACTIVE], &["09.000Z INFO Inactive -> Active"]);
        assert_eq!(judged(&late, None), 0);
        assert_eq!(judged(&late, Some("08.900")), 0, "nobody knew yet");
        assert_eq!(judged(&late, Some("05.000")), 1);
    }

    #[test]
    fn a_panic_is_found() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("logs")).unwrap();
        std::fs::write(
            folder.path().join("logs/agent.log"),
            "thread 'x' panicked at y\n",
        )
        .unwrap();
        assert_eq!(Logs::of(folder.path()).read().len(), 1);
    }
}
