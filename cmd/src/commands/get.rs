//! `rtsctl get`.

use clap::ValueEnum;
use clap::builder::PossibleValue;
use jiff::Timestamp;
use rts_controller_api::client::Controller;
use rts_controller_api::objects::{Kind, List};
use serde_json::Value;

use crate::error::CliError;
use crate::exit::Exit;
use crate::local::plural;
use crate::session::Session;
use crate::show::lists::{self, Look};

/// Show what there is: systems, nodes, components, connectors, managers or events
///
/// With a name, only the objects of that name.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Kind of object; also singular or short: sys, no, comp, conn, mgr, ev
    kind: KindName,
    /// Name of one object
    name: Option<String>,
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

/// Prints the objects.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let controller = session.connect().await?;
    show(
        &controller,
        args.kind.0,
        args.name.as_deref(),
        &args.format,
        session,
    )
    .await
}

/// Prints objects of a kind.
pub async fn show(
    controller: &Controller,
    kind: Kind,
    name: Option<&str>,
    format: &FormatArgs,
    session: &Session,
) -> Result<Exit, CliError> {
    let list = controller.list::<Value>(kind).await;
    let list = list.map_err(CliError::request(format!("list {}", kind.plural())))?;
    let list = match name {
        Some(name) => named(list, kind, name)?,
        None => list,
    };
    match format.output {
        Format::Json | Format::Yaml => print_data(&list, name.is_some(), format, session)?,
        Format::Name => {
            let line = |item: &Value| format!("{}/{}\n", singular(kind), name_of(item));
            let lines: String = list.items.iter().map(line).collect();
            session.out.result(&lines)?;
        }
        Format::Table | Format::Wide => print_table(&list, kind, format, session)?,
    }
    Ok(Exit::Ok)
}

fn named(mut list: List<Value>, kind: Kind, name: &str) -> Result<List<Value>, CliError> {
    let known: Vec<_> = list.items.iter().map(name_of).collect();
    let help = format!(
        "there are: {}",
        if known.is_empty() {
            "none".to_owned()
        } else {
            known.join(", ")
        }
    );
    list.items.retain(|item| name_of(item) == name);
    if list.items.is_empty() {
        let message = format!("{}/{name} is not there", singular(kind));
        return Err(CliError::usage_help(message, help));
    }
    Ok(list)
}

fn name_of(item: &Value) -> String {
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
    let drift = lists::drift(kind, &list.items);
    if !drift.is_empty() {
        let (count, names) = (plural(singular(kind), drift.len()), drift.join(", "));
        let is = if drift.len() == 1 { "is" } else { "are" };
        session
            .out
            .say(&format!("{count} {is} in no system (drift): {names}"));
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
