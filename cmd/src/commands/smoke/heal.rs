//! A manager that is killed comes back, with all that was in it; nothing else is touched.

use std::collections::BTreeSet;
use std::time::Duration;

use rts_controller_api::objects::Manager;
use rts_schemas::system::{ComponentSpec, OnDisconnect, RestartPolicy};
use rustix::process::Signal;

use super::context::{Context, PAUSE};
use super::failure::{Failure, Verdict};
use super::samples::{Flow, flows};
use super::snapshot::Snapshot;
use crate::commands::apply::is_settled;
use crate::local::plural;
use crate::local::strays::{self, Program};

/// Longest wait for the end of what was killed.
const KILLED: Duration = Duration::from_secs(5);

/// Why there is nothing to kill; none when there is.
pub fn impossible(context: &Context<'_>) -> Option<String> {
    let none = victim(context).is_none();
    none.then(|| "no manager is to be started again when it dies (rtsctl.restart)".to_owned())
}

/// Kills one, and waits until all is as it was.
pub async fn check(context: &mut Context<'_>) -> Verdict {
    context.look().await?;
    context.family.look();
    let before = context.last.clone();
    let Some(manager) = victim(context).cloned() else {
        return Err(Failure::new("no manager runs any more"));
    };
    let name = manager.metadata.name.clone();
    kill(context, &manager)?;
    let lost: BTreeSet<String> = manager.status.components.iter().cloned().collect();
    loop {
        let system = context.system().await?;
        let late = context.late();
        let now = context.look().await?.clone();
        untouched(context, &before, &now, &lost)?;
        let missing = missing(&before, &now, &lost);
        if missing.is_empty() && is_settled(&system) {
            break;
        }
        if late {
            let what = match missing.is_empty() {
                true => format!("system/{} has not settled", context.name()),
                false => format!("not Active again in time: {}", missing.join(", ")),
            };
            let failure = Failure::late(format!("manager {name} was killed: {what}"));
            let waiting = &system.status.waiting_on;
            return Err(failure.of(missing).waiting(waiting, context.spec()));
        }
        tokio::time::sleep(PAUSE).await;
    }
    flows(context, Flow::default()).await?;
    untouched(context, &before, &context.last, &lost)?;
    let others = before.components.len() - lost.len().min(before.components.len());
    let again = plural("component", lost.len());
    Ok(format!(
        "manager {name} was killed: {again} came back, {others} untouched"
    ))
}

/// The first manager by name whose components are all to be started again.
fn victim<'c>(context: &'c Context<'_>) -> Option<&'c Manager> {
    let returns = |name: &String| {
        let mut components = context.spec().components.iter();
        let spec = components.find(|c| c.instance == *name);
        spec.is_some_and(|c| c.policy.restart != RestartPolicy::Never)
    };
    let mut managers: Vec<&Manager> = context.last.managers.iter().collect();
    managers.sort_by_key(|m| (&m.metadata.name, &m.status.node));
    let mut managers = managers.into_iter();
    managers.find(|m| !m.status.components.is_empty() && m.status.components.iter().all(returns))
}

/// SIGKILL, for a process of this stack only.
fn kill(context: &Context<'_>, manager: &Manager) -> Result<(), Failure> {
    let (name, pid) = (&manager.metadata.name, manager.status.pid);
    let own = strays::find(context.stack.home(), Program::Manager);
    let mut own = own.into_iter();
    let process = own.find(|stray| u32::try_from(stray.process.pid()) == Ok(pid));
    let Some(stray) = process else {
        return Err(Failure::new(format!(
            "manager {name} does not run as pid {pid}"
        )));
    };
    stray.process.signal(Signal::KILL);
    if !stray.process.ended(KILLED) {
        return Err(Failure::new(format!(
            "manager {name} (pid {pid}) outlives SIGKILL"
        )));
    }
    Ok(())
}

/// Components that were lost and are not back.
fn missing(before: &Snapshot, now: &Snapshot, lost: &BTreeSet<String>) -> Vec<String> {
    let back = |name: &str| {
        let (then, now) = (before.component(name), now.component(name));
        let Some((then, now)) = then.zip(now) else {
            return false;
        };
        let is = (&now.status.state, &now.status.incarnation);
        is.0 == &then.status.state && is.1 != &then.status.incarnation
    };
    lost.iter().filter(|name| !back(name)).cloned().collect()
}

/// Fails when a component of another manager was made again.
fn untouched(
    context: &Context<'_>,
    before: &Snapshot,
    now: &Snapshot,
    lost: &BTreeSet<String>,
) -> Result<(), Failure> {
    let stops = |c: &&ComponentSpec| c.policy.on_disconnect == OnDisconnect::Stop;
    let stopping = context.spec().components.iter().filter(stops);
    let stopping: BTreeSet<&str> = stopping.map(|c| c.instance.as_str()).collect();
    let again = now.made_again(before);
    let again = again.filter(|name| !lost.contains(*name) && !stopping.contains(name));
    let again: Vec<String> = again.map(str::to_owned).collect();
    if again.is_empty() {
        return Ok(());
    }
    let names = again.join(", ");
    let message = format!("made again though another manager was killed: {names}");
    Err(Failure::new(message).of(again))
}
