//! Marks that mean nothing any more: what was desired when a person changed something is desired no longer.
//!
//! They are forgotten rather than only passed over. Otherwise what was desired then, desired again one day, would make
//! a change of a person out of what is none: a system that adopted a change could never go back.

use std::collections::BTreeMap;
use std::sync::Arc;

use rts_manager_api::control::{ByHandInfo, RequestBody};
use rts_plan::desired::{ManagerKey, NodeSpec, NodeSystem};
use rts_plan::observed::{ByHand, ComponentObserved, Inventory};

use super::LIMIT;
use crate::agent::Agent;
use crate::events::lock;

impl Agent {
    /// Has managers forget what is stale in an inventory of just now. Comes back at once.
    pub(crate) fn forget_stale_marks(self: &Arc<Self>, inventory: &Inventory) {
        let marked = inventory.managers.iter().filter(|m| m.responsive);
        let marked = marked.flat_map(|m| m.components.iter().map(move |c| (&m.key, c)));
        let marked: Vec<_> = marked.filter(|(_, c)| is_marked(c)).collect();
        if marked.is_empty() {
            return;
        }
        let marked: Vec<(ManagerKey, ComponentObserved)> = marked
            .into_iter()
            .map(|(key, component)| (key.clone(), component.clone()))
            .collect();
        let (agent, revision) = (self.clone(), inventory.revision);
        tokio::spawn(async move {
            let requests = {
                let ledger = agent.ledger.lock().await;
                let Some(held) = ledger.held() else { return };
                // Nothing else tells what is stale, so that a manager that never forgets is not asked over and over.
                let now = (revision, held.generation);
                if std::mem::replace(&mut *lock(&agent.marks_checked), now) == now {
                    return;
                }
                stale(&held.spec, &marked)
            };
            for (key, request) in requests {
                agent.forget_marks(&key, request).await;
            }
        });
    }

    async fn forget_marks(&self, key: &ManagerKey, request: RequestBody) {
        let Some(manager) = self.managers.get(key) else {
            return;
        };
        match manager.link.done(request, LIMIT).await {
            Ok(()) => self.dirty.notify_one(),
            Err(e) => {
                tracing::warn!(manager = key.display_name(), "stale marks stay: {e}");
                *lock(&self.marks_checked) = (0, 0);
            }
        }
    }
}

fn is_marked(component: &ComponentObserved) -> bool {
    let made = component.connectors.iter().any(|c| c.by_hand.is_some());
    component.system.is_some() && (made || !component.by_hand.is_empty())
}

/// What managers are to be told.
fn stale(
    spec: &NodeSpec,
    marked: &[(ManagerKey, ComponentObserved)],
) -> Vec<(ManagerKey, RequestBody)> {
    let request = |(key, component): &(ManagerKey, ComponentObserved)| {
        let system = component.system.as_ref()?;
        let part = spec.systems.iter().find(|part| part.system == *system)?;
        Some((key.clone(), stale_in(part, component)?))
    };
    marked.iter().filter_map(request).collect()
}

fn stale_in(part: &NodeSystem, component: &ComponentObserved) -> Option<RequestBody> {
    let instance = &component.instance;
    let mut wanted = part.components.iter();
    let settings = wanted
        .find(|c| c.spec.instance == *instance)?
        .settings_digest();
    let own = part.connectors.iter();
    let own = own.filter(|c| c.spec.source.instance == *instance);
    let digests: BTreeMap<&str, String> = own
        .map(|connector| (connector.spec.name.as_str(), connector.digest()))
        .collect();
    let is_stale = |(name, mark): &(&String, &String)| {
        let now = digests.get(name.as_str()).map_or("", String::as_str);
        now != mark.as_str()
    };
    let copied = |(name, mark): (&String, &String)| (name.clone(), mark.clone());
    let ByHand {
        configured,
        deactivated,
        disconnected,
    } = &component.by_hand;
    let by_hand = ByHandInfo {
        configured: configured.clone().filter(|mark| *mark != settings),
        deactivated: deactivated.clone().filter(|mark| *mark != settings),
        disconnected: disconnected.iter().filter(is_stale).map(copied).collect(),
    };
    let made = component.connectors.iter();
    let made = made.filter_map(|c| Some((&c.name, c.by_hand.as_ref()?)));
    let connectors: BTreeMap<_, _> = made.filter(is_stale).map(copied).collect();
    if by_hand == ByHandInfo::default() && connectors.is_empty() {
        return None;
    }
    Some(RequestBody::Forget {
        instance: instance.clone(),
        by_hand,
        connectors,
    })
}
