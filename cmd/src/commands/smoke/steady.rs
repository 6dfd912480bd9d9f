//! For some time nothing dies, and nothing leaves its state.

use super::context::{Context, PAUSE};
use super::failure::{Failure, Verdict};
use super::snapshot::Snapshot;

/// Looks on until everything has run for the time that is wanted.
pub async fn check(context: &mut Context<'_>) -> Verdict {
    let settled = context.settled.clone();
    loop {
        let (ran, late) = (context.settled_at.elapsed(), context.late());
        let now = context.look().await?;
        let changed = changed(&settled, now);
        if !changed.is_empty() {
            let names = changed.join(", ");
            let message = format!("did not stay Active: {names}");
            let waiting = context.system().await?.status.waiting_on;
            let failure = Failure::new(message).of(changed);
            return Err(failure.waiting(&waiting, context.spec()));
        }
        if ran >= context.steady {
            let seconds = context.steady.as_secs_f64();
            return Ok(format!("nothing died for {seconds} s"));
        }
        if late {
            return Err(Failure::late("there is no time left to look on"));
        }
        tokio::time::sleep(PAUSE).await;
    }
}

/// Components that are not in the state, or not the incarnation, that they were.
fn changed(then: &Snapshot, now: &Snapshot) -> Vec<String> {
    let same = |name: &str| {
        let both = then.component(name).zip(now.component(name));
        both.is_some_and(|(then, now)| {
            let (then, now) = (&then.status, &now.status);
            (&then.state, &then.incarnation) == (&now.state, &now.incarnation)
        })
    };
    let names = then.components.iter().map(|c| &c.metadata.name);
    names.filter(|name| !same(name)).cloned().collect()
}
