//! `rtsctl explain`.

mod subject;

use std::path::PathBuf;

use clap::ValueEnum;
use rts_controller_api::requests::PlanResult;
use rts_plan::explain::{explain, explain_target, render_step, render_target};
use rts_schemas::system::SystemSpec;

use self::subject::Subject;
use crate::error::CliError;
use crate::exit::Exit;
use crate::input::{InputArgs, Source};
use crate::session::Session;
use crate::show::plan::{self, PlanFormat, View, yaml};

/// Say why a step or a change is in a plan, and why just there
///
/// Without STEP or TARGET the whole plan is shown.
#[derive(Debug, clap::Args)]
#[command(override_usage = "rtsctl explain [OPTIONS] FILE [STEP | KIND TARGET | TARGET]")]
pub struct Args {
    /// The RTS Profile, or a plan that `plan --out` saved
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// A step (`7`, or `Create component/Sine0`), or a target (`component/Sine0`, or a bare name)
    #[arg(value_name = "STEP|TARGET", num_args = 0..=2)]
    what: Vec<String>,
    /// Deployment overlays (YAML); a later one wins
    #[arg(short = 'f', long = "file", value_name = "OVERLAY")]
    overlays: Vec<PathBuf>,
    /// Name of the system [default: the profile's]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Plan only this component or connector, and what it cannot be without (may be repeated)
    #[arg(long = "target", value_name = "TARGET")]
    targets: Vec<String>,
    /// How to print
    #[arg(short, long, value_name = "FORMAT", default_value = "text")]
    output: Format,
}

/// How to print an explanation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For people
    Text,
    /// JSON
    Json,
    /// YAML
    Yaml,
}

/// Explains.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let files = InputArgs::of(args.file, args.overlays, args.name, args.targets);
    let (result, spec) = match files.load_any(&session.out)? {
        Source::Saved(saved) => (saved.result(), saved.request.spec.clone()),
        Source::System(input) => {
            let controller = session.connect().await?;
            let what = format!("plan system/{}", input.request.spec.name);
            let result = controller.plan(&input.request).await;
            (result.map_err(input.failed(what))?, input.request.spec)
        }
    };
    if args.what.is_empty() {
        let format = match args.output {
            Format::Text => PlanFormat::Text,
            Format::Json => PlanFormat::Json,
            Format::Yaml => PlanFormat::Yaml,
        };
        let view = View::Steps { all: true };
        plan::print(&result, &spec, format, view, &session.out)?;
        return Ok(Exit::Ok);
    }
    let (text, value) = told(&result, &spec, &args.what.join(" "))?;
    session.out.result(&match args.output {
        Format::Text => text,
        Format::Json => format!("{value:#}"),
        Format::Yaml => yaml(&value)?,
    })?;
    Ok(Exit::Ok)
}

/// The explanation as text and as a document.
fn told(
    result: &PlanResult,
    spec: &SystemSpec,
    what: &str,
) -> Result<(String, serde_json::Value), CliError> {
    let plan = &result.plan;
    let subject = Subject::find(plan, spec, what)?;
    let nothing = |target: &str| CliError::usage(format!("the plan says nothing of {target}"));
    match subject {
        Subject::Step(id) => {
            let told = explain(plan, id).ok_or_else(|| nothing(what))?;
            Ok((render_step(&told), serde_json::json!(told)))
        }
        Subject::Target(target) => {
            let told = explain_target(plan, &target).ok_or_else(|| nothing(&target))?;
            Ok((render_target(&told), serde_json::json!(told)))
        }
        Subject::Settled(target) => {
            let text = format!("{target} is as it should be: nothing is planned for it\n");
            Ok((text, serde_json::json!({ "target": target, "steps": [] })))
        }
    }
}

#[cfg(test)]
mod tests;
