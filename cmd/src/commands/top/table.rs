//! The tables, and their order.

use std::cmp::Ordering;

use rts_schemas::suggest::advice;

use super::What;
use super::load::{ComponentLoad, ConnectorLoad, ManagerLoad};
use crate::error::CliError;
use crate::show::age::short_time;
use crate::show::size::{bytes, number};
use crate::show::table::Table;

/// A cell, and what it is sorted by.
enum Cell {
    Text(String),
    Number(Option<f64>, fn(f64) -> String),
}

impl Cell {
    fn shown(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Number(value, show) => value.map_or_else(String::new, show),
        }
    }

    /// Texts from a to z, numbers from the highest, and what is not known last.
    fn order(&self, other: &Self) -> Ordering {
        match (self, other) {
            (Self::Text(one), Self::Text(other)) => one.cmp(other),
            (Self::Number(one, _), Self::Number(other, _)) => match (one, other) {
                (Some(one), Some(other)) => other.total_cmp(one),
                (one, other) => other.is_some().cmp(&one.is_some()),
            },
            (Self::Text(_), Self::Number(..)) => Ordering::Less,
            (Self::Number(..), Self::Text(_)) => Ordering::Greater,
        }
    }
}

/// A column: its header, and its cell in a row.
type Column<T> = (&'static str, fn(&T) -> Cell);

const COMPONENTS: [Column<ComponentLoad>; 10] = [
    ("NAME", |c| text(&c.name)),
    ("NODE", |c| text(&c.node)),
    ("STATE", |c| text(&c.state)),
    ("WANTED", |c| hertz(c.wanted)),
    ("REACHED", |c| hertz(c.reached)),
    ("OVERRUNS/S", |c| Cell::Number(c.overruns, number)),
    ("EXEC", |c| time(c.execution_ns)),
    ("EXEC-P99", |c| time(c.execution_p99_ns)),
    ("JITTER-P99", |c| time(c.jitter_p99_ns)),
    ("SYSTEM", |c| text(&c.system)),
];

const CONNECTORS: [Column<ConnectorLoad>; 10] = [
    ("NAME", |c| text(&c.name)),
    ("STATE", |c| text(&c.state)),
    ("SAMPLES/S", |c| Cell::Number(c.samples, number)),
    ("BYTES/S", |c| Cell::Number(c.bytes, bytes_word)),
    ("DROPS/S", |c| Cell::Number(c.drops, number)),
    ("GAPS/S", |c| Cell::Number(c.gaps, number)),
    ("MEDIAN", |c| time(c.median_ns)),
    ("P99", |c| time(c.p99_ns)),
    ("TRANSPORT", |c| text(&c.transport)),
    ("SYSTEM", |c| text(&c.system)),
];

const MANAGERS: [Column<ManagerLoad>; 8] = [
    ("NAME", |m| text(&m.name)),
    ("NODE", |m| text(&m.node)),
    ("STATE", |m| text(&m.state)),
    ("PID", |m| Cell::Number(Some(m.pid.into()), whole)),
    ("CPU", |m| {
        Cell::Number(m.cpu, |cpu| format!("{:.1}%", cpu * 100.0))
    }),
    ("MEMORY", |m| {
        Cell::Number(m.memory.map(|m| m as f64), bytes_word)
    }),
    ("COMPONENTS", |m| {
        Cell::Number(Some(m.components as f64), whole)
    }),
    ("TAPS", |m| Cell::Number(Some(m.taps as f64), whole)),
];

fn text(text: &str) -> Cell {
    Cell::Text(text.to_owned())
}

fn hertz(value: Option<f64>) -> Cell {
    Cell::Number(value, |value| format!("{}Hz", number(value)))
}

fn time(nanoseconds: Option<u64>) -> Cell {
    Cell::Number(nanoseconds.map(|n| n as f64), |n| short_time(n as u64))
}

fn whole(value: f64) -> String {
    format!("{value:.0}")
}

/// A cell is one word.
fn bytes_word(value: f64) -> String {
    bytes(value).replace(' ', "")
}

/// The column that rows are sorted by.
#[derive(Debug, Clone, Default)]
pub struct Sort(Option<String>);

impl Sort {
    /// By a column of one of the tables that are shown.
    pub fn by(column: Option<&str>, shows: impl Fn(What) -> bool) -> Result<Self, CliError> {
        let Some(column) = column else {
            return Ok(Self(None));
        };
        let mut known = Vec::new();
        let tables = [
            (What::Components, headers(&COMPONENTS)),
            (What::Connectors, headers(&CONNECTORS)),
            (What::Managers, headers(&MANAGERS)),
        ];
        for (_, headers) in tables.into_iter().filter(|(what, _)| shows(*what)) {
            for header in headers {
                let header = header.to_lowercase();
                if !known.contains(&header) {
                    known.push(header);
                }
            }
        }
        let column = column.to_lowercase();
        if known.contains(&column) {
            return Ok(Self(Some(column)));
        }
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        Err(CliError::usage_help(
            format!("there is no column {column}"),
            advice(&column, "columns", &known),
        ))
    }
}

fn headers<T>(columns: &[Column<T>]) -> Vec<&'static str> {
    columns.iter().map(|(header, _)| *header).collect()
}

