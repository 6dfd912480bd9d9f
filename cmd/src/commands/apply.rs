//! `rtsctl apply`.

mod partly;

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use rts_controller_api::ClientError;
use rts_controller_api::client::Controller;
use rts_controller_api::objects::{Phase, System, Waiting};
use rts_controller_api::requests::ApplyResult;

pub use self::partly::list_unfinished;
use self::partly::{list_waiting, partly};
use super::{duration, goes_on, or_interrupted};
use crate::error::CliError;
use crate::exit::Exit;
use crate::follow::{Follower, Verdict, judge};
use crate::input::{Input, InputArgs};
use crate::local::plural;
use crate::session::Session;
use crate::show::plan::{self, PlanFormat};
use crate::show::progress::{self, Progress};

/// How long a controller that was there may be silent.
const SILENCE: Duration = Duration::from_secs(5);
/// Time between two tries.
const PAUSE: Duration = Duration::from_millis(200);
/// How long a system may be unwell without anybody saying why.
const UNCLEAR: Duration = Duration::from_secs(3);

/// Make a system run as its profile says, and wait until it does
///
/// Starts the local controller and agent when no controller is named and none runs.
#[derive(Debug, clap::Args)]
#[command(
    override_usage = "rtsctl apply [OPTIONS] FILE [-f OVERLAY]...\n       rtsctl apply [OPTIONS] -f FILE [-f OVERLAY]..."
)]
pub struct Args {
    /// The system.
    #[command(flatten)]
    input: InputArgs,
    /// How long to wait; the controller goes on after that
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = duration)]
    timeout: Duration,
    /// Refuse (exit 9) if a process would restart or a component be made again
    #[arg(long)]
    no_restart: bool,
    /// Only print the plan; starts nothing
    #[arg(long)]
    dry_run: bool,
}

/// Applies and follows until everything runs.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let input = args.input.load(&session.out)?;
    if args.dry_run {
        return dry_run(&input, session).await;
    }
    let controller = session.connect_or_start().await?;
    let name = &input.request.spec.name;
    let start = Instant::now();
    restarts(&input, args.no_restart, &controller, session).await?;
    let result = put(&input, &controller).await?;
    if !result.changed && result.plan.is_empty() && is_settled(&result.system) {
        session.out.result("no changes")?;
        return Ok(Exit::Ok);
    }
    for note in &result.system.status.notes {
        session.out.say(&format!("note: {note}"));
    }
    let wait = wait(result.system, start + args.timeout, &controller, session);
    let (system, verdict) = or_interrupted(wait, session, &goes_on(name)).await?;
    match verdict {
        Verdict::Converged(waiting) => converged(&system, &waiting, start.elapsed(), session),
        Verdict::Partly(waiting) => {
            list_waiting(&waiting, session);
            Err(partly(&system, &waiting))
        }
        Verdict::Unclear | Verdict::Going => {
            list_unfinished(&system, session);
            Err(CliError::Deadline {
                system: name.clone(),
                goal: "converged",
                seconds: args.timeout.as_secs_f64(),
            })
        }
    }
}

async fn dry_run(input: &Input, session: &Session) -> Result<Exit, CliError> {
    let controller = session.connect().await?;
    let name = &input.request.spec.name;
    let result = controller.plan(&input.request).await;
    let result = result.map_err(input.failed(format!("plan system/{name}")))?;
    plan::print(&result, PlanFormat::Text, &session.out)?;
    session.out.say("dry run: nothing was changed");
    Ok(Exit::Ok)
}

/// Says what will restart before it does, or refuses.
async fn restarts(
    input: &Input,
    forbidden: bool,
    controller: &Controller,
    session: &Session,
) -> Result<(), CliError> {
    let spec = &input.request.spec;
    let result = controller.plan(&input.request).await;
    let result = result.map_err(input.failed(format!("apply system/{}", spec.name)))?;
    let restarts = plan::restarts(&result.plan, spec);
    for line in &restarts {
        session.out.say(line);
    }
    if forbidden && !restarts.is_empty() {
        let count = restarts.len();
        return Err(CliError::WouldRestart {
            system: spec.name.clone(),
            restarts: format!("{count} process{}", if count == 1 { "" } else { "es" }),
        });
    }
    Ok(())
}

/// Sends the system. It may be sent again, so a controller that dies meanwhile is given time to come back.
async fn put(input: &Input, controller: &Controller) -> Result<ApplyResult, CliError> {
    let what = format!("apply system/{}", input.request.spec.name);
    let end = Instant::now() + SILENCE;
    loop {
        match controller.apply(&input.request).await {
            Err(ClientError::Unreachable { .. }) if Instant::now() < end => {
                tokio::time::sleep(PAUSE).await;
            }
            result => return result.map_err(input.failed(what)),
        }
    }
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
    let mut follower = Follower::new(controller, &from);
    let mut last = from;
    let mut unclear = None;
    let end = follower.until(deadline, |state| match state {
        None => ControlFlow::Break(None),
        Some(system) => {
            progress.system(&system);
            let verdict = judge(&system, generation);
            last = system;
            if verdict != Verdict::Unclear {
                unclear = None;
            }
            match verdict {
                Verdict::Going => ControlFlow::Continue(()),
                Verdict::Unclear => {
                    let since: Instant = *unclear.get_or_insert_with(Instant::now);
                    if since.elapsed() < UNCLEAR {
                        return ControlFlow::Continue(());
                    }
                    ControlFlow::Break(Some(Verdict::Partly(Vec::new())))
                }
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
    for text in progress::grouped(waiting, |_| String::new()) {
        session.out.warn(&format!("does not run: {text}"));
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
