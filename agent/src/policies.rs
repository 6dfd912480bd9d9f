//! What the ledger's spec says of single components, to be had without waiting for the ledger.

use std::collections::BTreeMap;
use std::time::Duration;

use rts_plan::desired::{ManagerKey, NodeSpec, SystemRef};
use rts_schemas::system::{LIVENESS_TIMEOUT_MS, OnHang, Policy, START_TIMEOUT_MS};

/// Most leaving components whose policies are kept.
const MAX_LEAVING: usize = 16_384;

/// The policies of all components of the ledger's spec, by system uid and instance name.
#[derive(Debug, Default)]
pub(crate) struct Policies {
    components: BTreeMap<(String, String), Policy>,
    /// The same of components that earlier specs named and that may still be there: they are to go.
    leaving: BTreeMap<(String, String), Policy>,
    /// System uid and manager name → instance names of what leaves and may still be there.
    left_places: BTreeMap<(String, String), Vec<String>>,
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

    /// Keeps the policies of what an earlier spec named and this one does not, where its system is still there.
    pub fn keep_leaving(&mut self, before: &Self, is_there: impl Fn(&str) -> bool) {
        let former = before.components.iter().chain(&before.leaving);
        let leaving = former.filter(|(key, _)| !self.components.contains_key(*key));
        let there = leaving.filter(|((uid, _), _)| is_there(uid));
        self.leaving = there
            .take(MAX_LEAVING)
            .map(|(key, policy)| (key.clone(), policy.clone()))
            .collect();
        for (place, instances) in before.places.iter().chain(&before.left_places) {
            let leaves = |name: &&String| {
                let key = (place.0.clone(), (*name).clone());
                self.leaving.contains_key(&key)
            };
            let leaving: Vec<_> = instances.iter().filter(leaves).cloned().collect();
            if !leaving.is_empty() {
                let left = self.left_places.entry(place.clone()).or_default();
                left.extend(leaving);
            }
        }
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

    /// The policy of a component that is there: while it leaves, what was said of it last.
    pub fn of_present(&self, system: &SystemRef, instance: &str) -> Option<&Policy> {
        let leaving = || {
            let key = (system.uid.clone(), instance.to_owned());
            self.leaving.get(&key)
        };
        self.of(system, instance).or_else(leaving)
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

    /// The components that belong into a manager, or belonged there and may not have left yet, with their policies.
    pub fn belong_in(&self, key: &ManagerKey) -> impl Iterator<Item = (&String, &Policy)> {
        let uid = key.system.as_ref().map(|s| s.uid.clone());
        let place = uid.clone().map(|uid| (uid, key.name.clone()));
        let left = place.and_then(|place| self.left_places.get(&place));
        let instances = self.placed_in(key).iter().chain(left.into_iter().flatten());
        instances.filter_map(move |instance| {
            let name = (uid.clone()?, instance.clone());
            let policy = self.components.get(&name);
            Some((instance, policy.or_else(|| self.leaving.get(&name))?))
        })
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

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn spec(systems: &[(&str, &[(&str, u64)])]) -> Policies {
        let component = |(instance, ms): &(&str, u64)| {
            json!({
                "spec": {"instance": instance, "type": "T", "policy": {"livenessTimeoutMs": ms}},
                "manager": "main",
                "recreateHash": ""
            })
        };
        let system = |(uid, components): &(&str, &[(&str, u64)])| {
            let components: Vec<_> = components.iter().map(component).collect();
            json!({"system": {"name": "hello", "uid": uid}, "components": components})
        };
        let systems: Vec<_> = systems.iter().map(system).collect();
        let spec = json!({"node": "local", "systems": systems});
        Policies::of_spec(&serde_json::from_value(spec).unwrap())
    }

    /// Liveness time-outs of A and B of system `u`: what holds now.
    fn limits(policies: &Policies) -> [Option<u64>; 2] {
        let system = SystemRef {
            name: "hello".to_owned(),
            uid: "u".to_owned(),
        };
        ["A", "B"].map(|instance| policies.of_present(&system, instance)?.liveness_timeout_ms)
    }

    #[test]
    fn what_leaves_keeps_its_policy_until_its_system_is_gone() {
        let both = spec(&[("u", &[("A", 1_000), ("B", 2_000)])]);
        let mut one = spec(&[("u", &[("A", 3_000)])]);
        one.keep_leaving(&both, |uid| uid == "u");
        assert_eq!(limits(&one), [Some(3_000), Some(2_000)]);
        let mut none = spec(&[("other", &[("A", 9_000)])]);
        none.keep_leaving(&one, |uid| uid == "u");
        assert_eq!(limits(&none), [Some(3_000), Some(2_000)]);
        let main = ManagerKey {
            system: Some(SystemRef {
                name: "hello".to_owned(),
                uid: "u".to_owned(),
            }),
            name: "main".to_owned(),
        };
        let there = |policies: &Policies| {
            let there = policies.belong_in(&main);
            let there =
                there.map(|(name, policy)| format!("{name} {:?}", policy.liveness_timeout_ms));
            there.collect::<Vec<_>>().join(", ")
        };
        for policies in [&one, &none] {
            assert_eq!(there(policies), "A Some(3000), B Some(2000)");
        }
        let named = none.components.keys().map(|(uid, _)| uid.as_str());
        assert_eq!(
            named.collect::<Vec<_>>(),
            ["other"],
            "nothing of it is desired"
        );
        let mut later = spec(&[]);
        later.keep_leaving(&none, |uid| uid == "other");
        assert_eq!(limits(&later), [None, None]);
        assert_eq!(there(&later), "");
    }
}