/// Components.
pub fn components(rows: &[ComponentLoad], sort: &Sort) -> Table {
    table(rows, &COMPONENTS, sort)
}

/// Connectors.
pub fn connectors(rows: &[ConnectorLoad], sort: &Sort) -> Table {
    table(rows, &CONNECTORS, sort)
}

/// Manager processes.
pub fn managers(rows: &[ManagerLoad], sort: &Sort) -> Table {
    table(rows, &MANAGERS, sort)
}

fn table<T>(rows: &[T], columns: &[Column<T>], sort: &Sort) -> Table {
    let by = sort.0.as_ref().and_then(|name| {
        let mut columns = columns.iter();
        columns.find(|(header, _)| header.to_lowercase() == *name)
    });
    let mut rows: Vec<&T> = rows.iter().collect();
    if let Some((_, cell)) = by {
        // Rows that are alike stay as they came, by name.
        rows.sort_by(|one, other| cell(one).order(&cell(other)));
    }
    let mut table = Table::new(&headers(columns));
    for row in rows {
        table.row(columns.iter().map(|(_, cell)| cell(row).shown()));
    }
    table
}

#[cfg(test)]
mod tests {
    use super::super::load::{Filter, load, tests::looks};
    use super::*;

    fn all(sort: Option<&str>) -> String {
        let (before, now) = looks();
        let load = load(&before, &now, &Filter::default());
        let sort = Sort::by(sort, |_| true).unwrap();
        let tables = [
            components(&load.components, &sort),
            connectors(&load.connectors, &sort),
            managers(&load.managers, &sort),
        ];
        tables.map(|table| table.render(true, false)).join("\n")
    }

    #[test]
    fn tables_look_as_people_know_them() {
        insta::assert_snapshot!(all(None));
    }

    #[test]
    fn numbers_are_sorted_from_the_highest_and_what_is_not_known_is_last() {
        let first = |sort| {
            let text = all(Some(sort));
            let rows = text.lines().skip(1).take(3);
            let names = rows.map(|row| row.split(' ').next().unwrap_or_default().to_owned());
            names.collect::<Vec<_>>()
        };
        assert_eq!(first("reached")[0], "Sine0");
        assert_eq!(first("State"), ["Sine0", "C9", "Printer0"]);
        let number = |n| Cell::Number(n, number);
        assert_eq!(number(None).order(&number(Some(1.0))), Ordering::Greater);
        assert_eq!(number(Some(1.0)).order(&number(None)), Ordering::Less);
        assert_eq!(number(None).order(&number(None)), Ordering::Equal);
    }

    #[test]
    fn a_column_that_is_not_shown_is_refused_with_those_that_are() {
        let only = |what| what == What::Managers;
        let error = Sort::by(Some("memry"), only).unwrap_err();
        assert_eq!(error.line(), "there is no column memry");
        let help = error.help().unwrap();
        assert!(help.starts_with("did you mean `memory`?"), "{help}");
        assert!(Sort::by(Some("reached"), only).is_err());
        assert!(Sort::by(Some("CPU"), only).is_ok());
    }
}
