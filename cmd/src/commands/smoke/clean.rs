//! Nothing is left of the stack.

use rts_host::cgroup::{Cgroups, Choice};

use super::context::Context;
use super::failure::{Failure, Verdict};
use crate::error::CliError;
use crate::local::lock::HomeLock;
use crate::local::{down, remove};

/// Stops the stack, removes its folder, and looks for what is left. What is left of processes is killed.
pub fn check(context: &Context<'_>) -> Verdict {
    let left = end(context)?;
    let message = match left.as_slice() {
        [] => return Ok("no process, socket, file or shared memory is left".to_owned()),
        [one] => format!("left behind: {one}"),
        [first, more @ ..] => format!("left behind: {first}, and {} more", more.len()),
    };
    let mut failure = Failure::new(message);
    failure.details = left;
    Err(failure)
}

fn end(context: &Context<'_>) -> Result<Vec<String>, CliError> {
    let home = context.stack.home();
    let lock = HomeLock::take_existing(home)?;
    let stopped = down::stop(home)?;
    let mut left = stopped.killed;
    let clean = stopped.left.is_empty();
    left.extend(stopped.left);
    left.extend(context.family.end());
    let groups = Cgroups::of(home.path(), Choice::Auto).folders();
    left.extend(
        groups
            .iter()
            .map(|group| format!("control group {}", group.display())),
    );
    let shared = context.family.shared();
    left.extend(shared.iter().map(|name| format!("shared memory {name}")));
    if clean {
        let alone = remove::remove(home, true)?;
        left.extend(alone.iter().map(|file| format!("file {}", file.display())));
    }
    drop(lock);
    Ok(left)
}
