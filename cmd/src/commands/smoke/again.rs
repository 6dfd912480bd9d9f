//! A second apply changes nothing.

use super::context::Context;
use super::failure::{Failure, Verdict};
use crate::commands::apply::put;
use crate::show::plan::{View, text};

/// Applies again, and looks whether anything was made again.
pub async fn check(context: &mut Context<'_>) -> Verdict {
    let controller = context.controller()?;
    let result = put(context.input, &controller, context.deadline).await?;
    if result.changed || !result.plan.is_empty() {
        let mut failure = Failure::new("the second apply makes changes");
        let plan = text(&result.plan, View::Lines, false);
        failure.details.extend(plan.lines().map(str::to_owned));
        return Err(failure);
    }
    undisturbed(context).await?;
    Ok("no changes".to_owned())
}

/// Fails when a component is another incarnation than it was when all was up.
async fn undisturbed(context: &mut Context<'_>) -> Result<(), Failure> {
    let settled = context.settled.clone();
    let now = context.look().await?;
    let again: Vec<String> = now.made_again(&settled).map(str::to_owned).collect();
    if again.is_empty() {
        return Ok(());
    }
    let names = again.join(", ");
    Err(Failure::new(format!("made again though nothing asked for it: {names}")).of(again))
}
