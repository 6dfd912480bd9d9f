//! `rtsctl get`.

mod watch;

use clap::ValueEnum;
use clap::builder::PossibleValue;
use jiff::Timestamp;
use rts_controller_api::client::Controller;
use rts_controller_api::objects::{Kind, List};
use rts_schemas::suggest;
use serde_json::Value;

use crate::error::CliError;
use crate::exit::Exit;
use crate::local::plural;
use crate::session::Session;
use crate::show::lists::{self, Look};

pub use self::watch::watch;

/// Show what there is: systems, nodes, components, connectors, managers or events
///
/// With a name, only the objects of that name.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Kind of object; also singular or short: sys, no, comp, conn, mgr, ev
    kind: KindName,
    /// Name of one object
    name: Option<String>,
    /// Print what there is, then a line for each change, until Ctrl-C; `-o json` gives JSON Lines of {type, object}
    #[arg(short, long)]
    watch: bool,
    /// As --watch, without what there is
    #[arg(long)]
    watch_only: bool,
    /// How to print.
    #[command(flatten)]
    format: FormatArgs,
}

/// How to print a list.
#[derive(Debug, Clone, clap::Args)]
pub struct FormatArgs {
    /// How to print
    #[arg(short, long, value_name = "FORMAT", default_value = "table")]
    pub output: Format,
    /// Leave out the line of headers
    #[arg(long)]
    pub no_headers: bool,
}

/// How to print a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Columns
    Table,
    /// More columns
    Wide,
    /// JSON, as the API has it
    Json,
    /// YAML, as the API has it
    Yaml,
    /// KIND/NAME
    Name,
}

/// A kind as people type it: plural, singular or short.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KindName(pub Kind);

impl ValueEnum for KindName {
    fn value_variants<'a>() -> &'a [Self] {
        &[
            KindName(Kind::System),
            KindName(Kind::Node),
            KindName(Kind::Component),
            KindName(Kind::Connector),
            KindName(Kind::Manager),
            KindName(Kind::Event),
        ]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let (singular, short) = match self.0 {
            Kind::System => ("system", "sys"),
            Kind::Node => ("node", "no"),
            Kind::Component => ("component", "comp"),
            Kind::Connector => ("connector", "conn"),
            Kind::Manager => ("manager", "mgr"),
            Kind::Event => ("event", "ev"),
        };
        Some(PossibleValue::new(self.0.plural()).aliases([singular, short]))
    }
}

/// `component` of `Kind::Component`.
pub fn singular(kind: Kind) -> &'static str {
    kind.plural().trim_end_matches('s')
}

/// Which objects of a kind are meant.
#[derive(Debug, Clone)]
pub struct Selection<'a> {
    /// Kind.
    pub kind: Kind,
    /// Only the object of this name, which must be there.
    pub name: Option<&'a str>,
    /// Only what belongs to this system.
    pub system: Option<&'a str>,
    /// Only events about this object (`component/Sine0`).
    pub about: Option<&'a str>,
}

impl<'a> Selection<'a> {
    /// All objects of a kind, or one.
    pub fn of(kind: Kind, name: Option<&'a str>) -> Self {
        Self {
            kind,
            name,
            system: None,
            about: None,
        }
    }

    /// True for an object that is meant.
    pub fn takes(&self, item: &Value) -> bool {
        self.name.is_none_or(|name| name_of(item) == name)
            && self
                .system
                .is_none_or(|name| item["spec"]["system"] == name)
            && self
                .about
                .is_none_or(|object| item["spec"]["object"] == object)
    }

    /// True when the object that was named is not among these.
    fn lacks<'v>(&self, mut items: impl Iterator<Item = &'v Value>) -> bool {
        self.name.is_some() && !items.any(|item| self.takes(item))
    }
}

/// Prints the objects.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let controller = session.connect().await?;
    let selection = Selection::of(args.kind.0, args.name.as_deref());
    if args.watch || args.watch_only {
        return watch(
            &controller,
            &selection,
            args.watch_only,
            &args.format,
            session,
        )
        .await;
    }
    show(&controller, &selection, &args.format, session).await
}

