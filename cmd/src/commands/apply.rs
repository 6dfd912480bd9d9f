//! `rtsctl apply`.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use rts_controller_api::client::Controller;
use rts_controller_api::objects::{Phase, System, Waiting};
use rts_controller_api::requests::ApplyRequest;

use super::{duration, or_interrupted};
use crate::error::CliError;
use crate::exit::Exit;
use crate::follow::{Follower, Verdict, judge};
use crate::input::InputArgs;
use crate::local::plural;
use crate::session::Session;
use crate::show::plan::{self, PlanFormat};
use crate::show::progress::Progress;

/// Make a system run as its profile says, and wait until it does
///
/// Starts the local controller and agent when no controller is named and none runs.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The system.
    #[command(flatten)]
    input: InputArgs,
    /// How long to wait; the controller goes on after that
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = duration)]
    timeout: Duration,
    /// Only print the plan
    #[arg(long)]
    dry_run: bool,
}

/// Applies and follows until everything runs.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let request = args.input.load(&session.out)?;
    let controller = session.connect_or_start().await?;
    if args.dry_run {
        return dry_run(&request, &controller, session).await;
    }
    let name = &request.spec.name;
    let start = Instant::now();
    let result = controller.apply(&request).await;
    let result = result.map_err(CliError::request(format!("apply system/{name}")))?;
    if !result.changed && result.plan.is_empty() && is_settled(&result.system) {
        session.out.result("no changes")?;
        return Ok(Exit::Ok);
    }
    for note in &result.system.status.notes {
        session.out.say(&format!("note: {note}"));
    }
    let wait = wait(result.system, start + args.timeout, &controller, session);
    let (system, verdict) = or_interrupted(wait, session).await?;
    match verdict {
        Verdict::Converged(waiting) => converged(&system, &waiting, start.elapsed(), session),
        Verdict::Partly(waiting) => {
            list_waiting(&waiting, session);
            Err(CliError::Partly {
                system: name.clone(),
                summary: active(&system),
            })
        }
        Verdict::Going => {
            list_unfinished(&system, session);
            Err(CliError::Deadline {
                system: name.clone(),
                goal: "converged",
                seconds: args.timeout.as_secs_f64(),
            })
        }
    }
}

async fn dry_run(
    request: &ApplyRequest,
    controller: &Controller,
    session: &Session,
) -> Result<Exit, CliError> {
    let name = &request.spec.name;
    let result = controller.plan(request).await;
    let result = result.map_err(CliError::request(format!("plan system/{name}")))?;
    plan::print(&result, PlanFormat::Text, &session.out)?;
    session.out.say("dry run: nothing was changed");
    Ok(Exit::Ok)
}

fn is_settled(system: &System) -> bool {
    let status = &system.status;
    status.phase == Phase::Converged && status.observed_generation >= system.metadata.generation
}

/// Follows from the state that the apply answered with. That one is from before the plan was carried out: only later
/// ones are judged. Gives the last state; its verdict is `Going` when time is up.
async fn wait(
    from: System,
    deadline: Instant,
    controller: &Controller,
    session: &Session,
) -> Result<(System, Verdict), CliError> {
    let name = from.metadata.name.clone();
    let generation = from.metadata.generation;
    let mut progress = Progress::start(session.out, &format!("system/{name}: applying"));
    let mut follower = Follower::new(controller, &from).await;
    let mut last = from;
    let end = follower.until(deadline, |state| match state {
        None => ControlFlow::Break(None),
        Some(system) => {
            progress.system(&system);
            let verdict = judge(&system, generation);
            last = system;
            match verdict {
                Verdict::Going => ControlFlow::Continue(()),
                verdict => ControlFlow::Break(Some(verdict)),
            }
        }
    });
    let end = end.await;
    match end.map_err(CliError::request(format!("follow system/{name}")))? {
        Some(Some(verdict)) => Ok((last, verdict)),
        Some(None) => Err(CliError::Gone { system: name }),
        None => Ok((last, Verdict::Going)),
    }
}

fn converged(
    system: &System,
    waiting: &[Waiting],
    took: Duration,
    session: &Session,
) -> Result<Exit, CliError> {
    for waits in waiting {
        let text = format!("{} does not run: {}", waits.target, waits.reason);
        session.out.warn(&text);
    }
    let connectors = plural("connector", system.spec.connectors.len());
    session.out.result(&format!(
        "system/{} converged: {} active, {connectors} connected ({:.2} s)",
        system.metadata.name,
        plural("component", system.status.active as usize),
        took.as_secs_f64()
    ))?;
    Ok(Exit::Ok)
}

fn active(system: &System) -> String {
    let status = &system.status;
    format!(
        "{} of {} components active",
        status.active, status.components
    )
}

/// What a system is busy with, and what does not go on.
pub fn list_unfinished(system: &System, session: &Session) {
    for step in &system.status.progress.running {
        let text = format!("{step} has not ended");
        session.out.fault("", &text, None);
    }
    list_waiting(&system.status.waiting_on, session);
}

fn list_waiting(waiting: &[Waiting], session: &Session) {
    for waits in waiting {
        let tries = match waits.tries {
            0 => String::new(),
            1 => " (tried once)".to_owned(),
            tries => format!(" (tried {tries} times)"),
        };
        let text = format!("{}: {}{tries}", waits.target, waits.reason);
        if waits.required {
            session.out.fault("", &text, None);
        } else {
            session.out.warn(&text);
        }
    }
}
