//! Laws of laying overlays over a system.

use proptest::prelude::*;
use rts_schemas::check;
use rts_schemas::diagnostic::{Finding, Report};
use rts_schemas::overlay::{self, Deployment};
use rts_schemas::placement::{self, Settings};
use rts_schemas::system::SystemSpec;
use rts_schemas::yaml_type::{Setting, YamlType};
use serde_json::{Map, Value, json};

use super::text::{Judge, yaml};
use crate::systems;

/// The text of an overlay with this spec.
fn text(spec: &Value) -> String {
    let value = json!({"apiVersion": "rtsctl.dev/v1", "kind": "Deployment", "spec": spec});
    serde_yaml::to_string(&value).unwrap()
}

/// A system with these specs laid over it, whatever was told of it.
fn laid(mut system: SystemSpec, specs: &[Value]) -> SystemSpec {
    for spec in specs {
        let overlay = overlay::read("o.yaml", text(spec).as_bytes());
        let report = overlay::apply(&mut system, &overlay.unwrap());
        assert!(!report.has_errors(), "{report:?}");
    }
    system
}

/// What is said of each component, as an overlay has it.
fn said_of(system: &SystemSpec) -> Value {
    let all = system.components.iter();
    let all = all.map(|c| (c.instance.clone(), placement::of(c).write()));
    Value::Object(all.collect())
}

/// Names that YAML keeps as they are and that are no globs.
fn is_plain(system: &SystemSpec) -> bool {
    let plain = |name: &str| !name.contains(['*', '?']) && name.trim() == name;
    let mut components = system.components.iter();
    components.all(|c| {
        let sets = &c.configuration.sets;
        let names = sets
            .iter()
            .flat_map(|(set, values)| values.keys().chain([set]));
        plain(&c.instance)
            && plain(&c.type_name)
            && names
                .chain(&c.configuration.active)
                .all(|name| plain(name) && !name.is_empty())
    })
}

/// A system whose names are plain, and that has components.
fn system() -> impl Strategy<Value = SystemSpec> {
    systems::system().prop_filter("plain names", |system| {
        is_plain(system) && !system.components.is_empty()
    })
}

/// Settings of the first component of some system.
fn settings() -> impl Strategy<Value = Value> {
    system().prop_map(|system| in_full(placement::of(&system.components[0]).write()))
}

/// A plain word of a stand-in is a short form, which no merge of texts knows.
fn in_full(mut settings: Value) -> Value {
    if let Some(stand_in) = settings.get_mut("standIn")
        && stand_in.is_string()
    {
        *stand_in = json!({"when": stand_in.take()});
    }
    settings
}

/// Some of the keys, and some of those are taken back.
fn part(value: Value, choices: &mut impl Iterator<Item = u8>, nulls: bool) -> Value {
    let Value::Object(fields) = value else {
        return value;
    };
    let mut part = Map::new();
    for (key, value) in fields {
        match choices.next().unwrap_or(0) % 4 {
            0 => {}
            1 if nulls || !value.is_object() => {
                part.insert(key, Value::Null);
            }
            _ => {
                part.insert(key, self::part(value, choices, nulls));
            }
        }
    }
    Value::Object(part)
}

/// RFC 7396, but `null` is kept.
fn merged(onto: Value, patch: Value) -> Value {
    match (onto, patch) {
        (Value::Object(mut onto), Value::Object(patch)) => {
            for (key, value) in patch {
                let below = onto.remove(&key).unwrap_or(Value::Null);
                onto.insert(key, merged(below, value));
            }
            Value::Object(onto)
        }
        (_, patch) => patch,
    }
}

