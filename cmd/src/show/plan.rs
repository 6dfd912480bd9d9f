//! Plans on stdout: as text, as the JSON that scripts may rely on, and as graphs.

mod document;
mod own;
#[cfg(test)]
pub mod samples;

use clap::ValueEnum;
use rts_controller_api::requests::PlanResult;
use rts_plan::plan::Plan;
use rts_plan::render::{Layout, Tone, after, body, critical_path, dot, mermaid, plain, summary};
use rts_schemas::system::SystemSpec;

use crate::error::CliError;
use crate::local::plural;
use crate::output::Output;
use crate::show::table::Table;

pub use self::own::{concerns, tell, tell_refused, would_restart};

/// Most steps that are listed unasked.
const FEW: usize = 50;
/// Characters of a line of `diff` that are not broken into a block.
const WIDE: usize = 160;

/// How to print a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PlanFormat {
    /// For people
    Text,
    /// JSON
    Json,
    /// YAML
    Yaml,
    /// The steps as a graph for Graphviz
    Dot,
    /// The steps as a flow chart for Mermaid
    Mermaid,
}

/// Option of verbs that print a plan.
#[derive(Debug, Clone, clap::Args)]
pub struct PlanFormatArgs {
    /// How to print
    #[arg(short, long, value_name = "FORMAT", default_value = "text")]
    pub output: PlanFormat,
}

/// How much of a plan the text shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum View {
    /// A line for each difference, where it fits.
    Lines,
    /// A line for each field that differs, and the steps: all of them, or only if they are few.
    Steps {
        /// All.
        all: bool,
    },
}

/// Prints what changes and what restarts, with the remarks, for one system: what was changed by hand in others, and the
/// remarks on them, are left out.
pub fn print(
    result: &PlanResult,
    spec: &SystemSpec,
    format: PlanFormat,
    view: View,
    out: &Output,
) -> Result<(), CliError> {
    let result = &own::of(result, spec);
    match format {
        PlanFormat::Text => {
            remarks(result, out);
            out.result(&text(&result.plan, view, out.stdout_color()))?;
            if view != View::Lines {
                out.say(&format!("check index: {}", result.index));
            }
            Ok(())
        }
        PlanFormat::Json => out.result(&format!("{:#}", document::of(result))),
        PlanFormat::Yaml => out.result(&yaml(&document::of(result))?),
        PlanFormat::Dot => out.result(&dot::render(&result.plan)),
        PlanFormat::Mermaid => out.result(&mermaid::render(&result.plan)),
    }
}

/// The document that scripts may rely on.
pub fn json(result: &PlanResult) -> serde_json::Value {
    document::of(result)
}

/// A document as YAML.
pub fn yaml(value: &serde_json::Value) -> Result<String, CliError> {
    Ok(serde_yaml::to_string(value).map_err(std::io::Error::other)?)
}

/// What differs, the steps where they are wanted, and the summary line last.
pub fn text(plan: &Plan, view: View, color: bool) -> String {
    let inline = if view == View::Lines { usize::MAX } else { 1 };
    let layout = Layout {
        width: if view == View::Lines {
            WIDE
        } else {
            Layout::default().width
        },
        inline,
        paint: if color { &painted } else { &plain },
    };
    let mut text = body(plan, &layout);
    if let View::Steps { all } = view
        && !plan.steps.is_empty()
    {
        text.push('\n');
        text.push_str(&listed(plan, all));
        text.push('\n');
    }
    text.push_str(&paint(color, Tone::Heading, &summary(plan)));
    text.push('\n');
    text
}

/// The steps in order, or how to see them, and the path that they cannot be faster than.
fn listed(plan: &Plan, all: bool) -> String {
    let mut text = match plan.steps.len() {
        count if all || count <= FEW => steps(plan).render(true, false),
        count => format!("{}: `--steps` lists them\n", plural("step", count)),
    };
    if let Some(path) = critical_path(plan) {
        text.push_str(&path);
        text.push('\n');
    }
    text
}

fn steps(plan: &Plan) -> Table {
    let mut table = Table::new(&["STEP", "KIND", "TARGET", "NODE", "AFTER", "REASON"]);
    for step in &plan.steps {
        table.row([
            step.id.to_string(),
            step.work.kind().to_owned(),
            step.target.clone(),
            step.node.clone(),
            after(step),
            step.reason.clone(),
        ]);
    }
    table
}

fn paint(color: bool, tone: Tone, text: &str) -> String {
    if color {
        painted(tone, text)
    } else {
        plain(tone, text)
    }
}

/// In the colours that people know from other planners.
fn painted(tone: Tone, text: &str) -> String {
    use anstyle::{AnsiColor, Style};
    let style = match tone {
        Tone::Add => AnsiColor::Green.on_default(),
        Tone::Change => AnsiColor::Yellow.on_default(),
        Tone::Remove => AnsiColor::Red.on_default(),
        Tone::Restart => AnsiColor::Magenta.on_default().bold(),
        Tone::Attention => AnsiColor::Cyan.on_default(),
        Tone::Heading => Style::new().bold(),
    };
    format!("{style}{text}{style:#}")
}

/// What is said of the system beyond the plan's own notes, which its text has.
fn remarks(result: &PlanResult, out: &Output) {
    for note in document::remarks(result) {
        out.say(&format!("note: {note}"));
    }
}

#[cfg(test)]
mod tests;
