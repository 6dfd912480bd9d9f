//! A component's placement and policies → the keys that say them: the other way round than [`super::set`].

use crate::system::{ComponentSpec, DriftPolicy, OnDisconnect, OnHang, RestartPolicy};

/// The keys, without prefix, and values that a component needs beside the defaults, in the order of [`super::KEYS`].
/// A process of its own goes before a manager's name.
pub fn settings(component: &ComponentSpec) -> Vec<(&'static str, String)> {
    let placement = &component.placement;
    let policy = &component.policy;
    let manager = placement.manager.as_ref().filter(|_| !placement.isolated);
    let word = |value: &str, default: &str| (value != default).then(|| value.to_owned());
    let time = |ms: Option<u64>| ms.map(spelled);
    let all = [
        ("node", placement.node.clone()),
        ("manager", manager.cloned()),
        ("isolated", truth(placement.isolated)),
        (
            "restart",
            word(policy.restart.as_str(), RestartPolicy::default().as_str()),
        ),
        ("restartLimit", policy.restart_limit.map(|n| n.to_string())),
        ("restartWindow", time(policy.restart_window_ms)),
        ("startTimeout", time(policy.start_timeout_ms)),
        ("livenessTimeout", time(policy.liveness_timeout_ms)),
        (
            "onHang",
            word(policy.on_hang.as_str(), OnHang::default().as_str()),
        ),
        (
            "onDisconnect",
            word(
                policy.on_disconnect.as_str(),
                OnDisconnect::default().as_str(),
            ),
        ),
        ("resetOnError", truth(policy.reset_on_error)),
        (
            "drift",
            word(policy.drift.as_str(), DriftPolicy::default().as_str()),
        ),
    ];
    let said = all.into_iter();
    said.filter_map(|(key, value)| Some((key, value?)))
        .collect()
}

fn truth(value: bool) -> Option<String> {
    value.then(|| "true".to_owned())
}

/// Milliseconds in the largest unit that leaves a whole number.
fn spelled(ms: u64) -> String {
    let units = [("h", 3_600_000), ("m", 60_000), ("s", 1000)];
    let whole = units
        .iter()
        .find(|(_, unit)| ms > 0 && ms.is_multiple_of(*unit));
    match whole {
        Some((name, unit)) => format!("{}{name}", ms / unit),
        None => format!("{ms}ms"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::placement::{KEYS, set};
    use crate::system::{Configuration, ExecutionContextSpec, Placement, Policy};

    fn component() -> ComponentSpec {
        ComponentSpec {
            instance: "Sine0".to_owned(),
            type_name: "Sine".to_owned(),
            full_id: String::new(),
            required: true,
            ports: Vec::new(),
            configuration: Configuration::default(),
            execution_context: ExecutionContextSpec::default(),
            placement: Placement::default(),
            policy: Policy::default(),
        }
    }

    #[test]
    fn what_is_default_is_not_said() {
        assert_eq!(settings(&component()), []);
    }

    #[test]
    fn every_key_comes_back_as_it_was_set() {
        let values = [
            ("node", "n1"),
            ("manager", "left.arm"),
            ("isolated", "true"),
            ("restart", "on-failure"),
            ("restartLimit", "3"),
            ("restartWindow", "90s"),
            ("startTimeout", "100ms"),
            ("livenessTimeout", "24h"),
            ("onHang", "restart"),
            ("onDisconnect", "stop"),
            ("resetOnError", "true"),
            ("drift", "adopt"),
        ];
        assert_eq!(values.map(|(key, _)| key), KEYS);
        let mut all = component();
        for (key, value) in values {
            let mut one = component();
            set(&mut one, key, value).unwrap();
            assert_eq!(settings(&one), [(key, value.to_owned())]);
            set(&mut all, key, value).unwrap();
        }
        // A manager's name says nothing beside a process of its own.
        let expected: Vec<_> = values.iter().filter(|(key, _)| *key != "manager").collect();
        let said = settings(&all);
        assert!(
            said.iter()
                .map(|(key, value)| (*key, value.as_str()))
                .eq(expected.into_iter().copied())
        );
    }

    #[test]
    fn times_are_spelled_in_their_unit() {
        let spelled = [100, 1500, 90_000, 600_000, 3_600_000, 0].map(spelled);
        assert_eq!(spelled, ["100ms", "1500ms", "90s", "10m", "1h", "0ms"]);
    }
}
