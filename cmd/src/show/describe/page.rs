//! A page: lines with a key, then tables with a title.

use jiff::Timestamp;
use rts_controller_api::objects::{Event, Metadata, Waiting};

use super::{Scene, policy};
use crate::show::age::age;
use crate::show::progress::grouped;
use crate::show::table::Table;

/// Most events on a page; the last ones.
const EVENTS: usize = 10;

/// Lines `Key:  value`, then tables with a title.
#[derive(Default)]
pub(super) struct Page {
    lines: Vec<(&'static str, String)>,
    tables: String,
}

impl Page {
    pub fn of(metadata: &Metadata, created: Option<Timestamp>, scene: &Scene) -> Self {
        let mut page = Self::default();
        page.line("Name", &metadata.name);
        page.line("UID", &metadata.uid);
        let version = crate::commands::describe::version(metadata);
        page.line("Version", version);
        let created = created.or(metadata.creation_timestamp);
        page.line("Age", age(created, scene.now));
        if let Some(deleted) = metadata.deletion_timestamp {
            page.line("Deletion", format!("asked for {deleted}"));
        }
        page
    }

    /// A line, unless there is nothing to say.
    pub fn line(&mut self, key: &'static str, value: impl Into<String>) {
        let value = value.into();
        if !value.is_empty() {
            self.lines.push((key, value));
        }
    }

    pub fn table(&mut self, title: &str, table: &Table) {
        self.tables.push_str(&format!("{title}:\n"));
        if table.rows.is_empty() {
            self.tables.push_str("  none\n");
            return;
        }
        for line in table.render(true, false).lines() {
            self.tables.push_str(&format!("  {line}\n"));
        }
    }

    /// What waits, one under the other; what waits for the same reason on one line.
    pub fn waiting<'a>(&mut self, waiting: impl Iterator<Item = &'a Waiting>, now: Timestamp) {
        for line in grouped(waiting, |waiting| facts(waiting, now)) {
            self.line("Waits for", line);
        }
    }

    /// What a person changed by hand in an object of a system, and what becomes of it.
    pub fn drift(&mut self, target: &str, system: &str, fields: &[String], scene: &Scene) {
        if fields.is_empty() {
            return;
        }
        let own = scene.systems.iter().filter(|s| s.metadata.name == system);
        let mut told = own
            .flat_map(|s| &s.status.drift)
            .filter_map(|told| told.strip_prefix(target)?.strip_prefix(' '));
        let fields = || fields.join(", ");
        self.line("Drift", told.next().map_or_else(fields, str::to_owned));
    }

    pub fn events(&mut self, scene: &Scene, about: impl Fn(&Event) -> bool) {
        let events: Vec<_> = scene.events.iter().filter(|event| about(event)).collect();
        let mut table = Table::new(&["AGE", "TYPE", "REASON", "OBJECT", "MESSAGE"]);
        for event in events.iter().skip(events.len().saturating_sub(EVENTS)) {
            let time = event.status.time.or(event.metadata.creation_timestamp);
            let spec = &event.spec;
            table.row([
                age(time, scene.now),
                spec.kind.clone(),
                spec.reason.clone(),
                spec.object.clone(),
                spec.message.clone(),
            ]);
        }
        self.table("Events", &table);
    }

    pub fn text(self) -> String {
        let width = self.lines.iter().map(|(key, _)| key.len()).max();
        let width = width.unwrap_or_default() + 1;
        let mut text = String::new();
        for (key, value) in &self.lines {
            let key = format!("{key}:");
            text.push_str(&format!("{key:width$}  {value}\n"));
        }
        text + &self.tables
    }
}

/// ` (tried 3 times, next try in 4s, at 12:00:04Z)`.
fn facts(waiting: &Waiting, now: Timestamp) -> String {
    let mut facts = Vec::new();
    match waiting.tries {
        0 => {}
        1 => facts.push("tried once".to_owned()),
        tries => facts.push(format!("tried {tries} times")),
    }
    match waiting.next_try {
        Some(next) => {
            let when = policy::when(next, now);
            facts.push(format!("next try {}", when.as_deref().unwrap_or("now")));
        }
        None if waiting.transient => facts.push("passes by itself".to_owned()),
        None => {}
    }
    if !waiting.required {
        facts.push("not required".to_owned());
    }
    match facts.as_slice() {
        [] => String::new(),
        facts => format!(" ({})", facts.join(", ")),
    }
}
