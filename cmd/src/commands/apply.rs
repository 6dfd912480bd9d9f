//! `rtsctl apply`.

mod partly;
mod send;
mod wait;

use std::time::{Duration, Instant};

use futures_util::future::join;
use rts_controller_api::client::Controller;
use rts_controller_api::objects::{Phase, System, Waiting};
use rts_controller_api::requests::{ApplyResult, PlanResult};
use rts_plan::plan::Plan;

use self::partly::list_waiting;
pub use self::partly::{list_unfinished, partly};
pub use self::send::put;
pub use self::wait::wait;
use super::plan::{ExpectArgs, show};
use super::{duration, goes_on, or_interrupted};
use crate::error::CliError;
use crate::exit::Exit;
use crate::follow::{Verdict, judge};
use crate::input::{Input, InputArgs, Source};
use crate::local::plural;
use crate::local::relays::{self, because, despite_loss};
use crate::session::Session;
use crate::show::plan::{self, PlanFormat};
use crate::show::{progress, timings};
use crate::timings::Laps;

/// Make a system run as its profile says, and wait until it does
///
/// Starts the local controller and agent when no controller is named and none runs. FILE may be a plan that `rtsctl plan
/// --out` saved: then just that is done, or nothing if something has changed since (exit 7).
#[derive(Debug, clap::Args)]
#[command(
    override_usage = "rtsctl apply [OPTIONS] FILE [-f OVERLAY]...\n       rtsctl apply [OPTIONS] -f FILE [-f OVERLAY]..."
)]
pub struct Args {
    /// The system, or a plan that `plan --out` saved.
    #[command(flatten)]
    input: InputArgs,
    /// How long to wait; the controller goes on after that
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = duration)]
    timeout: Duration,
    /// What must be true.
    #[command(flatten)]
    expect: ExpectArgs,
    /// Show where the time went: what was waited for, in rtsctl, the controller and the agents
    #[arg(long, conflicts_with = "dry_run")]
    timings: bool,
    /// Only print what `rtsctl plan` prints; starts nothing
    #[arg(long)]
    dry_run: bool,
    /// How to print the plan [default: text]
    #[arg(short, long, value_name = "FORMAT", requires = "dry_run")]
    output: Option<PlanFormat>,
    /// List the steps of the plan however many they are (50 or fewer always are)
    #[arg(long, requires = "dry_run")]
    steps: bool,
}

/// Applies and follows until everything runs.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let mut laps = Laps::default();
    let timings = args.timings;
    let outcome = apply(args, session, &mut laps).await;
    match timings {
        true => laps.told(outcome, session).await,
        false => outcome,
    }
}

async fn apply(args: Args, session: &Session, laps: &mut Laps) -> Result<Exit, CliError> {
    let (input, saved) = match read(&args, session).await? {
        Source::System(input) => (*input, None),
        Source::Saved(saved) => (Input::saved(&saved), Some(saved)),
    };
    laps.lap("read files");
    if args.dry_run {
        return dry_run(&input, &args, session).await;
    }
    let controller = match &saved {
        // What was planned with a controller is of no use to a new one.
        Some(_) => session.connect().await?,
        None => session.connect_or_start().await?,
    };
    laps.lap("connect");
    let start = Instant::now();
    let deadline = start + args.timeout;
    let plan = match saved {
        Some(saved) => Some(saved.result()),
        None if args.expect.is_any() => Some(planned(&input, &controller, deadline).await?),
        // The answer to the apply tells it.
        None => None,
    };
    if let Some(plan) = &plan {
        laps.lap(timings::PLAN);
        expected(&args.expect, &input, plan, session)?;
    }
    let input = args.expect.added(input);
    let result = put(&input, &controller, deadline).await?;
    accepted(
        &input,
        plan.as_ref().map_or(&result.plan, |plan| &plan.plan),
        session,
    );
    laps.lap(timings::APPLY);
    let outcome = follow(result, start, args.timeout, &controller, session).await;
    laps.lap(timings::FOLLOW);
    outcome
}

/// Reads the files. Meanwhile the local controller is asked whether it is there, which takes as long.
async fn read(args: &Args, session: &Session) -> Result<Source, CliError> {
    if args.dry_run {
        return args.input.load_any(&session.out);
    }
    let (input, out) = (args.input.clone(), session.out);
    let read = tokio::task::spawn_blocking(move || input.load_any(&out));
    match join(read, session.ask_ahead()).await.0 {
        Ok(read) => read,
        Err(failed) => std::panic::resume_unwind(failed.into_panic()),
    }
}

