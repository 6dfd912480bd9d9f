//! Unbind: the end of a connector at an in-port goes, when nobody is connected to it.

use std::time::Duration;

use rts_manager_api::control::{BindingInfo, RequestBody, ResponseBody};
use rts_plan::desired::ManagerKey;
use tokio::time::sleep;

use super::verb::{StepError, Verb};
use crate::managers::Manager;

/// Looks at an end that is still connected: its source may just have gone.
const LOOKS: u32 = 5;
/// Between two of them.
const PAUSE: Duration = Duration::from_millis(40);

/// Unbinds. What is gone already is fine; what somebody connected to meanwhile is left, and the next plan sees it. A
/// person who connects it just now has taken the turn.
pub(super) async fn unbind(
    verb: &Verb,
    key: &ManagerKey,
    instance: &str,
    connector: String,
) -> Result<(), StepError> {
    let Some(manager) = verb.manager_if_any(key) else {
        return Ok(());
    };
    let _turn = verb.agent.wiring.at(&connector).await;
    for _ in 0..LOOKS {
        match find(verb, &manager, instance, &connector).await? {
            None => return Ok(()),
            Some(binding) if binding.connected => sleep(PAUSE).await,
            Some(_) => {
                let request = RequestBody::Unbind { connector };
                return Ok(manager.link.done(request, verb.limit).await?);
            }
        }
    }
    Ok(())
}

/// The end at this component, as it is now.
async fn find(
    verb: &Verb,
    manager: &Manager,
    instance: &str,
    connector: &str,
) -> Result<Option<BindingInfo>, StepError> {
    let asked = manager.link.call(RequestBody::Inventory, verb.limit);
    let ResponseBody::Inventory(inventory) = asked.await? else {
        return Err(manager.link.unexpected().into());
    };
    let components = inventory.components.into_iter();
    let mut ends = components
        .filter(|c| c.instance == instance)
        .flat_map(|c| c.bindings);
    Ok(ends.find(|binding| binding.connector == connector))
}
