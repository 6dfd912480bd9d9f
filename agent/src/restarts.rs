//! How often each component was made again because its process died.

use std::collections::BTreeMap;
use std::sync::Mutex;

use rts_plan::desired::{NodeSpec, SystemRef};

use crate::events::lock;

/// Most components that are remembered.
const MAX: usize = 4096;

/// Identity of a component: (system uid, instance name).
type Identity = (String, String);

/// Counts that the next creation carries on.
#[derive(Debug, Default)]
pub(crate) struct Restarts(Mutex<BTreeMap<Identity, u32>>);

impl Restarts {
    /// Notes that the process of a component died, which had been made again `before` times.
    pub fn died(&self, system: &SystemRef, instance: &str, before: u32) {
        let mut counts = lock(&self.0);
        if counts.len() < MAX || counts.contains_key(&identity(system, instance)) {
            counts.insert(identity(system, instance), before.saturating_add(1));
        }
    }

    /// The count that the next creation of a component has.
    pub fn of(&self, system: &SystemRef, instance: &str) -> u32 {
        lock(&self.0)
            .get(&identity(system, instance))
            .copied()
            .unwrap_or(0)
    }

    /// Forgets components that a spec does not name.
    pub fn keep(&self, spec: &NodeSpec) {
        let named: std::collections::BTreeSet<Identity> = spec
            .systems
            .iter()
            .flat_map(|s| {
                s.components
                    .iter()
                    .map(|c| identity(&s.system, &c.spec.instance))
            })
            .collect();
        lock(&self.0).retain(|identity, _| named.contains(identity));
    }
}

fn identity(system: &SystemRef, instance: &str) -> Identity {
    (system.uid.clone(), instance.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_go_on_and_belong_to_one_system() {
        let restarts = Restarts::default();
        let system = |uid: &str| SystemRef {
            name: "hello".to_owned(),
            uid: uid.to_owned(),
        };
        restarts.died(&system("1"), "Sine0", 0);
        restarts.died(&system("1"), "Sine0", restarts.of(&system("1"), "Sine0"));
        assert_eq!(restarts.of(&system("1"), "Sine0"), 2);
        assert_eq!(restarts.of(&system("2"), "Sine0"), 0);
        restarts.keep(&NodeSpec::default());
        assert_eq!(restarts.of(&system("1"), "Sine0"), 0);
    }
}
