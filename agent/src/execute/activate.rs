//! Activate: of a component that lost a peer for good, the lost ends are taken away first.

use rts_manager_api::control::{BindingInfo, FailureCode, RequestBody, ResponseBody};
use rts_plan::desired::ManagerKey;

use super::component::done;
use super::verb::{StepError, Verb};

/// Activates a component. Its manager refuses that while an end is lost that `rtsctl.onDisconnect` speaks of; an end
/// that is in no spec any more is nobody's loss.
pub(crate) async fn activate(
    verb: &Verb,
    key: &ManagerKey,
    instance: String,
) -> Result<(), StepError> {
    let activate = || RequestBody::Activate {
        instance: instance.clone(),
    };
    match done(verb, key, activate()).await {
        Err(e) if e.is(FailureCode::ComponentFailed) => {
            if forget_ends(verb, key, &instance).await? == 0 {
                return Err(e);
            }
            done(verb, key, activate()).await
        }
        other => other,
    }
}

/// Unbinds the lost in-port ends of a component whose connectors are not desired. Gives their number.
async fn forget_ends(verb: &Verb, key: &ManagerKey, instance: &str) -> Result<usize, StepError> {
    let manager = verb.manager(key)?;
    let answer = manager
        .link
        .call(RequestBody::Inventory, verb.limit)
        .await?;
    let ResponseBody::Inventory(inventory) = answer else {
        return Err(manager.link.unexpected().into());
    };
    let own = inventory.components.into_iter();
    let bindings = own
        .filter(|c| c.instance == instance)
        .flat_map(|c| c.bindings);
    let lost: Vec<BindingInfo> = bindings.filter(|binding| !binding.connected).collect();
    let mut forgotten = 0;
    for BindingInfo { connector, .. } in lost {
        if !is_desired(verb, &connector).await {
            let unbind = RequestBody::Unbind { connector };
            manager.link.done(unbind, verb.limit).await?;
            forgotten += 1;
        }
    }
    Ok(forgotten)
}

async fn is_desired(verb: &Verb, connector: &str) -> bool {
    let ledger = verb.agent.ledger.lock().await;
    let systems = ledger
        .held()
        .into_iter()
        .flat_map(|held| &held.spec.systems);
    let mut own = systems.filter(|part| Some(&part.system) == verb.system.as_ref());
    own.any(|part| part.connectors.iter().any(|c| c.spec.name == connector))
}
