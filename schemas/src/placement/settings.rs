//! A component → what has to be said to get it: the other way round than [`super::lay`].

use std::collections::BTreeMap;

use serde_json::Value;

use super::{
    ConfigurationSettings, ExecutionContextSettings, ResourceSettings, Settings, StandInSetting,
};
use crate::span::{Span, Text};
use crate::system::{ComponentSpec, Configuration, ExecutionContextSpec, Resources};
use crate::yaml_type::{Map, Setting, leaves_of};

/// What a component needs beside the defaults. A process of its own goes before a manager's name.
pub fn of(component: &ComponentSpec) -> Settings {
    let placement = &component.placement;
    let policy = &component.policy;
    let manager = placement.manager.clone().filter(|_| !placement.isolated);
    Settings {
        node: Setting::some(placement.node.clone()),
        manager: Setting::some(manager),
        isolated: unless_default(&placement.isolated),
        restart: unless_default(&policy.restart),
        restart_limit: Setting::some(policy.restart_limit),
        restart_window: Setting::some(policy.restart_window_ms),
        start_timeout: Setting::some(policy.start_timeout_ms),
        liveness_timeout: Setting::some(policy.liveness_timeout_ms),
        on_hang: unless_default(&policy.on_hang),
        on_disconnect: unless_default(&policy.on_disconnect),
        reset_on_error: unless_default(&policy.reset_on_error),
        drift: unless_default(&policy.drift),
        package: Setting::some(component.package.name.clone()),
        version: Setting::some(component.package.version.clone()),
        stand_in: unless_default(&StandInSetting::of(&component.stand_in)),
        execution_context: context(&component.execution_context),
        resources: resources(&component.resources),
        configuration: configuration(&component.configuration),
    }
}

/// The keys of a profile, without prefix, and values that a component needs beside the defaults, in the order of the keys.
pub fn settings(component: &ComponentSpec) -> Vec<(String, String)> {
    let said = Settings {
        configuration: Setting::Silent,
        ..of(component)
    };
    let leaves = leaves_of(&said).into_iter();
    leaves
        .map(|leaf| (leaf.path.join("."), spelled(leaf.value)))
        .collect()
}

fn spelled(value: Value) -> String {
    match value {
        Value::String(text) => text,
        other => other.to_string(),
    }
}

fn unless_default<T: Clone + Default + PartialEq>(value: &T) -> Setting<T> {
    match *value == T::default() {
        true => Setting::Silent,
        false => Setting::said(value.clone()),
    }
}

/// Kind and rate have their own place in a profile.
fn context(context: &ExecutionContextSpec) -> Setting<Box<ExecutionContextSettings>> {
    let order = (context.order != 0).then_some(context.order);
    let said = ExecutionContextSettings {
        name: Setting::some(context.name.clone()),
        order: Setting::some(order),
        ..ExecutionContextSettings::default()
    };
    unless_default(&Box::new(said))
}

fn resources(resources: &Resources) -> Setting<ResourceSettings> {
    let said = ResourceSettings {
        cpus: Setting::some(resources.cpus.clone()),
        realtime_priority: Setting::some(resources.realtime_priority),
        lock_memory: Setting::some(resources.lock_memory),
        required: Setting::some(resources.required),
        memory_limit: Setting::some(resources.memory_limit_bytes),
    };
    unless_default(&said)
}

fn configuration(configuration: &Configuration) -> Setting<ConfigurationSettings> {
    let key = |name: &str| Text::new(name, Span::default());
    let values = |values: &BTreeMap<String, String>| {
        let values = values.iter();
        Map(values
            .map(|(name, value)| (key(name), Setting::said(value.clone())))
            .collect())
    };
    let sets = configuration.sets.iter();
    let sets = Map(sets
        .map(|(name, set)| (key(name), Setting::said(values(set))))
        .collect());
    let said = ConfigurationSettings {
        active: Setting::some(configuration.active.clone()),
        sets: unless_default(&sets),
    };
    unless_default(&said)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::placement::{keys, set};

    #[test]
    fn what_is_default_is_not_said() {
        assert_eq!(settings(&ComponentSpec::default()), []);
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
            ("package", "openrtm/sine"),
            ("version", ">=1.2, <2"),
            ("standIn", "missing"),
            ("standIn.startupTime", "2s"),
            ("standIn.fail", "activate"),
            ("standIn.crashAfter", "5s"),
            ("standIn.data.NAME", r#"["1","a b",["2","3"]]"#),
            ("executionContext.name", "control"),
            ("executionContext.order", "-10"),
            ("resources.cpus", "2-3,5"),
            ("resources.realtimePriority", "50"),
            ("resources.lockMemory", "true"),
            ("resources.required", "false"),
            ("resources.memoryLimit", "256MiB"),
        ];
        assert_eq!(values.map(|(key, _)| key.to_owned()).as_slice(), keys());
        let mut all = ComponentSpec::default();
        for (key, value) in values {
            let mut one = ComponentSpec::default();
            set(&mut one, key, value).unwrap();
            assert_eq!(settings(&one), [(key.to_owned(), value.to_owned())]);
            set(&mut all, key, value).unwrap();
        }
        // A manager's name says nothing beside a process of its own.
        let expected: Vec<_> = values.iter().filter(|(key, _)| *key != "manager").collect();
        let said = settings(&all);
        assert!(
            said.iter()
                .map(|(key, value)| (key.as_str(), value.as_str()))
                .eq(expected.into_iter().copied())
        );
    }
}
