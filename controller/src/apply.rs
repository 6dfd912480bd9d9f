//! What clients may change: apply a system, ask for its end. Durable before it is answered.
//!
//! A change that was begun ends even when its client goes away: what is on the disk is then in memory, too.

use std::collections::BTreeSet;
use std::future::Future;
use std::sync::Arc;

use rts_controller_api::objects::System;
use rts_controller_api::requests::{ApplyRequest, ApplyResult};
use rts_controller_api::{Problem, ProblemError};
use rts_schemas::system::SystemSpec;

use crate::admit::{self, Admitted};
use crate::core::Core;
use crate::ledger::Standing;
use crate::store::{StoreError, SystemRecord};
use crate::view::Happening;

/// What the stored system must be for a change of it to be wanted.
#[derive(Debug, Clone, Default)]
pub struct Precondition {
    /// `If-Match`: the system has one of these versions.
    pub if_match: Option<String>,
    /// `If-None-Match: *`: there is no such system.
    pub absent: bool,
}

/// Applies a system. `if_match` is the header of that name: the versions that the system must have one of.
pub async fn apply(
    core: &Arc<Core>,
    name: &str,
    request: ApplyRequest,
    if_match: Option<&str>,
) -> Result<ApplyResult, Problem> {
    let precondition = Precondition {
        if_match: if_match.map(str::to_owned),
        absent: false,
    };
    apply_if(core, name, request, precondition).await
}

/// Applies a system when the stored one is as it is expected to be.
pub async fn apply_if(
    core: &Arc<Core>,
    name: &str,
    request: ApplyRequest,
    precondition: Precondition,
) -> Result<ApplyResult, Problem> {
    let (core, name) = (Arc::clone(core), name.to_owned());
    to_its_end(async move { apply_now(&core, &name, request, &precondition, None).await }).await
}

/// Makes what was changed by hand in a system part of it, when it is still at `index`. Nothing is touched for it: not
/// the `targets` that were changed, and nothing is restarted.
pub async fn fold(
    core: &Arc<Core>,
    spec: SystemSpec,
    index: u64,
    targets: BTreeSet<String>,
) -> Result<ApplyResult, Problem> {
    let mut request = ApplyRequest::of(spec);
    request.expect.index = Some(index);
    request.expect.no_restart = true;
    let (core, any) = (Arc::clone(core), Precondition::default());
    to_its_end(async move {
        let name = request.spec.name.clone();
        apply_now(&core, &name, request, &any, Some(targets)).await
    })
    .await
}

/// Asks for a system's end.
pub async fn delete(
    core: &Arc<Core>,
    name: &str,
    if_match: Option<&str>,
) -> Result<System, Problem> {
    delete_but(core, name, if_match, Vec::new()).await
}

/// Asks for a system's end, which does not need the word of the nodes that are to be `forgotten`.
pub async fn delete_but(
    core: &Arc<Core>,
    name: &str,
    if_match: Option<&str>,
    forgotten: Vec<String>,
) -> Result<System, Problem> {
    let precondition = Precondition {
        if_match: if_match.map(str::to_owned),
        absent: false,
    };
    let (core, name) = (Arc::clone(core), name.to_owned());
    to_its_end(async move { delete_now(&core, &name, &precondition, forgotten).await }).await
}

/// Runs a change in a task of its own, so that it does not stop half-way when nobody waits for it any more.
pub async fn to_its_end<T: Send + 'static>(
    work: impl Future<Output = Result<T, Problem>> + Send + 'static,
) -> Result<T, Problem> {
    let task = tokio::spawn(work).await;
    task.unwrap_or_else(|e| {
        Err(Problem::internal(format!(
            "the request was broken off: {e}"
        )))
    })
}

async fn apply_now(
    core: &Arc<Core>,
    name: &str,
    request: ApplyRequest,
    precondition: &Precondition,
    untouched: Option<BTreeSet<String>>,
) -> Result<ApplyResult, Problem> {
    for _ in 0..admit::ATTEMPTS {
        check_version(core, name, precondition)?;
        // Agents are asked before anything is locked: one that is slow holds up nobody else.
        let mut examined = admit::examine(core, name, &request).await?;
        if let Some(targets) = &untouched {
            examined = examined.leaving(targets.clone());
        }
        let _admission = core.admission.lock().await;
        check_version(core, name, precondition)?;
        if let Some(admitted) = examined.decide(core).await? {
            return store(core, name, admitted).await;
        }
    }
    Err(admit::changed(name))
}

