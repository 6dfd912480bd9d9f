//! Every required component becomes Active, and every connector Connected.

use std::time::Instant;

use rts_controller_api::objects::{Phase, System, Waiting};

use super::context::Context;
use super::failure::{Failure, Verdict};
use crate::commands::apply::{is_settled, partly, put, wait};
use crate::error::CliError;
use crate::follow;
use crate::local::plural;

/// Plans, applies, and waits until the system runs.
pub async fn check(context: &mut Context<'_>) -> Verdict {
    let controller = context.controller()?;
    let planned = controller.plan(&context.input.planned()).await;
    let failed = context
        .input
        .failed(format!("plan system/{}", context.name()));
    context.plan = Some(planned.map_err(failed)?);
    let result = put(context.input, &controller, context.deadline).await?;
    let deadline = context.deadline;
    // What was changed may have been carried out while it was being stored.
    let told = result.changed || result.plan.is_empty();
    let (system, verdict) = if told && is_settled(&result.system) {
        (result.system, follow::Verdict::Converged(Vec::new()))
    } else {
        let out = context.stack.session.out;
        let steps = &mut context.steps;
        let seen = |system: &System| see(steps, &system.status.progress.running);
        wait(result.system, deadline, &controller, out, seen).await?
    };
    see(&mut context.steps, &[]);
    context.settled = context.look().await?.clone();
    context.settled_at = Instant::now();
    judged(context, &system, verdict)
}

fn judged(context: &Context<'_>, system: &System, verdict: follow::Verdict) -> Verdict {
    let name = context.name();
    match verdict {
        follow::Verdict::Converged(waiting) if system.status.phase == Phase::Converged => {
            let active = plural("component", system.status.active as usize);
            let connectors = plural("connector", system.spec.connectors.len());
            Ok(format!(
                "{active} Active, {connectors}{}",
                without(&waiting)
            ))
        }
        follow::Verdict::Converged(waiting) => {
            let active = plural("component", system.status.active as usize);
            Ok(format!("{active} Active{}", without(&waiting)))
        }
        follow::Verdict::Partly(waiting) => {
            let required = waiting.iter().filter(|w| w.required);
            let message = match partly(system, &waiting) {
                CliError::Partly {
                    summary,
                    target: Some(target),
                    ..
                } if !summary.contains(&target) => format!("{summary}, but not {target}"),
                CliError::Partly { summary, .. } => summary,
                other => other.line(),
            };
            Err(Failure::new(message).waiting(required, context.spec()))
        }
        follow::Verdict::Going | follow::Verdict::Unclear => {
            let status = &system.status;
            let mut failure = Failure::late(format!(
                "system/{name} is not converged in time: {} of {} components active",
                status.active, status.components
            ));
            let running = status.progress.running.iter();
            let running = running.map(|step| format!("{step} has not ended"));
            failure.details.extend(running);
            let failure = failure.waiting(&status.waiting_on, context.spec());
            let idle = context.last.components.iter();
            let idle = idle.filter(|c| c.spec.required && c.status.state != "Active");
            Err(failure.of(idle.map(|c| c.metadata.name.clone())))
        }
    }
}

/// `, but not component/Camera0` for what is not required and does not run.
fn without(waiting: &[Waiting]) -> String {
    match waiting {
        [] => String::new(),
        some => {
            let targets: Vec<_> = some.iter().map(|w| w.target.as_str()).collect();
            format!(", but not {}", targets.join(", "))
        }
    }
}

/// Notes which steps run now.
fn see(steps: &mut Vec<(String, Instant, Option<Instant>)>, running: &[String]) {
    let now = Instant::now();
    for (step, _, until) in steps.iter_mut().filter(|step| step.2.is_none()) {
        if !running.contains(step) {
            *until = Some(now);
        }
    }
    for step in running {
        if !steps
            .iter()
            .any(|(known, _, until)| known == step && until.is_none())
        {
            steps.push((step.clone(), now, None));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_timed_from_their_first_sight_to_the_first_look_without_them() {
        let mut steps = Vec::new();
        let (a, b) = (
            "Create component/A".to_owned(),
            "Create component/B".to_owned(),
        );
        see(&mut steps, std::slice::from_ref(&a));
        see(&mut steps, &[a.clone(), b.clone()]);
        see(&mut steps, std::slice::from_ref(&b));
        assert_eq!(steps.len(), 2);
        assert!(steps[0].2.is_some_and(|until| until >= steps[0].1));
        assert!(steps[1].2.is_none());
        see(&mut steps, &[]);
        assert!(steps.iter().all(|step| step.2.is_some()));
    }
}
