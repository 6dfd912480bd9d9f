//! What clients may change: apply a system, ask for its end. Durable before it is answered.

use std::sync::Arc;

use rts_controller_api::Problem;
use rts_controller_api::objects::System;
use rts_controller_api::requests::{ApplyRequest, ApplyResult};

use crate::admit;
use crate::core::Core;
use crate::store::StoreError;
use crate::view::Happening;

/// Applies a system. `if_match` is the header of that name: the versions that the system must have one of.
pub async fn apply(
    core: &Arc<Core>,
    name: &str,
    request: ApplyRequest,
    if_match: Option<&str>,
) -> Result<ApplyResult, Problem> {
    let _admission = core.admission.lock().await;
    check_version(core, name, if_match)?;
    let admitted = admit::admit(core, name, request).await?;
    if admitted.changed {
        let generation = admitted.record.generation;
        core.store_system(admitted.record)
            .await
            .map_err(|e| of_store(&e))?;
        core.backoff().forget_system(name);
        let message = format!("generation {generation} stored");
        let event = Happening::normal("Applied", &format!("system/{name}"), message);
        core.record(event.of(Some(name)));
        core.desired_changed();
    } else {
        core.wake.notify_one();
    }
    Ok(ApplyResult {
        system: find(core, name)?,
        changed: admitted.changed,
        plan: admitted.plan,
    })
}

/// Asks for a system's end.
pub async fn delete(
    core: &Arc<Core>,
    name: &str,
    if_match: Option<&str>,
) -> Result<System, Problem> {
    let _admission = core.admission.lock().await;
    check_version(core, name, if_match)?;
    let record = core.registry().systems.get(name).cloned();
    let mut record = record.ok_or_else(|| missing(name))?;
    if record.deleted.is_none() {
        record.deleted = Some(core.clock.now());
        core.store_system(record).await.map_err(|e| of_store(&e))?;
        core.backoff().forget_system(name);
        let event = Happening::normal("Deleting", &format!("system/{name}"), "being taken down");
        core.record(event.of(Some(name)));
        core.desired_changed();
    }
    find(core, name)
}

/// A system as it is shown.
pub fn find(core: &Core, name: &str) -> Result<System, Problem> {
    core.view.get::<System>(name).ok_or_else(|| missing(name))
}

fn missing(name: &str) -> Problem {
    Problem::not_found(format!("there is no system {name}"))
}

/// A store that failed: nothing was changed.
fn of_store(error: &StoreError) -> Problem {
    tracing::error!(error = %crate::chain(error), "store failed");
    Problem::unavailable("store-failed", crate::chain(error))
}

fn check_version(core: &Core, name: &str, if_match: Option<&str>) -> Result<(), Problem> {
    let Some(wanted) = if_match else {
        return Ok(());
    };
    let present = core.view.get::<System>(name);
    let version = present.map(|system| system.metadata.resource_version);
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
    Err(Problem::new(
        412,
        "precondition-failed",
        "precondition failed",
        format!("system {name} is not at version {wanted}: {now}; read it again"),
    ))
}