/// Makes an admitted system the desired one. The caller holds [`Core::admission`].
async fn store(core: &Core, name: &str, admitted: Admitted) -> Result<ApplyResult, Problem> {
    let mut index = admitted.record.index;
    if admitted.changed {
        let generation = admitted.record.generation;
        if admitted.forgets {
            core.backoff().forget_system(name);
        }
        let stored = core.store_change(admitted.record.as_ref().clone()).await;
        index = stored.map_err(|e| of_store(&e))?;
        let message = format!("generation {generation} stored");
        let event = Happening::normal("Applied", &format!("system/{name}"), message);
        core.record(event.of(Some(name)));
    } else {
        core.confirm(name).await.map_err(|e| of_store(&e))?;
        core.wake.notify_one();
    }
    Ok(ApplyResult {
        system: find(core, name)?,
        changed: admitted.changed,
        plan: Arc::unwrap_or_clone(admitted.plan),
        index,
    })
}

async fn delete_now(
    core: &Arc<Core>,
    name: &str,
    precondition: &Precondition,
    forgotten: Vec<String>,
) -> Result<System, Problem> {
    let _admission = core.admission.lock().await;
    check_version(core, name, precondition)?;
    let before = core.registry().systems.get(name).cloned();
    let before = before.ok_or_else(|| missing(name))?;
    let mut record = before.as_ref().clone();
    forget(core, &mut record, forgotten)?;
    let begins = record.deleted.is_none();
    record.deleted.get_or_insert_with(|| core.clock.now());
    if record != *before {
        let dropped = record.forgotten.difference(&before.forgotten);
        let dropped: Vec<String> = dropped.cloned().collect();
        core.backoff().forget_system(name);
        core.store_change(record).await.map_err(|e| of_store(&e))?;
        let tell = |event: Happening| core.record(event.of(Some(name)));
        let object = format!("system/{name}");
        if begins {
            tell(Happening::normal("Deleting", &object, "being taken down"));
        }
        for node in dropped {
            let message = format!("its part on node {node} is no longer waited for");
            tell(Happening::warning("NodeForgotten", &object, message));
        }
    }
    find(core, name)
}

/// Takes the word of nodes for given. Only that of nodes that cannot be asked: the others clean up in a moment.
fn forget(core: &Core, record: &mut SystemRecord, nodes: Vec<String>) -> Result<(), Problem> {
    for node in nodes {
        if !record.nodes.contains(&node) {
            continue;
        }
        let live = core.sessions.get(&node).is_some_and(|entry| !entry.lost);
        if live && Standing::get(core, &node) == Standing::Agreed {
            let (name, detail) = (record.name(), "it takes its part down by itself");
            return Err(Problem::conflict(
                "node-not-unknown",
                format!(
                    "node {node} of system {name} is not Unknown, and so not forgotten: {detail}"
                ),
            ));
        }
        record.forgotten.insert(node);
    }
    Ok(())
}

/// A system as it is shown.
pub fn find(core: &Core, name: &str) -> Result<System, Problem> {
    core.view.get::<System>(name).ok_or_else(|| missing(name))
}

/// There is no such system.
pub fn missing(name: &str) -> Problem {
    Problem::not_found(format!("there is no system {name}"))
}

/// A store that failed: nothing was changed.
pub fn of_store(error: &StoreError) -> Problem {
    tracing::error!(error = %rts_host::error::chain(error), "store failed");
    match error {
        StoreError::Full { path } => {
            let folder = path.parent().unwrap_or(path);
            let help = format!(
                "free some space (`df -h {}`), then try again",
                folder.display()
            );
            let mut problem = Problem::new(507, "store-full", "no space left", error.to_string());
            problem.retryable = true;
            problem.with_errors(vec![ProblemError {
                pointer: String::new(),
                code: "store-full".to_owned(),
                detail: error.to_string(),
                help: Some(help),
            }])
        }
        _ => Problem::unavailable("store-failed", rts_host::error::chain(error)),
    }
}

fn check_version(core: &Core, name: &str, precondition: &Precondition) -> Result<(), Problem> {
    let present = core.view.get::<System>(name);
    let version = present.map(|system| system.metadata.resource_version);
    let failed = |what: String| {
        let title = "precondition failed";
        Err(Problem::new(412, "precondition-failed", title, what))
    };
    if let (true, Some(version)) = (precondition.absent, &version) {
        return failed(format!(
            "system {name} is there already, at version {version}"
        ));
    }
    let Some(wanted) = &precondition.if_match else {
        return Ok(());
    };
    let matches = version.as_ref().is_some_and(|version| {
        let mut tags = wanted.split(',').map(|tag| tag.trim().trim_matches('"'));
        tags.any(|tag| tag == "*" || tag == version)
    });
    if matches {
        return Ok(());
    }
    let now = version.map_or_else(
        || "there is none".to_owned(),
        |version| format!("its version is {version}"),
    );
    failed(format!(
        "system {name} is not at version {wanted}: {now}; read it again"
    ))
}
