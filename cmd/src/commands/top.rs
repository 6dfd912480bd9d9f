//! `rtsctl top`.

mod load;
mod look;
mod table;

use std::io::IsTerminal;
use std::time::Duration;

use clap::ValueEnum;
use console::Term;

use self::load::{Filter, Load, load};
use self::look::Look;
use self::table::Sort;
use super::{duration, while_read};
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Watch how fast everything runs: cycles of components, samples of connectors, and what manager processes use
///
/// Rates are those between two looks; times and latencies count from the start. On a terminal the tables are drawn anew
/// with each look, until Ctrl-C; otherwise they are printed once.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Only this table [default: all]
    what: Option<What>,
    /// Time between two looks
    #[arg(short = 'w', long, value_name = "TIME", default_value = "2s", value_parser = duration)]
    interval: Duration,
    /// Print the tables once
    #[arg(long)]
    once: bool,
    /// Only what is on this node; of connectors, those of which an end is there
    #[arg(short, long, value_name = "NODE")]
    node: Option<String>,
    /// Only what belongs to this system
    #[arg(long, value_name = "NAME")]
    system: Option<String>,
    /// Column to sort by (`reached`, `samples/s`): numbers from the highest, texts from a to z [default: name]
    #[arg(long, value_name = "COLUMN")]
    sort_by: Option<String>,
    /// How to print; `json` gives one line for each look
    #[arg(short, long, value_name = "FORMAT", default_value = "table")]
    output: Format,
}

/// A table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum What {
    /// Components: rates wanted and reached, times of their cycles
    #[value(alias = "component", alias = "comp")]
    Components,
    /// Connectors: samples and bytes per second, losses, latency
    #[value(alias = "connector", alias = "conn")]
    Connectors,
    /// Manager processes: processor and memory
    #[value(alias = "manager", alias = "mgr")]
    Managers,
}

/// How to print.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Tables
    Table,
    /// JSON
    Json,
}

impl Args {
    fn shows(&self, what: What) -> bool {
        self.what.is_none_or(|only| only == what)
    }
}

/// Looks again and again.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let sort = Sort::by(args.sort_by.as_deref(), |what| args.shows(what))?;
    let controller = session.connect().await?;
    let filter = Filter {
        node: args.node.as_deref(),
        system: args.system.as_deref(),
    };
    let again = !args.once && std::io::stdout().is_terminal();
    let work = async {
        let mut before = Look::at(&controller, &args).await?;
        filter.check(&before)?;
        loop {
            tokio::time::sleep(args.interval).await;
            let now = Look::at(&controller, &args).await?;
            let load = load(&before, &now, &filter);
            match args.output {
                Format::Json => session.out.result(&line(&load)?)?,
                Format::Table if again => draw(&tables(&load, &args, &sort, session), session)?,
                Format::Table => session.out.result(&tables(&load, &args, &sort, session))?,
            }
            if !again {
                return Ok(Exit::Ok);
            }
            before = now;
        }
    };
    while_read(work, session).await
}

fn line(load: &Load) -> Result<String, CliError> {
    Ok(serde_json::to_string(load).map_err(std::io::Error::other)?)
}

fn tables(load: &Load, args: &Args, sort: &Sort, session: &Session) -> String {
    let color = session.out.stdout_color();
    let mut texts = Vec::new();
    if args.shows(What::Components) {
        texts.push(table::components(&load.components, sort).render(true, color));
    }
    if args.shows(What::Connectors) {
        texts.push(table::connectors(&load.connectors, sort).render(true, color));
    }
    if args.shows(What::Managers) {
        texts.push(table::managers(&load.managers, sort).render(true, color));
    }
    texts.join("\n")
}

/// Draws over what was drawn before, as far as there is room.
fn draw(text: &str, session: &Session) -> Result<(), CliError> {
    const HOME: &str = "\x1b[H";
    const REST_OF_LINE: &str = "\x1b[K";
    const REST: &str = "\x1b[J";
    let (height, width) = Term::stdout().size_checked().unwrap_or((24, 80));
    let lines: Vec<&str> = text.lines().collect();
    // The last line would scroll the first one away.
    let room = usize::from(height).saturating_sub(1);
    let mut drawn = HOME.to_owned();
    for line in lines.iter().take(room) {
        let line = console::truncate_str(line, width.into(), "");
        drawn.push_str(&format!("{line}{REST_OF_LINE}\n"));
    }
    session.out.screen(&format!("{drawn}{REST}"))
}
