//! Objects of each kind as tables.

use jiff::Timestamp;
use rts_controller_api::objects::{
    Component, Connector, Event, Kind, Latency, Manager, Node, System,
};
use rts_plan::observed::{DurationsObserved, RealtimeObserved, TimingObserved};
use rts_schemas::names::is_hidden;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::age::{age, short_time};
use super::table::Table;
use crate::error::CliError;

/// The table of some objects of one kind.
pub fn table(kind: Kind, items: &[Value], look: Look) -> Result<Table, CliError> {
    Ok(match kind {
        Kind::System => systems(&typed(kind, items)?, look),
        Kind::Node => nodes(&typed(kind, items)?, look),
        Kind::Component => components(&typed(kind, items)?, look),
        Kind::Connector => connectors(&typed(kind, items)?, look),
        Kind::Manager => managers(&typed(kind, items)?, look),
        Kind::Event => events(&typed(kind, items)?, look),
    })
}

/// Objects of a kind as this version knows them.
pub fn typed<T: DeserializeOwned>(kind: Kind, items: &[Value]) -> Result<Vec<T>, CliError> {
    let typed = items.iter().map(|item| T::deserialize(item));
    typed
        .collect::<Result<_, _>>()
        .map_err(|source| CliError::Object {
            object: format!("an object among the {}", kind.plural()),
            source,
        })
}

/// Names of those in a list that drift.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Drift {
    /// In no system's spec.
    pub extra: Vec<String>,
    /// Changed by hand.
    pub changed: Vec<String>,
}

/// What in a list drifts.
pub fn drift(kind: Kind, items: &[Value]) -> Drift {
    let mut drift = Drift::default();
    if !matches!(kind, Kind::Component | Kind::Connector) {
        return drift;
    }
    for item in items {
        let (status, name) = (&item["status"], item["metadata"]["name"].as_str());
        let by_hand = status["driftFields"]
            .as_array()
            .is_some_and(|f| !f.is_empty());
        let list = match status["drift"].as_bool() {
            Some(true) if by_hand => &mut drift.changed,
            Some(true) => &mut drift.extra,
            _ => continue,
        };
        list.extend(name.map(str::to_owned));
    }
    drift
}

