//! What an act is about: a component that is there, its manager, and what is desired of it.

use std::sync::Arc;

use rts_agent_api::messages::Acted;
use rts_http::problem::Problem;
use rts_plan::desired::{PlacedComponent, PlacedConnector, SystemRef};
use rts_plan::observed::{ComponentObserved, Inventory};
use rts_schemas::suggest::advice;
use rts_schemas::system::DriftPolicy;

use crate::agent::Agent;
use crate::events::lock;
use crate::managers::Manager;

/// A component that somebody acts on.
pub(super) struct Subject {
    pub component: ComponentObserved,
    pub manager: Arc<Manager>,
    /// What is desired of it; none without a system, or when its system is to be without it.
    pub wanted: Option<Wanted>,
    /// Its manager keeps marks.
    keeps_marks: bool,
}

/// What is desired of a component.
pub(super) struct Wanted {
    pub component: PlacedComponent,
    /// Connectors of which it is the source.
    pub connectors: Vec<PlacedConnector>,
}

impl Subject {
    /// The mark to send; none where nobody would read it.
    pub fn mark(&self, of: impl FnOnce(&Wanted) -> String) -> Option<String> {
        let wanted = self.wanted.as_ref().filter(|_| self.keeps_marks)?;
        Some(of(wanted))
    }

    /// The desired connector with this name.
    pub fn wanted_connector(&self, name: &str) -> Option<&PlacedConnector> {
        let mut connectors = self.wanted.iter().flat_map(|w| &w.connectors);
        connectors.find(|c| c.spec.name == name)
    }

    fn system(&self) -> Option<&SystemRef> {
        self.component.system.as_ref()
    }

    /// The answer when nothing had to be done, or will have been done by a dry run.
    pub fn unchanged(&self, node: &str, target: String) -> Acted {
        Acted {
            node: node.to_owned(),
            target,
            changed: false,
            system: self.system().map(|system| system.name.clone()),
            policy: None,
            notes: Vec::new(),
        }
    }

    /// The answer after a change that is no difference from what is desired.
    pub fn changed(&self, node: &str, target: String, dry_run: bool) -> Acted {
        Acted {
            changed: !dry_run,
            ..self.unchanged(node, target)
        }
    }

    /// The answer after a change that is a difference from what is desired, with what becomes of it.
    pub fn drifted(&self, node: &str, target: String, dry_run: bool) -> Acted {
        let policy = self.wanted.as_ref().map(|w| w.component.spec.policy.drift);
        Acted {
            policy,
            notes: self.fate(policy).into_iter().collect(),
            ..self.changed(node, target, dry_run)
        }
    }

    /// What becomes of a change, in words.
    fn fate(&self, policy: Option<DriftPolicy>) -> Option<String> {
        let system = &self.system()?.name;
        let name = &self.component.instance;
        let Some(policy) = policy else {
            return Some(format!(
                "system {system} is to be without {name}: it is about to be removed"
            ));
        };
        if !self.keeps_marks {
            return Some(format!(
                "manager {} is of an older version, which does not keep what was changed by hand: system {system} puts it back, whatever rtsctl.drift says, until that process is started again",
                self.manager.key.display_name()
            ));
        }
        Some(match policy {
            DriftPolicy::Repair => format!(
                "system {system} repairs drift: it will be put back; see rtsctl.drift of {name}"
            ),
            DriftPolicy::Ignore => {
                format!("system {system} leaves it so (rtsctl.drift of {name} is ignore)")
            }
            DriftPolicy::Adopt => {
                format!("system {system} takes it over (rtsctl.drift of {name} is adopt)")
            }
        })
    }
}

/// Advice for a name that is not there: the nearest one, and those that are.
pub(super) fn advised(word: &str, what: &str, mut names: Vec<&str>) -> String {
    if names.is_empty() {
        return "it has none".to_owned();
    }
    names.sort_unstable();
    names.dedup();
    advice(word, what, &names)
}

fn keeps_marks(manager: &Manager, instance: &str) -> bool {
    let seen = lock(&manager.seen);
    let mut components = seen.inventory.components.iter();
    components.any(|c| c.instance == instance && c.by_hand.is_some())
}

impl Agent {
    /// The component that somebody means, as it is now.
    pub(super) async fn subject(self: &Arc<Self>, instance: &str) -> Result<Subject, Problem> {
        let inventory = self.observe().await;
        self.subject_in(&inventory, instance).await
    }

    /// The same, in an inventory of just now.
    pub(super) async fn subject_in(
        &self,
        inventory: &Inventory,
        instance: &str,
    ) -> Result<Subject, Problem> {
        let (component, manager) = self.find_component(inventory, instance)?;
        let keeps_marks = keeps_marks(&manager, instance);
        let wanted = match &component.system {
            Some(system) => self.wanted(system, instance).await,
            None => None,
        };
        Ok(Subject {
            component,
            manager,
            wanted,
            keeps_marks,
        })
    }

    /// A component of this node and the manager that holds it, which must answer.
    pub(crate) fn find_component(
        &self,
        inventory: &Inventory,
        instance: &str,
    ) -> Result<(ComponentObserved, Arc<Manager>), Problem> {
        let node = &self.config.node;
        let managers = inventory.managers.iter();
        let mut all = managers.flat_map(|m| m.components.iter().map(move |c| (m, c)));
        let found = all.clone().find(|(_, c)| c.instance == instance);
        let Some((holder, component)) = found else {
            let names: Vec<&str> = all.by_ref().map(|(_, c)| c.instance.as_str()).collect();
            return Err(Problem::not_found(format!(
                "node {node} has no component {instance}; {}",
                advised(instance, "components", names)
            )));
        };
        let name = holder.key.display_name();
        let manager = self.managers.get(&holder.key).filter(|_| holder.responsive);
        let manager = manager.ok_or_else(|| {
            Problem::unavailable(
                "manager-silent",
                format!("manager {name}, which holds {instance}, does not answer now"),
            )
        })?;
        Ok((component.clone(), manager))
    }

    /// What is desired of a component.
    pub(super) async fn wanted(&self, system: &SystemRef, instance: &str) -> Option<Wanted> {
        let ledger = self.ledger.lock().await;
        let mut systems = ledger.held()?.spec.systems.iter();
        let part = systems.find(|part| part.system == *system)?;
        let mut components = part.components.iter();
        let component = components.find(|c| c.spec.instance == instance)?.clone();
        let connectors = part.connectors.iter();
        let own = connectors.filter(|c| c.spec.source.instance == instance);
        Some(Wanted {
            component,
            connectors: own.cloned().collect(),
        })
    }
}
