//! `rtsctl teardown`.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use rts_controller_api::client::Controller;
use rts_controller_api::objects::System;

use super::apply::list_unfinished;
use super::{ask, can_ask, duration, or_interrupted};
use crate::error::CliError;
use crate::exit::Exit;
use crate::follow::Follower;
use crate::local::plural;
use crate::session::Session;
use crate::show::progress::Progress;

/// Take a system down, and wait until everything has really stopped
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Name of the system
    name: String,
    /// Do not ask
    #[arg(short, long)]
    yes: bool,
    /// How long to wait; the controller goes on after that
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = duration)]
    timeout: Duration,
}

/// Asks, deletes, and follows until the system is gone.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let controller = session.connect().await?;
    let name = &args.name;
    let system = controller.system(name).await;
    let system = system.map_err(CliError::request(format!("find system/{name}")))?;
    let components = plural("component", system.spec.components.len());
    if !args.yes {
        confirm(name, &components)?;
    }
    let start = Instant::now();
    let deleted = controller.delete(name).await;
    let deleted = deleted.map_err(CliError::request(format!("take down system/{name}")))?;
    let wait = wait(deleted, start + args.timeout, &controller, session);
    match or_interrupted(wait, session).await? {
        None => {
            let seconds = start.elapsed().as_secs_f64();
            let text = format!("system/{name} is gone: {components} stopped ({seconds:.2} s)");
            session.out.result(&text)?;
            Ok(Exit::Ok)
        }
        Some(system) => {
            list_unfinished(&system, session);
            Err(CliError::Deadline {
                system: name.clone(),
                goal: "gone",
                seconds: args.timeout.as_secs_f64(),
            })
        }
    }
}

fn confirm(name: &str, components: &str) -> Result<(), CliError> {
    if !can_ask() {
        return Err(CliError::usage_help(
            format!("system/{name} would be taken down with its {components}"),
            "say --yes where nobody can be asked",
        ));
    }
    if ask(&format!("Take down system/{name} with its {components}?")) {
        Ok(())
    } else {
        Err(CliError::usage("nothing was taken down"))
    }
}

/// `None` once it is gone; its last state when time is up before.
async fn wait(
    from: System,
    deadline: Instant,
    controller: &Controller,
    session: &Session,
) -> Result<Option<System>, CliError> {
    let name = from.metadata.name.clone();
    let mut progress = Progress::start(session.out, &format!("system/{name}: taking down"));
    let mut follower = Follower::new(controller, &from).await;
    let mut last = from;
    let end = follower.until(deadline, |state| match state {
        None => ControlFlow::Break(()),
        Some(system) => {
            progress.system(&system);
            last = system;
            ControlFlow::Continue(())
        }
    });
    let end = end.await;
    let end = end.map_err(CliError::request(format!("follow system/{name}")))?;
    Ok(if end.is_some() { None } else { Some(last) })
}
