//! `rtsctl conf`.

mod set;

use clap::ValueEnum;
use rts_controller_api::objects::{Component, Kind};
use serde_json::{Value, json};

use super::by_hand::{Hand, find};
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;
use crate::show::conf::{self, InForce};

/// Show and change the configuration of a component that runs (rtconf)
///
/// Without a verb, all its configuration sets: the active one has a `*`, and what its system wants stands where it
/// differs.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Instance name; NODE/NAME where several nodes have one of that name
    #[arg(value_name = "NAME")]
    name: String,
    /// What to do.
    #[command(subcommand)]
    verb: Option<Verb>,
    /// How to print.
    #[command(flatten)]
    format: FormatArgs,
}

/// What to do with a configuration.
#[derive(Debug, clap::Subcommand)]
enum Verb {
    /// Show the sets and their values
    List {
        /// Only this set
        #[arg(short, long, value_name = "SET")]
        set: Option<String>,
    },
    /// Print the value of a parameter that is in force
    Get {
        /// The parameter
        #[arg(value_name = "PARAM")]
        parameter: String,
        /// The value that it has while this set is the active one [default: the active one]
        #[arg(short, long, value_name = "SET")]
        set: Option<String>,
    },
    Set(set::Args),
    /// Make a set the active one
    Act {
        /// The set
        #[arg(value_name = "SET")]
        set: String,
        /// Only say what would be done
        #[arg(long)]
        dry_run: bool,
    },
}

/// How to print a configuration.
#[derive(Debug, Clone, Copy, clap::Args)]
struct FormatArgs {
    /// How to print what is shown [default: text]
    #[arg(short, long, global = true, value_name = "FORMAT")]
    output: Option<Format>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// For people
    Text,
    /// JSON
    Json,
    /// YAML
    Yaml,
}

/// Shows it, or changes it.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let dry_run = match &args.verb {
        Some(Verb::Set(set)) => set.dry_run,
        Some(Verb::Act { dry_run, .. }) => *dry_run,
        _ => false,
    };
    let change = match &args.verb {
        Some(Verb::Set(set)) => Some(set.change()?),
        Some(Verb::Act { set, .. }) => Some(set::Change::activate(set)),
        _ => None,
    };
    if change.is_some() && args.format.output.is_some() {
        let text = "--output is for what is shown: `set` and `act` show nothing";
        return Err(CliError::usage(text));
    }
    let format = args.format.output.unwrap_or(Format::Text);
    let hand = Hand::reach(dry_run, session).await?;
    let components: Vec<Component> = hand.list(Kind::Component).await?;
    let component = find::component(&args.name, &components)?;
    if let Some(change) = change {
        return change.ask(component, &hand).await;
    }
    let text = match &args.verb {
        Some(Verb::Get { parameter, set }) => {
            let value = conf::in_force(component, parameter, set.as_deref())?;
            one(component, parameter, &value, format)?
        }
        Some(Verb::List { set }) => all(component, set.as_deref(), format, session)?,
        _ => all(component, None, format, session)?,
    };
    if component.status.state == "Unknown" {
        let name = &component.metadata.name;
        let text = format!("component/{name} is Unknown: this is what was known of it last");
        session.out.warn(&text);
    }
    session.out.result(&text)?;
    Ok(Exit::Ok)
}

/// One value; alone for people.
fn one(
    component: &Component,
    parameter: &str,
    value: &InForce<'_>,
    format: Format,
) -> Result<String, CliError> {
    if format == Format::Text {
        return Ok(format!("{}\n", value.value));
    }
    let value = json!({
        "component": component.metadata.name,
        "node": component.status.node,
        "set": value.set,
        "parameter": parameter,
        "value": value.value,
    });
    data(&value, format)
}

/// All sets, or one.
fn all(
    component: &Component,
    set: Option<&str>,
    format: Format,
    session: &Session,
) -> Result<String, CliError> {
    if let Some(set) = set {
        conf::has_set(component, set)?;
    }
    if format == Format::Text {
        let table = conf::table(component, set);
        if table.rows.is_empty() {
            let name = &component.metadata.name;
            let text = format!("component/{name} has no parameters");
            session.out.say(&text);
            return Ok(String::new());
        }
        return Ok(table.render(true, session.out.stdout_color()));
    }
    let mut is = component.status.configuration.clone();
    let mut wanted = component.spec.configuration.clone();
    for configuration in [&mut is, &mut wanted] {
        let sets = &mut configuration.sets;
        sets.retain(|name, _| set.is_none_or(|set| set == name));
    }
    let value = json!({
        "component": component.metadata.name,
        "node": component.status.node,
        "active": is.active,
        "sets": is.sets,
        "wanted": wanted,
    });
    data(&value, format)
}

fn data(value: &Value, format: Format) -> Result<String, CliError> {
    Ok(match format {
        Format::Yaml => serde_yaml::to_string(value).map_err(std::io::Error::other)?,
        Format::Text | Format::Json => format!("{value:#}"),
    })
}