/// Checks a plan; one that is refused is shown.
fn expected(
    expect: &ExpectArgs,
    input: &Input,
    plan: &PlanResult,
    session: &Session,
) -> Result<(), CliError> {
    let checked = expect.check(input, plan);
    if let Err(CliError::WouldRestart { .. }) = checked {
        plan::tell_refused(&plan.plan, &input.request.spec, &session.out);
    }
    checked
}

/// Says what it means that the controller does what was planned.
fn accepted(input: &Input, plan: &Plan, session: &Session) {
    let request = &input.request;
    plan::tell(plan, &request.spec, &session.out);
    if !request.targets.is_empty() {
        let targets = request.targets.join(", ");
        let text = format!("note: only {targets} was applied; the rest stays as it is stored");
        session.out.say(&text);
    }
}

/// Waits until what was applied runs.
async fn follow(
    result: ApplyResult,
    start: Instant,
    timeout: Duration,
    controller: &Controller,
    session: &Session,
) -> Result<Exit, CliError> {
    let unchanged = !result.changed && result.plan.is_empty();
    if unchanged && is_settled(&result.system) {
        return no_changes(session);
    }
    for note in &result.system.status.notes {
        session.out.say(&format!("note: {note}"));
    }
    let name = result.system.metadata.name.clone();
    // It was carried out while it was being stored: then the answer shows the end, and no later state will come.
    let generation = result.system.metadata.generation;
    if let (true, Verdict::Converged(waiting)) = (result.changed, judge(&result.system, generation))
    {
        return converged(&result.system, &waiting, start.elapsed(), session);
    }
    let goes_on = goes_on(&name, &result.system.status.nodes);
    let wait = wait(
        result.system,
        start + timeout,
        controller,
        session.out,
        |_| (),
    );
    let (system, verdict) = or_interrupted(wait, session, &goes_on).await?;
    match verdict {
        // What was stored a moment ago was only not looked at yet.
        Verdict::Converged(waiting) if unchanged && waiting.is_empty() => no_changes(session),
        Verdict::Converged(waiting) => converged(&system, &waiting, start.elapsed(), session),
        Verdict::Partly(waiting) => {
            list_waiting(&waiting, session);
            Err(partly(&system, &waiting))
        }
        Verdict::Unclear | Verdict::Going => {
            list_unfinished(&system, session);
            if let Some(away) = relays::away(&system.status.nodes) {
                return Err(away.into());
            }
            Err(CliError::Deadline {
                system: name,
                goal: "converged",
                seconds: timeout.as_secs_f64(),
                nodes: system.status.nodes.into(),
            })
        }
    }
}

fn no_changes(session: &Session) -> Result<Exit, CliError> {
    session.out.result("no changes")?;
    Ok(Exit::Ok)
}

async fn dry_run(input: &Input, args: &Args, session: &Session) -> Result<Exit, CliError> {
    let controller = session.connect().await?;
    let format = args.output.unwrap_or(PlanFormat::Text);
    let result = show(input, format, args.steps, &controller, session).await?;
    args.expect.check(input, &result)?;
    session.out.say("dry run: nothing was changed");
    Ok(Exit::Ok)
}

/// What would be done now, whatever is expected.
async fn planned(
    input: &Input,
    controller: &Controller,
    deadline: Instant,
) -> Result<PlanResult, CliError> {
    let what = format!("apply system/{}", input.request.spec.name);
    let planned = input.planned();
    let result = despite_loss(deadline, || controller.plan(&planned)).await;
    result.map_err(because(input.failed(what)))
}

/// Nothing is left to do for what was applied last.
pub fn is_settled(system: &System) -> bool {
    let status = &system.status;
    status.phase == Phase::Converged && status.observed_generation >= system.metadata.generation
}

fn converged(
    system: &System,
    waiting: &[Waiting],
    took: Duration,
    session: &Session,
) -> Result<Exit, CliError> {
    for text in progress::grouped(waiting, |_| String::new()) {
        session.out.warn(&format!("does not run: {text}"));
    }
    let connectors = plural("connector", system.spec.connectors.len());
    let status = &system.status;
    let stand_ins = match status.stand_ins {
        0 => String::new(),
        some => format!("; {some} of {} are stand-ins", status.components),
    };
    session.out.result(&format!(
        "system/{} converged: {} active, {connectors} connected ({:.2} s){stand_ins}",
        system.metadata.name,
        plural("component", status.active as usize),
        took.as_secs_f64()
    ))?;
    Ok(Exit::Ok)
}
