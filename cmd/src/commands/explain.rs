//! `rtsctl explain`.

mod subject;

use std::path::PathBuf;

use clap::ValueEnum;
use rts_controller_api::requests::PlanResult;
use rts_plan::explain::{explain, explain_target, render_step, render_target};
use rts_schemas::docs;
use rts_schemas::system::SystemSpec;

use self::subject::Subject;
use crate::error::CliError;
use crate::exit::Exit;
use crate::input::{InputArgs, Source};
use crate::output::Output;
use crate::session::Session;
use crate::show::fields as show;
use crate::show::plan::{self, PlanFormat, View, yaml};

/// Say what a field of a profile means, or why a step or a change is in a plan
///
/// `rtsctl explain system.components.dataPorts` says what a field is: paths start with `system` (RTS Profile), `component`
/// (RTC Profile) or `overlay`, and go on with keys of YAML or names of XML. Where there is a file of that name, it is taken for the file.
///
/// `rtsctl explain FILE [STEP|TARGET]` says why a step or a change is in the plan for a system, and why just there; without
/// STEP or TARGET the whole plan is shown. `rtsctl explain-plan` does only this.
#[derive(Debug, clap::Args)]
#[command(
    override_usage = "rtsctl explain [OPTIONS] PATH\n       rtsctl explain [OPTIONS] FILE [STEP | KIND TARGET | TARGET]"
)]
pub struct Args {
    /// What is explained.
    #[command(flatten)]
    pub plan: PlanArgs,
    /// Show all fields below the field, by name
    #[arg(long)]
    recursive: bool,
    /// Explain this version of the profile (`0.1`) [default: the newest]
    #[arg(long, value_name = "VERSION")]
    profile_version: Option<String>,
}

impl Args {
    /// A field is asked for, and not a plan.
    pub fn is_field(&self) -> bool {
        let plan = &self.plan;
        let alone = plan.what.is_empty() && plan.overlays.is_empty() && plan.targets.is_empty();
        let path = plan.file.to_str().filter(|path| docs::is_path(path));
        let asked = self.recursive || self.profile_version.is_some();
        alone && plan.name.is_none() && (asked || path.is_some() && !plan.file.exists())
    }
}

/// Explains a field.
pub fn fields(args: &Args, out: &Output) -> Result<Exit, CliError> {
    let path = args.plan.file.to_string_lossy();
    let found = docs::find(&path, args.profile_version.as_deref()).map_err(|error| {
        let mut message = error.message;
        // `system.xml` is also the name of a file.
        if args
            .plan
            .file
            .extension()
            .is_some_and(|e| e == "xml" || e == "yaml" || e == "rtsys")
        {
            message = format!("there is no file {path}, and {message}");
        }
        CliError::usage_help(message, error.help)
    })?;
    out.result(&match args.plan.output {
        Format::Text => show::text(&found, args.recursive),
        Format::Json => format!("{:#}", show::value(&found, args.recursive)),
        Format::Yaml => yaml(&show::value(&found, args.recursive))?,
    })?;
    Ok(Exit::Ok)
}

/// Say why a step or a change is in a plan, and why just there
///
/// Without STEP or TARGET the whole plan is shown.
#[derive(Debug, clap::Args)]
#[command(override_usage = "rtsctl explain-plan [OPTIONS] FILE [STEP | KIND TARGET | TARGET]")]
pub struct PlanArgs {
    /// The RTS Profile, or a plan that `plan --out` saved; or the path of a field
    #[arg(value_name = "FILE|PATH")]
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

/// Explains a plan.
pub async fn run(args: PlanArgs, session: &Session) -> Result<Exit, CliError> {
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