/// A manager and a process of its own exclude each other, which no merge of texts knows.
fn without_process(mut settings: Value) -> Value {
    if let Some(fields) = settings.as_object_mut() {
        fields.remove("manager");
        fields.remove("isolated");
    }
    settings
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn an_overlay_that_says_what_is_there_changes_nothing(system in system()) {
        let spec = json!({"components": said_of(&system)});
        // A manager's name beside a process of its own is the one thing that nobody can say.
        let mut expected = system.clone();
        for component in &mut expected.components {
            if component.placement.isolated {
                component.placement.manager = None;
            }
        }
        prop_assert_eq!(laid(system, &[spec]), expected);
    }

    #[test]
    fn what_is_written_is_read_again_and_fits_the_schema(system in system()) {
        let said = placement::of(&system.components[0]);
        let spec = overlay::DeploymentSpec {
            defaults: Setting::said(said),
            ..overlay::DeploymentSpec::default()
        };
        let deployment = Deployment {
            api_version: Setting::said(overlay::ApiVersion),
            kind: Setting::said(overlay::Kind),
            spec: Setting::said(spec),
            ..Deployment::default()
        };
        let text = overlay::write(&deployment);
        prop_assert_eq!(Judge::new(overlay::schema()).fault(&yaml(&text)), None);
        let again = overlay::read("o.yaml", text.as_bytes()).unwrap().deployment;
        prop_assert_eq!(again.write(), deployment.write());
    }

    /// Two files one after the other say what one file says that has both, key by key.
    #[test]
    fn overlays_merge_key_by_key(
        system in system(),
        (one, other) in (settings(), settings()),
        choices in prop::collection::vec(any::<u8>(), 1..60),
    ) {
        let mut choices = choices.into_iter().cycle().take(10_000);
        let one = without_process(part(one, &mut choices, false));
        let other = without_process(part(other, &mut choices, true));
        let instance = &system.components[0].instance;
        let spec = |said: Value| json!({"components": {instance: said}});
        let both = merged(one.clone(), other.clone());
        let after = laid(system.clone(), &[spec(one), spec(other)]);
        // Drawn members of one execution context need not fit each other.
        let apart = |finding: &Finding| finding.code.starts_with("execution-context-");
        let mut report = check::spec(&after);
        report.findings.retain(|finding| !apart(finding));
        prop_assert_eq!(report, Report::default());
        let at_once = laid(system.clone(), &[spec(both)]);
        prop_assert_eq!(at_once, after);
    }

    /// Files may be laid one by one or all at once, and an overlay may be cut in two where it speaks of two components.
    #[test]
    fn merging_is_associative(
        system in system(),
        said in prop::collection::vec(settings(), 3),
        choices in prop::collection::vec(any::<u8>(), 1..60),
    ) {
        let mut choices = choices.into_iter().cycle().take(10_000);
        let parts: Vec<Value> = said.into_iter().map(|s| part(s, &mut choices, true)).collect();
        let [a, b, c] = &parts[..] else { panic!("three") };
        let last = &system.components[system.components.len() - 1];
        let specs = [
            json!({"defaults": a}),
            json!({"types": {&last.type_name: b}, "components": {"*": a}}),
            json!({"components": {&last.instance: c}}),
        ];
        let all = laid(system.clone(), &specs);
        let first = laid(system.clone(), &specs[..1]);
        prop_assert_eq!(&laid(first, &specs[1..]), &all);
        let (name, of_type) = (&last.instance, &last.type_name);
        let joined = json!({"types": {of_type: b}, "components": {"*": a, name: c}});
        prop_assert_eq!(&laid(system.clone(), &[specs[0].clone(), joined]), &all);
    }

    #[test]
    fn instance_beats_type_beats_glob_beats_defaults(
        system in system(),
        said in prop::collection::vec(settings(), 4),
    ) {
        let component = &system.components[0];
        let (instance, of_type) = (&component.instance, &component.type_name);
        let spec = json!({
            "components": {instance: said[0], "*": said[2]},
            "types": {of_type: said[1]},
            "defaults": said[3],
        });
        let mut expected = component.clone();
        for weaker in said.iter().rev() {
            let read = overlay::read("o.yaml", text(&json!({"defaults": weaker})).as_bytes());
            let read = read.unwrap().deployment;
            let settings: &Settings = read.spec.get().unwrap().defaults.get().unwrap();
            placement::lay(&mut expected, settings);
        }
        let laid = laid(system.clone(), &[spec]);
        prop_assert_eq!(&laid.components[0], &expected);
    }
}
