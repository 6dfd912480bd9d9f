//! The system goes, with all its managers.

use std::time::{Duration, Instant};

use super::context::Context;
use super::failure::{Failure, Verdict};
use crate::commands::teardown::wait;
use crate::error::CliError;
use crate::local::plural;
use crate::local::strays::{self, Program};

/// How long it may take at least, however little time is left.
const LEAST: Duration = Duration::from_secs(30);

/// Takes it down, and looks for managers that live on.
pub async fn check(context: &mut Context<'_>) -> Verdict {
    context.family.look();
    let controller = context.controller()?;
    let name = context.name();
    let deleted = controller.delete(name).await;
    let deleted = deleted.map_err(CliError::request(format!("take down system/{name}")))?;
    let deadline = context.deadline.max(Instant::now() + LEAST);
    let left = wait(deleted, deadline, &controller, &context.stack.session).await?;
    if let Some(system) = left {
        let failure = Failure::late(format!("system/{name} is not gone in time"));
        return Err(failure.waiting(&system.status.waiting_on, context.spec()));
    }
    let managers = strays::find(context.stack.home(), Program::Manager);
    if managers.is_empty() {
        let components = plural("component", context.spec().components.len());
        return Ok(format!("{components} stopped"));
    }
    let names: Vec<_> = managers.into_iter().map(|stray| stray.name).collect();
    let names = names.join(", ");
    Err(Failure::new(format!("managers live on: {names}")))
}
