//! The checks one after the other: what a check needs and is not there, it is not made without.

use std::time::Instant;

use super::check::Check;
use super::context::Context;
use super::evidence::{self, Evidence};
use super::failure::Verdict;
use super::report::Report;
use super::{again, apply, clean, export, heal, samples, steady, teardown};
use crate::local::plural;

/// All checks but the last. What shows why one failed is kept before everything is taken down.
pub async fn run(context: &mut Context<'_>, report: &mut Report, faults: bool) {
    announce(context);
    let up = made(Check::Start, context, report, start).await;
    let applied = up && made(Check::Apply, context, report, apply::check).await;
    let flows = applied && made(Check::Samples, context, report, samples::check).await;
    if applied {
        made(Check::Again, context, report, again::check).await;
        made(Check::Export, context, report, export::check).await;
    }
    let steady = flows && made(Check::Steady, context, report, steady::check).await;
    let skipped = match faults {
        false => Some("no faults are wanted".to_owned()),
        true if steady => heal::impossible(context),
        true => None,
    };
    match skipped {
        Some(reason) => report.skip(Check::Heal, &reason),
        None if steady => {
            made(Check::Heal, context, report, heal::check).await;
        }
        None => {}
    }
    // Of a controller that does not answer nothing more is known.
    let _ = context.look().await;
    report.stand_ins.0 = context.settled.stand_ins();
    if report.failed() {
        report.evidence = Some(Evidence::gather(context, report).await);
    }
    if context.plan.is_some() {
        made(Check::Teardown, context, report, teardown::check).await;
    }
}

/// The last check: it takes down whatever is there.
pub fn end(context: &mut Context<'_>, report: &mut Report) {
    let begun = Instant::now();
    let verdict = clean::check(context);
    record(Check::Clean, begun, verdict, context, report);
    for check in Check::ALL {
        if check != Check::Total && !report.has(check) {
            report.skip(check, "it needs what failed");
        }
    }
    report.total(evidence::critical_path(context));
    let home = context.stack.home().path();
    if home.exists() {
        let home = home.display();
        let text =
            format!("rtsctl: {home} is left: `rtsctl --home {home} down --purge --yes` removes it");
        context.stack.session.out.stderr(&text);
    }
}

/// Says where everything is, for the case that this program is killed.
fn announce(context: &Context<'_>) {
    let (name, home) = (context.name(), context.stack.home().path().display());
    context.stack.session.out.say(&format!(
        "rtsctl: smoke test of system/{name} in {home}; if it is killed, `rtsctl --home {home} down --purge --yes` tidies up"
    ));
}

/// Makes a check; true when it passed.
async fn made<'a>(
    check: Check,
    context: &mut Context<'a>,
    report: &mut Report,
    work: impl AsyncFnOnce(&mut Context<'a>) -> Verdict,
) -> bool {
    let begun = Instant::now();
    let verdict = work(context).await;
    record(check, begun, verdict, context, report)
}

fn record(
    check: Check,
    begun: Instant,
    verdict: Verdict,
    context: &Context<'_>,
    report: &mut Report,
) -> bool {
    let took = begun.elapsed();
    let passed = verdict.is_ok();
    let path = || evidence::critical_path(context);
    let line = report.record(check, took, verdict, path);
    context.stack.session.out.say(&format!("rtsctl: {line}"));
    passed
}

/// The stack comes up.
async fn start(context: &mut Context<'_>) -> Verdict {
    context.stack.start().await?;
    context.connect().await?;
    let nodes = context.stack.nodes.iter();
    let names: Vec<_> = nodes.map(|node| node.name.as_str()).collect();
    let agents = plural("agent", names.len());
    Ok(format!("controller and {agents} ({})", names.join(", ")))
}
