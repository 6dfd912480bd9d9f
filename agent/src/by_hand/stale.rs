//! Marks that mean nothing any more: what was desired when a person changed something is desired no longer.
//!
//! They are forgotten rather than only passed over. Otherwise what was desired then, desired again one day, would make
//! a change of a person out of what is none: a system that adopted a change could never go back.

use std::collections::BTreeMap;
use std::sync::Arc;

use rts_manager_api::control::{ByHandInfo, RequestBody};
use rts_plan::desired::{ManagerKey, NodeSpec, NodeSystem};
use rts_plan::mark::Mark;
use rts_plan::observed::{ByHand, ComponentObserved, Inventory, LifeCycleState};

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
            let Some((spec, is_new)) = agent.to_be_checked(revision).await else {
                return;
            };
            for (key, request) in stale(&spec, &marked) {
                agent.tell_marks(&key, request).await;
            }
            if is_new {
                // Only another wish ends them: until then, one set back by hand may be on its way to be adopted.
                for (_, component) in marked.iter().filter(|(_, c)| is_configured(c)) {
                    agent.settle_mark(&component.instance).await;
                }
            }
        });
    }

    /// What is desired, and whether that is new, unless marks were compared with it for this revision. Nothing else
    /// tells what is stale, so that a manager that never forgets is not asked over and over.
    async fn to_be_checked(&self, revision: u64) -> Option<(NodeSpec, bool)> {
        let ledger = self.ledger.lock().await;
        let held = ledger.held()?;
        let now = (revision, held.generation);
        let before = std::mem::replace(&mut *lock(&self.marks_checked), now);
        (before != now).then(|| (held.spec.clone(), before.1 != now.1))
    }

    /// Ends the mark of a configuration for all that is no drift any more, as it is now.
    async fn settle_mark(self: &Arc<Self>, instance: &str) {
        let _turn = self.turns.at(instance).await;
        let inventory = self.observe().await;
        let Ok((live, manager)) = self.find_component(&inventory, instance) else {
            return;
        };
        let request = {
            let ledger = self.ledger.lock().await;
            let systems = ledger.held().map(|held| &held.spec.systems);
            let mut systems = systems.into_iter().flatten();
            let part = systems.find(|part| Some(&part.system) == live.system.as_ref());
            part.and_then(|part| settled(part, &live))
        };
        if let Some(request) = request {
            self.tell_marks(&manager.key, request).await;
        }
    }

    async fn tell_marks(&self, key: &ManagerKey, request: RequestBody) {
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

fn is_configured(component: &ComponentObserved) -> bool {
    component.by_hand.configured.is_some()
}

/// What its manager is to be told of the mark of a configuration; none when all of it is drift.
fn settled(part: &NodeSystem, live: &ComponentObserved) -> Option<RequestBody> {
    let instance = live.instance.clone();
    let mut wanted = part.components.iter();
    let placed = wanted.find(|c| c.spec.instance == instance)?;
    let before = Mark::of(live);
    let mut mark = before.clone();
    mark.settle(placed, live);
    if mark.is_empty() {
        // Also a text that is no mark of now.
        let by_hand = ByHandInfo {
            configured: Some(live.by_hand.configured.clone()?),
            ..ByHandInfo::default()
        };
        return Some(RequestBody::Forget {
            instance,
            by_hand,
            connectors: BTreeMap::new(),
        });
    }
    (mark != before).then(|| RequestBody::Configure {
        instance,
        sets: BTreeMap::new(),
        active: None,
        rate: None,
        on_disconnect: None,
        order: None,
        by_hand: Some(mark.encode()),
    })
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
    wanted.find(|c| c.spec.instance == *instance)?;
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
        deactivated,
        disconnected,
        ..
    } = &component.by_hand;
    // As long as it is Inactive, that is drift, whatever is desired besides.
    let is_inactive = component.state == LifeCycleState::Inactive;
    let by_hand = ByHandInfo {
        configured: None,
        deactivated: deactivated.clone().filter(|_| !is_inactive),
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
