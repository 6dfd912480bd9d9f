//! Waiting until what was applied runs.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use rts_controller_api::client::Controller;
use rts_controller_api::objects::System;

use crate::error::CliError;
use crate::follow::{Follower, Verdict, judge};
use crate::local::relays::{self, Patience};
use crate::output::Output;
use crate::show::progress::Progress;

/// How long a system may be unwell without anybody saying why.
const UNCLEAR: Duration = Duration::from_secs(3);

/// Follows from the state that the apply answered with. That one is from before the plan was carried out: only later
/// ones are judged, and shown to `seen`. Gives the last state; its verdict is `Going` when time is up.
pub async fn wait(
    from: System,
    deadline: Instant,
    controller: &Controller,
    out: Output,
    mut seen: impl FnMut(&System),
) -> Result<(System, Verdict), CliError> {
    let name = from.metadata.name.clone();
    let generation = from.metadata.generation;
    let mut progress = Progress::start(out, &format!("system/{name}: applying"));
    let mut follower = Follower::new(controller, &from);
    let mut last = from;
    let mut unclear = None;
    let mut patience = Patience::default();
    let end = follower.until(deadline, |state| match state {
        None => ControlFlow::Break(Err(CliError::Gone {
            system: name.clone(),
        })),
        Some(system) => {
            progress.system(&system);
            seen(&system);
            let verdict = judge(&system, generation);
            last = system;
            let nodes = &last.status.nodes;
            // A node on which only what is optional lies ends nothing.
            if let Some(away) = relays::given_up(&relays::needed(nodes, &last.status.waiting_on)) {
                return ControlFlow::Break(Err(away.into()));
            }
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
                    ControlFlow::Break(Ok(Verdict::Partly(Vec::new())))
                }
                // A session that was lost is made anew, and then it goes on.
                Verdict::Partly(waiting) if patience.allows(nodes, &waiting) => {
                    ControlFlow::Continue(())
                }
                verdict => ControlFlow::Break(Ok(verdict)),
            }
        }
    });
    let end = end.await;
    match end.map_err(CliError::request(format!("follow system/{name}")))? {
        Some(verdict) => Ok((last, verdict?)),
        None => Ok((last, Verdict::Going)),
    }
}
