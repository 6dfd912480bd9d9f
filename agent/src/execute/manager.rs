//! Verbs on managers: StartManager, StopManager.

use rts_plan::desired::ManagerKey;

use super::verb::{StepError, Verb};

/// Starts a manager, or finds it running.
pub(super) async fn start(verb: &Verb, key: &ManagerKey) -> Result<(), StepError> {
    if let Some(reason) = why_empty(verb, key) {
        return Err(StepError::Refused(reason));
    }
    verb.agent.ensure_manager(key).await?;
    Ok(())
}

/// Why nothing can be made in a manager: all that belongs there has died since the plan was made, and is held. The plan
/// that replaces a process is made before its end counts.
fn why_empty(verb: &Verb, key: &ManagerKey) -> Option<String> {
    let system = key.system.as_ref()?;
    let policies = verb.agent.policies();
    let held = |instance: &String| verb.agent.restarts.why_held(system, instance);
    let reasons: Option<Vec<String>> = policies.placed_in(key).iter().map(held).collect();
    reasons?.into_iter().next()
}

/// Stops one start of a manager; another start is left alone.
pub(super) async fn stop(
    verb: &Verb,
    key: &ManagerKey,
    incarnation: &str,
) -> Result<(), StepError> {
    match verb.manager_if_any(key) {
        Some(manager) if manager.incarnation == incarnation => {
            let patience = verb.agent.manager_leaves(incarnation).await;
            Ok(manager.stop(patience).await?)
        }
        _ => Ok(()),
    }
}
