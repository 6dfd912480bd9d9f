//! Verbs on managers: StartManager, StopManager.

use rts_plan::desired::ManagerKey;

use super::verb::{StepError, Verb};

/// Starts a manager, or finds it running.
pub(super) async fn start(verb: &Verb, key: &ManagerKey) -> Result<(), StepError> {
    verb.agent.ensure_manager(key).await?;
    Ok(())
}

/// Stops one start of a manager; another start is left alone.
pub(super) async fn stop(
    verb: &Verb,
    key: &ManagerKey,
    incarnation: &str,
) -> Result<(), StepError> {
    match verb.manager_if_any(key) {
        Some(manager) if manager.incarnation == incarnation => {
            verb.agent.manager_leaves(incarnation).await;
            Ok(manager.stop().await?)
        }
        _ => Ok(()),
    }
}
