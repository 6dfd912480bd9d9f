//! The orderly end of a process: everything in it is taken down first, within a time.

use std::time::Duration;

use futures_util::future::join_all;
use rts_agent::launch::Exit;
use tokio::time::Instant;

use super::component::Action;
use super::handle::Handle;
use super::request::act;
use super::state::{At, Parting, Run};
use crate::truth::Cause;

/// Kept for the answer; less of a short deadline.
const MARGIN: Duration = Duration::from_millis(100);
/// Time for an orderly end after SIGTERM.
const GRACE: Duration = Duration::from_secs(3);

/// How SIGTERM ends a process that does not listen to it.
const TERMINATED: Exit = Exit::Signal(15);

/// Deletes all components at once. Those that hang are left behind at the deadline.
pub(super) async fn shutdown(handle: &Handle, deadline: Instant) {
    let number = handle.number;
    let components: Vec<At> = handle
        .with(|process| {
            process.stopping = true;
            let components = process.components.values();
            components.map(|component| component.at(number)).collect()
        })
        .unwrap_or_default();
    let left = deadline.saturating_duration_since(Instant::now());
    let deadline = Instant::now() + left.saturating_sub(MARGIN.min(left / 4));
    join_all(components.into_iter().map(async |at| {
        let deleted = act(handle, &at.instance, Action::Delete, deadline).await;
        if deleted.is_err() {
            // To its peers this is a planned end all the same.
            handle.change(|state| state.detach(&at, Parting::GoodBye, Cause::Asked));
        }
    }))
    .await;
}

/// Ends the process, after everything in it was taken down.
pub(super) fn leave(handle: &Handle) {
    leave_as(handle, Exit::Code(0));
}

fn leave_as(handle: &Handle, exit: Exit) {
    let number = handle.number;
    handle.change(|state| {
        let Some(process) = state.living(number) else {
            return;
        };
        let (folder, serves) = (process.folder.clone(), process.serves);
        if let (true, Some(folder)) = (serves, state.folders.get_mut(&folder)) {
            folder.file = None;
            folder.changed = Instant::now();
        }
        state.end(number, exit, Cause::Asked);
    });
}

/// SIGTERM. One that hangs does not see it.
pub(super) fn term(handle: &Handle) {
    let begun = handle.with(|process| process.serves);
    match (handle.now(), begun) {
        (Run::Hangs | Run::Ended(_), _) | (_, None) => {}
        (Run::Runs, Some(serves)) => {
            let manager = handle.clone();
            handle.spawn(async move {
                if serves {
                    shutdown(&manager, Instant::now() + GRACE).await;
                    return leave(&manager);
                }
                // It does not listen to signals yet.
                leave_as(&manager, TERMINATED);
            });
        }
    }
}
