//! Objects one after the other as they change: rows under one header, or JSON Lines.

use jiff::Timestamp;
use rts_controller_api::API_VERSION;
use rts_controller_api::objects::Kind;
use rts_controller_api::watch::WatchType;
use serde_json::json;

use super::lists::{self, Look};
use super::table::Table;
use crate::commands::get::{Format, FormatArgs, name_of, singular};
use crate::error::CliError;
use crate::follow::Change;

/// What was printed so far, and how.
#[derive(Debug)]
pub struct Stream {
    kind: Kind,
    format: Format,
    headers: bool,
    color: bool,
    begun: bool,
    /// The widest cell of each column so far: columns stay where they are, or grow.
    widest: Vec<String>,
}

impl Stream {
    /// Nothing was printed yet.
    pub fn new(kind: Kind, format: &FormatArgs, color: bool) -> Self {
        Self {
            kind,
            format: format.output,
            headers: !format.no_headers,
            color,
            begun: false,
            widest: Vec::new(),
        }
    }

    /// The text of some changes; empty for none.
    pub fn text(&mut self, changes: &[Change], now: Timestamp) -> Result<String, CliError> {
        match self.format {
            Format::Table | Format::Wide => self.rows(changes, now),
            Format::Json => Ok(self.lines(changes)),
            Format::Yaml => {
                let mut text = String::new();
                for (kind, object) in changes {
                    let value = json!({"type": kind, "object": object});
                    text.push_str("---\n");
                    text.push_str(&serde_yaml::to_string(&value).map_err(std::io::Error::other)?);
                }
                Ok(text)
            }
            Format::Name => {
                let kind = singular(self.kind);
                let line = |(_, object): &Change| format!("{kind}/{}\n", name_of(object));
                Ok(changes.iter().map(line).collect())
            }
        }
    }

    /// JSON Lines; the first one says what they are, also when nothing follows for long.
    fn lines(&mut self, changes: &[Change]) -> String {
        let mut text = String::new();
        if !std::mem::replace(&mut self.begun, true) {
            text = format!(
                "{}\n",
                json!({"apiVersion": API_VERSION, "kind": "WatchEvent"})
            );
        }
        for (kind, object) in changes {
            text.push_str(&format!("{}\n", json!({"type": kind, "object": object})));
        }
        text
    }

    fn rows(&mut self, changes: &[Change], now: Timestamp) -> Result<String, CliError> {
        if changes.is_empty() {
            return Ok(String::new());
        }
        let wide = self.format == Format::Wide;
        let items: Vec<_> = changes.iter().map(|(_, object)| object.clone()).collect();
        let mut table = lists::table(self.kind, &items, Look { wide, now })?;
        for (row, (kind, _)) in table.rows.iter_mut().zip(changes) {
            if *kind == WatchType::Deleted
                && let Some(age) = row.last_mut()
            {
                "deleted".clone_into(age);
            }
        }
        self.widen(&table);
        table.rows.insert(0, self.widest.clone());
        let text = table.render(true, self.color);
        let headers = self.headers && !std::mem::replace(&mut self.begun, true);
        let shown = text.lines().enumerate().filter(|(line, _)| match line {
            0 => headers,
            1 => false,
            _ => true,
        });
        Ok(shown.map(|(_, line)| format!("{line}\n")).collect())
    }

    fn widen(&mut self, table: &Table) {
        self.widest.resize(table.headers.len(), String::new());
        // The last column needs no width.
        for (column, widest) in self.widest.iter_mut().rev().enumerate().skip(1) {
            let column = table.headers.len() - 1 - column;
            for row in &table.rows {
                if row[column].chars().count() > widest.chars().count() {
                    row[column].clone_into(widest);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::show::samples;

    fn stream(output: Format) -> Stream {
        let no_headers = false;
        Stream::new(Kind::Component, &FormatArgs { output, no_headers }, false)
    }

    fn change(kind: WatchType, index: usize) -> Change {
        (kind, samples::values(Kind::Component).remove(index))
    }

    #[test]
    fn rows_stay_below_their_headers() {
        let mut stream = stream(Format::Table);
        let now = samples::NOW;
        assert_eq!(stream.text(&[], now).unwrap(), "");
        let first = [change(WatchType::Added, 0), change(WatchType::Added, 1)];
        let mut text = stream.text(&first, now).unwrap();
        for change in [
            change(WatchType::Modified, 0),
            change(WatchType::Deleted, 2),
        ] {
            text.push_str(&stream.text(&[change], now).unwrap());
        }
        insta::assert_snapshot!(text, @r"
        NAME      TYPE        NODE   MANAGER   STATE     RESTARTS  AGE
        Sine0     SineSource  local  main      Active    0         5s
        Printer0  Printer     local  Printer0  Inactive  0         5s
        Sine0     SineSource  local  main      Active    0         5s
        C9        ConsoleOut  local  main      Error     0         deleted
        ");
    }

    #[test]
    fn json_lines_begin_with_the_version_of_their_format() {
        let mut stream = stream(Format::Json);
        let begin = stream.text(&[], samples::NOW).unwrap();
        assert_eq!(
            begin,
            "{\"apiVersion\":\"rtsctl.dev/v1\",\"kind\":\"WatchEvent\"}\n"
        );
        let text = stream.text(&[change(WatchType::Added, 0)], samples::NOW);
        let line: serde_json::Value = serde_json::from_str(&text.unwrap()).unwrap();
        assert_eq!(line["type"], "ADDED");
        assert_eq!(line["object"]["metadata"]["name"], "Sine0");
    }

    #[test]
    fn names_and_documents_come_one_by_one() {
        let changes = [change(WatchType::Added, 0), change(WatchType::Deleted, 2)];
        let text = |format| stream(format).text(&changes, samples::NOW).unwrap();
        assert_eq!(text(Format::Name), "component/Sine0\ncomponent/C9\n");
        assert_eq!(text(Format::Yaml).matches("---\n").count(), 2);
    }
}