/// One column: its header, whether only wide tables have it, and its cell.
struct Column<T>(&'static str, Width, fn(&T) -> String);

#[derive(Clone, Copy, PartialEq, Eq)]
enum Width {
    Any,
    Wide,
}
use Width::{Any, Wide};

/// The columns of a kind; the age is always the last one.
fn columns<T>(
    items: &[T],
    columns: &[Column<T>],
    born: fn(&T) -> Option<Timestamp>,
    look: Look,
) -> Table {
    let shown = |column: &&Column<T>| look.wide || column.1 == Any;
    let shown: Vec<_> = columns.iter().filter(shown).collect();
    let headers = shown.iter().map(|column| column.0).chain(["AGE"]);
    let mut table = Table::new(&headers.collect::<Vec<_>>());
    for item in items {
        let cells = shown.iter().map(|column| match column.0 {
            // For people; whatever stands after them is only the age.
            "MESSAGE" | "REASON" => one_line(&(column.2)(item)),
            _ => escaped(&(column.2)(item)),
        });
        table.row(cells.chain([age(born(item), look.now)]));
    }
    table
}

/// How wide a table is, and when it is looked at.
#[derive(Debug, Clone, Copy)]
pub struct Look {
    /// More columns.
    pub wide: bool,
    /// For ages.
    pub now: Timestamp,
}

fn systems(items: &[System], look: Look) -> Table {
    let all = [
        Column("NAME", Any, |s: &System| s.metadata.name.clone()),
        Column("GENERATION", Any, |s| s.metadata.generation.to_string()),
        Column("SYNCED", Any, |s| yes(s.status.synced)),
        Column("HEALTHY", Any, |s| yes(s.status.healthy)),
        Column("COMPONENTS", Any, |s| {
            format!("{}/{}", s.status.active, s.status.components)
        }),
        Column("PHASE", Any, |s| format!("{:?}", s.status.phase)),
        Column("STANDINS", Wide, |s| match s.status.stand_ins {
            0 => String::new(),
            some => format!("{some}/{}", s.status.components),
        }),
        Column("DRIFT", Wide, |s| match s.status.drift.len() {
            0 => String::new(),
            some => some.to_string(),
        }),
        Column("ID", Wide, |s| one_word(&s.spec.full_id)),
    ];
    columns(items, &all, |s| s.metadata.creation_timestamp, look)
}

fn nodes(items: &[Node], look: Look) -> Table {
    let all = [
        Column("NAME", Any, |n: &Node| n.metadata.name.clone()),
        Column("STATE", Any, |n| n.status.state.clone()),
        Column("MANAGERS", Any, |n| n.status.managers.to_string()),
        Column("COMPONENTS", Any, |n| n.status.components.to_string()),
        Column("VERSION", Any, |n| n.status.version.clone()),
        Column("TRANSPORT", Any, |n| match &n.spec.transport {
            Some(transport) => transport.kind.clone(),
            None => "local".to_owned(),
        }),
        Column("HEALING", Wide, |n| match &n.spec.transport {
            Some(transport) if !transport.resident => "on-command".to_owned(),
            _ => "by-agent".to_owned(),
        }),
        Column("ENDPOINT", Wide, |n| one_word(&n.spec.endpoint)),
    ];
    columns(items, &all, |n| n.metadata.creation_timestamp, look)
}

fn components(items: &[Component], look: Look) -> Table {
    let all = [
        Column("NAME", Any, |c: &Component| c.metadata.name.clone()),
        Column("TYPE", Any, |c| c.spec.type_name.clone()),
        Column("NODE", Any, |c| c.status.node.clone()),
        Column("MANAGER", Any, |c| c.status.manager.clone()),
        Column("STATE", Any, |c| c.status.state.clone()),
        Column("RESTARTS", Any, |c| c.status.restarts.to_string()),
        Column("SYSTEM", Wide, |c| c.spec.system.clone()),
        Column("DRIFT", Wide, |c| {
            drifted(c.status.drift, &c.status.drift_fields)
        }),
        Column("STANDIN", Wide, |c| yes(c.status.stand_in)),
        Column("PID", Wide, |c| text(c.status.pid)),
        Column("RATE", Wide, |c| {
            text(c.status.rate.map(|rate| format!("{rate}Hz")))
        }),
        Column("REACHED", Wide, |c| timing(c, reached)),
        Column("EXECUTIONS", Wide, |c| c.status.executions.to_string()),
        Column("EXEC-P99", Wide, |c| {
            timing(c, |t| short_time(t.execution.p99))
        }),
        Column("JITTER-P99", Wide, |c| {
            timing(c, |t| periodic(t, |jitter| short_time(jitter.p99)))
        }),
        Column("OVERRUNS", Wide, |c| {
            timing(c, |t| periodic(t, |_| t.overruns.to_string()))
        }),
        Column("SCHEDULER", Wide, |c| {
            c.status.realtime.as_ref().map_or(String::new(), scheduler)
        }),
        Column("REASON", Wide, |c| {
            let status = &c.status;
            let reason = status.waiting_on.as_ref().or(status.message.as_ref());
            reason.cloned().unwrap_or_default()
        }),
    ];
    let born = |c: &Component| c.status.created.or(c.metadata.creation_timestamp);
    columns(items, &all, born, look)
}

/// A cell on how it keeps its time; empty before its first cycle.
fn timing(component: &Component, cell: impl Fn(&TimingObserved) -> String) -> String {
    let timing = component.status.timing.as_ref();
    timing.map_or_else(String::new, cell)
}

/// A cell that only a periodic one has.
fn periodic(timing: &TimingObserved, cell: impl Fn(&DurationsObserved) -> String) -> String {
    timing.jitter.as_ref().map_or_else(String::new, cell)
}

fn reached(timing: &TimingObserved) -> String {
    text(timing.reached.map(|rate| format!("{rate}Hz")))
}

/// `SCHED_FIFO:50`, or what it has instead.
fn scheduler(found: &RealtimeObserved) -> String {
    match found.priority {
        0 => found.scheduler.clone(),
        priority => format!("{}:{priority}", found.scheduler),
    }
}

fn connectors(items: &[Connector], look: Look) -> Table {
    let all = [
        Column("NAME", Any, |c: &Connector| c.metadata.name.clone()),
        Column("STATE", Any, |c| c.status.state.clone()),
        Column("SENT", Any, |c| c.status.samples_sent.to_string()),
        Column("RECEIVED", Any, |c| c.status.samples_received.to_string()),
        Column("DROPS", Any, |c| c.status.drops.to_string()),
        Column("SOURCE", Wide, |c| c.spec.source.clone()),
        Column("TARGET", Wide, |c| c.spec.target.clone()),
        Column("TYPE", Wide, |c| one_word(&text(c.spec.data_type.as_ref()))),
        Column("TRANSPORT", Wide, |c| c.status.transport.clone()),
        Column("BYTES", Wide, |c| c.status.bytes.to_string()),
        Column("GAPS", Wide, |c| c.status.gaps.to_string()),
        Column("RATE", Wide, |c| c.status.rate.to_string()),
        Column("MEDIAN", Wide, |c| latency(c, |latency| latency.median_ns)),
        Column("P99", Wide, |c| latency(c, |latency| latency.p99_ns)),
        Column("SYSTEM", Wide, |c| c.spec.system.clone()),
        Column("DRIFT", Wide, |c| {
            drifted(c.status.drift, &c.status.drift_fields)
        }),
    ];
    columns(items, &all, |c| c.metadata.creation_timestamp, look)
}

fn latency(connector: &Connector, which: impl Fn(&Latency) -> u64) -> String {
    let latency = connector.status.latency.as_ref();
    latency.map_or_else(String::new, |latency| short_time(which(latency)))
}

fn managers(items: &[Manager], look: Look) -> Table {
    let all = [
        Column("NAME", Any, |m: &Manager| m.metadata.name.clone()),
        Column("NODE", Any, |m| m.status.node.clone()),
        Column("PID", Any, |m| m.status.pid.to_string()),
        Column("STATE", Any, |m| m.status.state.clone()),
        Column("COMPONENTS", Any, |m| m.status.components.len().to_string()),
        Column("INSTANCES", Wide, |m| m.status.components.join(",")),
        Column("MODULES", Wide, |m| m.status.modules.join(",")),
    ];
    let born = |m: &Manager| m.status.started.or(m.metadata.creation_timestamp);
    columns(items, &all, born, look)
}

fn events(items: &[Event], look: Look) -> Table {
    let all = [
        Column("TYPE", Any, |e: &Event| e.spec.kind.clone()),
        Column("REASON", Any, |e| e.spec.reason.clone()),
        Column("OBJECT", Any, |e| e.spec.object.clone()),
        Column("SYSTEM", Wide, |e| e.spec.system.clone()),
        Column("MESSAGE", Any, |e| e.spec.message.clone()),
    ];
    let born = |e: &Event| e.status.time.or(e.metadata.creation_timestamp);
    columns(items, &all, born, look)
}

/// Nothing becomes an empty cell.
fn text(value: Option<impl ToString>) -> String {
    value.map(|value| value.to_string()).unwrap_or_default()
}

fn yes(value: bool) -> String {
    if value { "True" } else { "False" }.to_owned()
}

/// What drifts in an object: the fields that differ, or in what way it does.
fn drifted(drift: bool, fields: &[String]) -> String {
    let name = |field: &String| one_word(field.split_once(": ").map_or(field, |(name, _)| name));
    match (drift, fields) {
        (false, _) => String::new(),
        (true, []) => "in_no_system".to_owned(),
        (true, fields) => fields.iter().map(name).collect::<Vec<_>>().join(","),
    }
}

/// A name with blanks as one cell (`My\x20Sine`): scripts split lines at blanks.
pub fn escaped(text: &str) -> String {
    let mut cell = String::new();
    for c in text.chars() {
        if !c.is_whitespace() && !is_hidden(c) {
            cell.push(c);
        } else if c.is_ascii() {
            cell.push_str(&format!("\\x{:02x}", u32::from(c)));
        } else {
            cell.push_str(&format!("\\u{{{:x}}}", u32::from(c)));
        }
    }
    cell
}

/// A value as a person wrote it: single blanks between words stay (`1.0, 2.0`), as columns are two apart.
pub fn readable(text: &str) -> String {
    let words: Vec<_> = text.split(' ').collect();
    match words.iter().any(|word| word.is_empty()) {
        true => escaped(text),
        false => {
            let words: Vec<_> = words.into_iter().map(escaped).collect();
            words.join(" ")
        }
    }
}

/// Sentences of components may have several lines; a row has one.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Scripts split lines at blanks.
fn one_word(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join("_")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::show::samples;

    fn look(wide: bool) -> Look {
        Look {
            wide,
            now: samples::NOW,
        }
    }

    fn render(kind: Kind, wide: bool) -> String {
        let items = samples::values(kind);
        table(kind, &items, look(wide)).unwrap().render(true, false)
    }

    #[test]
    fn tables_look_as_people_know_them() {
        let all: Vec<_> = Kind::ALL.iter().map(|kind| render(*kind, false)).collect();
        insta::assert_snapshot!(all.join("\n"));
    }

    #[test]
    fn wide_tables_say_more() {
        let all: Vec<_> = Kind::ALL.iter().map(|kind| render(*kind, true)).collect();
        insta::assert_snapshot!(all.join("\n"));
    }

    #[test]
    fn all_but_messages_have_no_blanks_in_a_cell() {
        for kind in Kind::ALL.into_iter().filter(|kind| *kind != Kind::Event) {
            let text = render(kind, true);
            let columns = |line: &str| line.split_whitespace().count();
            let header = columns(text.lines().next().unwrap());
            assert!(text.lines().all(|line| columns(line) == header), "{text}");
        }
    }

    #[test]
    fn a_name_with_blanks_is_one_cell() {
        assert_eq!(escaped("My Sine"), r"My\x20Sine");
        assert_eq!(escaped("左\u{3000}腕"), r"左\u{3000}腕");
        assert_eq!(escaped("50%"), "50%");
        assert_eq!(escaped("a\u{202e}b"), r"a\u{202e}b");
        assert_eq!(readable("1.0, 2.0"), "1.0, 2.0");
        assert_eq!(readable("a\rb \u{1b}[m"), r"a\x0db \x1b[m");
        assert_eq!(readable(" a"), r"\x20a");
        assert_eq!(readable("a  b"), r"a\x20\x20b");
        assert_eq!(readable(""), "");
        assert_eq!(one_line("a\n  b"), "a b");
    }

    #[test]
    fn a_wide_table_says_why() {
        let mut items = samples::values(Kind::Component);
        items[1]["status"]["waitingOn"] = "its module failed".into();
        let text = table(Kind::Component, &items, look(true)).unwrap();
        let text = text.render(true, false);
        let lines: Vec<_> = text.lines().collect();
        assert!(lines[0].ends_with("REASON             AGE"), "{text}");
        assert!(lines[2].contains("  its module failed  "), "{text}");
    }

    #[test]
    fn what_is_in_no_system_is_found() {
        let items = samples::values(Kind::Component);
        let found = drift(Kind::Component, &items);
        assert_eq!(
            (found.extra, found.changed),
            (vec!["C9".to_owned()], vec![])
        );
        let none = drift(Kind::Node, &samples::values(Kind::Node));
        assert_eq!(none, Drift::default());
    }

    #[test]
    fn what_was_changed_by_hand_is_found_and_its_fields_are_one_cell() {
        let mut items = samples::values(Kind::Component);
        items[0]["status"]["drift"] = true.into();
        items[0]["status"]["driftFields"] = [
            "configuration.default.gain: 1: a -> 2",
            "state: Active -> Inactive",
        ]
        .as_slice()
        .into();
        assert_eq!(drift(Kind::Component, &items).changed, ["Sine0"]);
        let text = table(Kind::Component, &items, look(true)).unwrap();
        let text = text.render(true, false);
        assert!(
            text.contains("  hello   configuration.default.gain,state  "),
            "{text}"
        );
        let missing = ["was disconnected by hand".to_owned()];
        assert_eq!(drifted(true, &missing), "was_disconnected_by_hand");
    }

    #[test]
    fn an_object_of_another_version_is_an_error_and_no_panic() {
        let items = [serde_json::json!({"kind": "Component"})];
        let error = table(Kind::Component, &items, look(false)).unwrap_err();
        assert_eq!(error.exit().code(), 4);
    }
}
