//! Verbs on modules: Install, LoadModule, UnloadModule.

use rts_manager_api::control::{FailureCode, RequestBody};
use rts_plan::desired::ManagerKey;

use super::verb::{StepError, Verb, unless};

/// Finds the module file of a type.
pub(super) async fn install(
    verb: &Verb,
    type_name: &str,
    digest: Option<&str>,
) -> Result<(), StepError> {
    verb.agent.modules.find(type_name, digest).await?;
    Ok(())
}

/// Opens a module in a manager.
pub(super) async fn load(
    verb: &Verb,
    manager: &ManagerKey,
    type_name: &str,
    digest: Option<&str>,
) -> Result<(), StepError> {
    let module = verb.agent.modules.find(type_name, digest).await?;
    let manager = verb.manager(manager)?;
    let request = RequestBody::LoadModule {
        type_name: type_name.to_owned(),
        path: module.path,
        digest: Some(module.digest),
    };
    manager.link.call(request, verb.limit).await?;
    Ok(())
}

/// Forgets a module.
pub(super) async fn unload(
    verb: &Verb,
    manager: &ManagerKey,
    type_name: String,
) -> Result<(), StepError> {
    let Some(manager) = verb.manager_if_any(manager) else {
        return Ok(());
    };
    let request = RequestBody::UnloadModule { type_name };
    unless(
        FailureCode::NotFound,
        manager.link.done(request, verb.limit).await,
    )
}
