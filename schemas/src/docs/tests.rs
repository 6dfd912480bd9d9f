use std::collections::BTreeSet;

use super::*;

/// Every type once.
fn all(each: &mut impl FnMut(&str, &Docs)) {
    fn walk(
        root: &str,
        docs: &Docs,
        seen: &mut BTreeSet<String>,
        each: &mut impl FnMut(&str, &Docs),
    ) {
        if !seen.insert(docs.name.clone()) {
            return;
        }
        each(root, docs);
        for inner in docs.fields.iter().filter_map(|field| field.inner.as_ref()) {
            walk(root, &inner.docs(), seen, each);
        }
    }
    for root in ROOTS {
        walk(root.title, &(root.docs)(), &mut BTreeSet::new(), each);
    }
}

#[test]
fn every_field_is_documented() {
    let mut count = 0;
    let mut thin = Vec::new();
    all(&mut |root, docs| {
        if docs.text.len() < 15 || !docs.text.ends_with('.') {
            thin.push(format!("{root}: {}: {}", docs.name, docs.text));
        }
        for field in &docs.fields {
            count += 1;
            let place = format!("{root}: {}.{}", docs.name, field.name);
            let least = if root.starts_with("Deployment") {
                10
            } else {
                25
            };
            if field.text.len() < least || !field.text.ends_with('.') {
                thin.push(format!("{place}: {}", field.text));
            }
            assert!(!field.text.contains("- "), "{place}: {}", field.text);
            let found = docs.field(&field.name).unwrap();
            assert_eq!(found.xml, field.xml, "{place}");
            for other in &field.others {
                assert!(docs.field(other).is_some(), "{place}: {other}");
            }
        }
    });
    assert!(thin.is_empty(), "{}", thin.join("\n"));
    assert!(count > 300, "{count}");
}

#[test]
fn a_path_leads_to_its_field() {
    let found = find("system.components.dataPorts", None).unwrap();
    assert_eq!(found.field.unwrap().kind, "[]DataPort");
    let found = find("system.Components.DataPorts.rtsExt::visible", None).unwrap();
    assert_eq!(found.path, "system.components.dataPorts.visible");
    let found = find(
        "system.activation.targets.condition/waitTime.waittime",
        None,
    )
    .unwrap();
    assert_eq!(
        found.field.unwrap().facts.unit.as_deref(),
        Some("milliseconds")
    );
    let old = find("system.components.startUp", Some("0.1")).unwrap();
    assert_eq!(old.root.title, "RTS Profile 0.1");
    // Constraints hold constraints.
    let path = "component.configurationSet.configuration.constraint.list.constraint.unit.and";
    assert_eq!(find(path, None).unwrap().docs.unwrap().name, "Constraints");
}

#[test]
fn an_overlay_is_documented_from_its_schema() {
    let found = find("overlay.spec.components", None).unwrap();
    assert_eq!(found.field.unwrap().kind, "map[string]Settings");
    assert!(found.docs.unwrap().field("isolated").is_some());
    let found = find("overlay.spec.order.activation.timing", None).unwrap();
    assert_eq!(found.field.unwrap().facts.values, ["sync", "async"]);
    let found = find("overlay.kind", None).unwrap().field.unwrap();
    assert!(found.facts.required.is_some());
    assert_eq!(found.facts.values, ["Deployment"]);
}

#[test]
fn a_path_to_nowhere_says_what_is_near() {
    let said = |path: &str, version| {
        let error = find(path, version).unwrap_err();
        format!("{error}; {}", error.help)
    };
    let all = [
        said("system.component", None),
        said("system.components.dataPort.x", None),
        said("system.components.id.x", None),
        said("sistem", None),
        said("system", Some("0.7")),
        said("system.components.startUp", None),
    ];
    insta::assert_snapshot!(all.join("\n"));
}

#[test]
fn a_path_may_start_with_a_root_and_go_through_free_names() {
    for (path, expected, kind) in [
        ("rtsProfile.components", "system.components", "[]Component"),
        (
            "rts:RtsProfile.Components",
            "system.components",
            "[]Component",
        ),
        ("RtcProfile.basicInfo", "component.basicInfo", "BasicInfo"),
        (
            "overlay.spec.components.Motor0.node",
            "overlay.spec.components.Motor0.node",
            "string",
        ),
        (
            "overlay.spec.components.Motor0",
            "overlay.spec.components.Motor0",
            "Settings",
        ),
        (
            "overlay.spec.defaults.configuration.sets.fast.gain",
            "overlay.spec.defaults.configuration.sets.fast.gain",
            "string",
        ),
    ] {
        let found = find(path, None).unwrap();
        assert_eq!(
            (found.path.as_str(), found.field.unwrap().kind.as_str()),
            (expected, kind)
        );
        assert!(is_path(path));
    }
    assert!(find("overlay.spec.hosts.a.b", None).is_err());
    assert!(find("overlay.spec.components.Motor0.nod", None).is_err());
}
