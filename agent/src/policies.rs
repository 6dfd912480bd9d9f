//! What the ledger's spec says of single components, to be had without waiting for the ledger.

use std::collections::BTreeMap;
use std::time::Duration;

use rts_plan::desired::{ManagerKey, NodeSpec, SystemRef};
use rts_schemas::system::{LIVENESS_TIMEOUT_MS, OnHang, Policy, START_TIMEOUT_MS};

/// The policies of all components of the ledger's spec, by system uid and instance name.
#[derive(Debug, Default)]
pub(crate) struct Policies {
    components: BTreeMap<(String, String), Policy>,
    /// System uid → digest of the system's part.
    parts: BTreeMap<String, String>,
    /// System uid → [`rts_plan::desired::NodeSystem::digest`], by which planners know the part.
    digests: BTreeMap<String, String>,
    /// System uid and manager name → instance names of what belongs there.
    places: BTreeMap<(String, String), Vec<String>>,
}

impl Policies {
    /// Those of a spec. `parts` names the text of each system's part, by system uid.
    pub fn of_parts(spec: &NodeSpec, parts: BTreeMap<String, String>) -> Self {
        let mut policies = Self {
            parts,
            ..Self::default()
        };
        for system in &spec.systems {
            let uid = &system.system.uid;
            policies.digests.insert(uid.clone(), system.digest());
            for placed in &system.components {
                let key = (uid.clone(), placed.spec.instance.clone());
                let place = (uid.clone(), placed.manager.clone());
                let instances = policies.places.entry(place).or_default();
                instances.push(placed.spec.instance.clone());
                policies.components.insert(key, placed.spec.policy.clone());
            }
        }
        policies
    }

    /// Those of a spec that was just written.
    #[cfg(test)]
    pub fn of_spec(spec: &NodeSpec) -> Self {
        let part = |system: &rts_plan::desired::NodeSystem| {
            let digest = system.digest();
            (system.system.uid.clone(), digest)
        };
        Self::of_parts(spec, spec.systems.iter().map(part).collect())
    }

    /// The policy of a component; none when the spec does not name it.
    pub fn of(&self, system: &SystemRef, instance: &str) -> Option<&Policy> {
        self.components
            .get(&(system.uid.clone(), instance.to_owned()))
    }

    /// Instance names of the components that belong into a manager.
    pub fn placed_in(&self, key: &ManagerKey) -> &[String] {
        let place = key
            .system
            .as_ref()
            .map(|s| (s.uid.clone(), key.name.clone()));
        place
            .and_then(|place| self.places.get(&place))
            .map_or(&[], Vec::as_slice)
    }

    /// Names the very text of a system's part; none when the spec has no such system.
    pub fn part(&self, system: &SystemRef) -> Option<&str> {
        self.parts.get(&system.uid).map(String::as_str)
    }

    /// By what planners know a system's part; none when the spec has no such system.
    pub fn digest(&self, system: &SystemRef) -> Option<&str> {
        self.digests.get(&system.uid).map(String::as_str)
    }

    /// How long `on_initialize` and `on_activated` of a component may take.
    pub fn start_timeout(&self, system: Option<&SystemRef>, instance: &str) -> Duration {
        let policy = system.and_then(|system| self.of(system, instance));
        start_timeout(policy)
    }
}

/// How long `on_initialize` and `on_activated` may take.
pub(crate) fn start_timeout(policy: Option<&Policy>) -> Duration {
    let set = policy.and_then(|p| p.start_timeout_ms);
    Duration::from_millis(set.unwrap_or(START_TIMEOUT_MS))
}

/// How long any other callback may take, and a manager to answer.
pub(crate) fn liveness_timeout(policy: Option<&Policy>) -> Duration {
    let set = policy.and_then(|p| p.liveness_timeout_ms);
    Duration::from_millis(set.unwrap_or(LIVENESS_TIMEOUT_MS))
}

/// True when the process is to be replaced that a component hangs in.
pub(crate) fn replaces(policy: Option<&Policy>) -> bool {
    policy.is_some_and(|p| p.on_hang == OnHang::Restart)
}