/// Prints the objects as they are.
pub async fn show(
    controller: &Controller,
    selection: &Selection<'_>,
    format: &FormatArgs,
    session: &Session,
) -> Result<Exit, CliError> {
    let kind = selection.kind;
    let list = controller.list::<Value>(kind).await;
    let mut list = list.map_err(CliError::request(format!("list {}", kind.plural())))?;
    if selection.lacks(list.items.iter()) {
        return Err(not_there(selection, list.items.iter()));
    }
    list.items.retain(|item| selection.takes(item));
    match format.output {
        Format::Json | Format::Yaml => {
            print_data(&list, selection.name.is_some(), format, session)?;
        }
        Format::Name => {
            let line = |item: &Value| format!("{}/{}\n", singular(kind), name_of(item));
            let lines: String = list.items.iter().map(line).collect();
            session.out.result(&lines)?;
        }
        Format::Table | Format::Wide => print_table(&list, kind, format, session)?,
    }
    Ok(Exit::Ok)
}

/// The error for an object that is not there, with the names of those that are.
fn not_there<'v>(selection: &Selection<'_>, items: impl Iterator<Item = &'v Value>) -> CliError {
    let known: Vec<_> = items.map(name_of).collect();
    absent(selection.kind, selection.name.unwrap_or_default(), &known)
}

/// The error for an object that is not there, with the nearest of the names that are.
pub fn absent(kind: Kind, name: &str, known: &[impl AsRef<str>]) -> CliError {
    let near = suggest::nearest(name, known.iter().map(AsRef::as_ref));
    let near = near.map(|near| format!("did you mean `{near}`? "));
    CliError::usage_help(
        format!("{}/{name} is not there", singular(kind)),
        near.unwrap_or_default() + &there_are(known),
    )
}

/// `there are: A, B`.
pub fn there_are(known: &[impl AsRef<str>]) -> String {
    let known = match suggest::listed(known.iter().map(AsRef::as_ref)) {
        none if none.is_empty() => "none".to_owned(),
        listed => listed,
    };
    format!("there are: {known}")
}

/// `metadata.name` of an object.
pub fn name_of(item: &Value) -> String {
    item["metadata"]["name"]
        .as_str()
        .unwrap_or_default()
        .to_owned()
}

fn print_data(
    list: &List<Value>,
    single: bool,
    format: &FormatArgs,
    session: &Session,
) -> Result<(), CliError> {
    let value = match list.items.as_slice() {
        [item] if single => item.clone(),
        _ => serde_json::json!(list),
    };
    let text = match format.output {
        Format::Yaml => serde_yaml::to_string(&value).map_err(std::io::Error::other)?,
        _ => format!("{value:#}"),
    };
    session.out.result(&text)
}

fn print_table(
    list: &List<Value>,
    kind: Kind,
    format: &FormatArgs,
    session: &Session,
) -> Result<(), CliError> {
    if list.items.is_empty() {
        session.out.say(&format!("no {}", kind.plural()));
        return Ok(());
    }
    let look = Look {
        wide: format.output == Format::Wide,
        now: Timestamp::now(),
    };
    let table = lists::table(kind, &list.items, look)?;
    let text = table.render(!format.no_headers, session.out.stdout_color());
    session.out.result(&text)?;
    let stand_ins = list
        .items
        .iter()
        .filter(|item| item["status"]["standIn"] == true);
    match stand_ins.count() {
        0 => {}
        some => session
            .out
            .say(&format!("{some} of {} are stand-ins", list.items.len())),
    }
    let drift = lists::drift(kind, &list.items);
    for (names, one, more, what) in [
        (&drift.extra, "is", "are", "in no system"),
        (&drift.changed, "was", "were", "changed by hand"),
    ] {
        if !names.is_empty() {
            let count = plural(singular(kind), names.len());
            let is = if names.len() == 1 { one } else { more };
            let names = suggest::listed(names.iter().map(String::as_str));
            session
                .out
                .say(&format!("{count} {is} {what} (drift): {names}"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_have_plural_singular_and_short_names() {
        for (text, kind) in [
            ("components", Kind::Component),
            ("component", Kind::Component),
            ("comp", Kind::Component),
            ("conn", Kind::Connector),
            ("mgr", Kind::Manager),
            ("ev", Kind::Event),
            ("nodes", Kind::Node),
        ] {
            assert_eq!(KindName::from_str(text, true), Ok(KindName(kind)), "{text}");
        }
    }

    #[test]
    fn every_kind_can_be_asked_for() {
        let asked: Vec<_> = KindName::value_variants().iter().map(|k| k.0).collect();
        assert_eq!(asked, Kind::ALL);
    }
}
