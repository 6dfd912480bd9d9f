//! Tests of placement.

use rts_schemas::system::{ExecutionKind, SharedExecutionContext};
use serde_json::json;

use super::*;

fn nodes() -> Vec<NodeFacts> {
    let node = |name: &str, alias: &str| NodeFacts {
        name: name.to_owned(),
        aliases: vec![alias.to_owned()],
    };
    vec![
        node("local", "workstation"),
        node("arm", "arm.robot.example"),
    ]
}

fn system(name: &str, components: serde_json::Value) -> StoredSystem {
    let spec = json!({"name": name, "components": components, "connectors": [
        {"name": "A.out-B.in", "kind": "data",
         "source": {"instance": "A", "port": "out"}, "target": {"instance": "B", "port": "in"}}]});
    StoredSystem {
        reference: SystemRef {
            name: name.to_owned(),
            uid: format!("uid-{name}"),
        },
        spec: serde_json::from_value(spec).unwrap(),
        module_digests: BTreeMap::from([("T".to_owned(), "abc".to_owned())]),
        stand_ins: Default::default(),
        deleting: false,
    }
}

/// `node/manager` of every component, by instance.
fn places(placed: &Placed) -> BTreeMap<String, String> {
    let parts = placed.desired.nodes.iter().flat_map(|(node, spec)| {
        let components = spec.systems.iter().flat_map(|part| &part.components);
        components.map(move |c| (c.spec.instance.clone(), format!("{node}/{}", c.manager)))
    });
    parts.collect()
}

fn at(placement: serde_json::Value) -> (Placed, String) {
    let system = system(
        "s",
        json!([{"instance": "A", "type": "T", "placement": placement}]),
    );
    let placed = place(&[system], &nodes(), "local");
    let place = places(&placed).remove("A").unwrap();
    (placed, place)
}

#[test]
fn named_node_beats_host_beats_local() {
    assert_eq!(at(json!({})).1, "local/main");
    assert_eq!(
        at(json!({"node": "arm", "host": "workstation"})).1,
        "arm/main"
    );
    assert_eq!(at(json!({"host": "ARM.robot.example."})).1, "arm/main");
    assert_eq!(at(json!({"host": "arm", "manager": "ctrl"})).1, "arm/ctrl");
}

#[test]
fn unknown_host_falls_to_the_local_node_with_a_note() {
    let (placed, place) = at(json!({"host": "tulip"}));
    assert_eq!(place, "local/main");
    insta::assert_snapshot!(
        placed.notes["s"].join("\n"),
        @"host tulip is no known node, so node local takes its place: A"
    );
    assert!(placed.accept().is_ok());
}

#[test]
fn unknown_node_is_a_problem_and_stays_where_it_was_put() {
    let (placed, place) = at(json!({"node": "leg"}));
    assert_eq!(place, "leg/main");
    insta::assert_snapshot!(
        placed.accept().unwrap_err(),
        @"component A of system s is to run on node leg, which is not known (known: arm, local)"
    );
}

#[test]
fn components_of_one_execution_context_belong_in_one_process() {
    let context = json!({"name": "control"});
    let of = |placement| {
        let components = json!([
            {"instance": "A", "type": "T", "executionContext": context},
            {"instance": "B", "type": "T", "executionContext": context, "placement": placement},
            {"instance": "C", "type": "T", "placement": {"node": "arm"}},
        ]);
        place(&[system("s", components)], &nodes(), "local")
    };
    assert_eq!(of(json!({"host": "workstation"})).problems, []);
    insta::assert_snapshot!(
        of(json!({"node": "arm"})).accept().unwrap_err(),
        @"components A and B of system s share the execution context control, which needs one process, but are to run in local/main and arm/main"
    );
}

#[test]
fn isolated_components_have_a_process_of_their_own() {
    let isolated = json!({"isolated": true});
    let system = system(
        "s",
        json!([
            {"instance": "main", "type": "T", "placement": isolated},
            {"instance": "A", "type": "T"},
            {"instance": "B/1", "type": "T", "placement": isolated},
            {"instance": "B 1", "type": "T", "placement": isolated},
        ]),
    );
    let places = places(&place(&[system], &nodes(), "local"));
    let managers: BTreeSet<&String> = places.values().collect();
    assert_eq!(managers.len(), 4, "{places:?}");
    assert_eq!(places["main"], "local/main-own");
}

#[test]
fn connectors_are_on_both_nodes_with_their_places() {
    let system = system(
        "s",
        json!([{"instance": "A", "type": "T"}, {"instance": "B", "type": "T", "placement": {"node": "arm"}}]),
    );
    let placed = place(&[system], &nodes(), "local");
    for node in ["local", "arm"] {
        let connector = &placed.desired.nodes[node].systems[0].connectors[0];
        assert_eq!(
            (
                connector.source.node.as_str(),
                connector.target.node.as_str()
            ),
            ("local", "arm")
        );
    }
}

#[test]
fn two_systems_may_not_share_an_instance_name_on_a_node() {
    let components = json!([{"instance": "A", "type": "T"}]);
    let (one, other) = (
        system("one", components.clone()),
        system("other", components),
    );
    let placed = place(&[one.clone(), other.clone()], &nodes(), "local");
    insta::assert_snapshot!(
        placed.accept().unwrap_err(),
        @"instance A on node local is wanted by two systems: one and other"
    );
    let gone = StoredSystem {
        deleting: true,
        ..one
    };
    assert!(place(&[gone, other], &nodes(), "local").accept().is_ok());
}

#[test]
fn a_system_that_goes_keeps_its_nodes_and_orders_but_nothing_else() {
    let mut system = system(
        "s",
        json!([{"instance": "A", "type": "T", "placement": {"node": "arm"}}]),
    );
    system.deleting = true;
    let placed = place(&[system], &nodes(), "local");
    let part = &placed.desired.nodes["arm"].systems[0];
    assert!(part.components.is_empty() && part.connectors.is_empty());
    assert!(placed.desired.nodes["local"].systems.is_empty());
}

#[test]
fn hash_covers_what_cannot_change_in_place() {
    let context = |kind, shared| Context {
        kind,
        shared,
        realtime: None,
    };
    let hash = |t, d, m, k| recreate_hash(t, d, m, &context(k, None), None);
    let shared = |name: &str, order, state: Option<&str>| {
        let shared = SharedExecutionContext {
            name: name.to_owned(),
            order,
            shared_state: state.map(str::to_owned),
        };
        let context = context(ExecutionKind::Periodic, Some(shared));
        recreate_hash("T", Some("abc"), "main", &context, None)
    };
    let first = hash("T", Some("abc"), "main", ExecutionKind::Periodic);
    assert_eq!(first.len(), 16);
    let others = [
        hash("U", Some("abc"), "main", ExecutionKind::Periodic),
        hash("T", Some("abd"), "main", ExecutionKind::Periodic),
        hash("T", None, "main", ExecutionKind::Periodic),
        hash("T", Some("abc"), "aux", ExecutionKind::Periodic),
        hash("T", Some("abc"), "main", ExecutionKind::Other),
        shared("control", 1, None),
        shared("slow", 1, None),
        shared("control", 1, Some("Arm0")),
    ];
    assert!(others.iter().all(|other| *other != first));
    let of = |resources| {
        let components = json!([{"instance": "A", "type": "T", "resources": resources}]);
        let placed = place(&[system("s", components)], &nodes(), "local");
        let part = &placed.desired.nodes["local"].systems[0];
        part.components[0].recreate_hash.clone()
    };
    let none = of(json!({}));
    assert_eq!(
        none,
        of(json!({"memoryLimitBytes": 1_048_576, "required": false}))
    );
    let asked = [
        json!({"cpus": "1"}),
        json!({"cpus": "2"}),
        json!({"realtimePriority": 1}),
        json!({"lockMemory": true}),
        json!({"lockMemory": true, "required": false}),
    ];
    let mut hashes: Vec<_> = asked.map(of).into();
    hashes.push(none);
    let number = hashes.len();
    hashes.sort();
    hashes.dedup();
    assert_eq!(hashes.len(), number);
    assert!(others.iter().collect::<BTreeSet<_>>().len() == others.len());
    assert_eq!(shared("control", 1, None), shared("control", 2, None));
}

#[test]
fn digest_survives_the_way_over_json() {
    let mut system = system(
        "s",
        json!([{"instance": "A", "type": "T", "executionContext": {"rate": 0.1}}]),
    );
    for rate in [33.333333333333336, 0.1 + 0.2, 1e-7, 123456.78901234567] {
        system.spec.components[0].execution_context.rate = Some(rate);
        let placed = place(&[system.clone()], &nodes(), "local");
        let spec = &placed.desired.nodes["local"];
        let text = serde_json::to_string(spec).unwrap();
        let back: NodeSpec = serde_json::from_str(&text).unwrap();
        assert_eq!(digest(spec), digest(&back));
        assert_eq!(digest(spec).len(), 64);
    }
}

#[test]
fn manager_names_follow_the_rule_of_all_and_never_fall_together() {
    for good in ["main", "arm.left", "M_1", &"m".repeat(63)] {
        assert_eq!(sanitise(good), good);
    }
    let bad = [
        "a b",
        "a-b ",
        "左腕",
        "右腕",
        "../../evil",
        "-x",
        &"m".repeat(200),
        "",
    ];
    let made: BTreeSet<String> = bad.into_iter().map(sanitise).collect();
    assert_eq!(made.len(), bad.len());
    assert!(
        made.iter().all(|name| names::is_manager_name(name)),
        "{made:?}"
    );
}

#[test]
fn what_was_settled_holds_whatever_a_host_means_by_now() {
    let system = system(
        "s",
        json!([
            {"instance": "A", "type": "T", "placement": {"host": "arm.robot.example"}},
            {"instance": "B", "type": "T", "placement": {"node": "arm"}},
        ]),
    );
    let settle = |node: &str| {
        let on = |instance: &str| (instance.to_owned(), node.to_owned());
        let settled = Settled {
            generation: 7,
            places: [on("A"), on("B")].into(),
            nodes: ["leg".to_owned()].into(),
            ..Settled::default()
        };
        BTreeMap::from([("uid-s".to_owned(), settled)])
    };
    let mut known = nodes();
    known[1].aliases.clear();
    let placed = place_settled(
        std::slice::from_ref(&system),
        &known,
        "local",
        &settle("arm"),
    );
    assert_eq!(places(&placed)["A"], "arm/main");
    assert_eq!(placed.desired.nodes["arm"].systems[0].generation, 7);
    assert_eq!(placed.notes["s"], ["host arm.robot.example is node arm: A"]);
    let placed = place_settled(
        std::slice::from_ref(&system),
        &nodes(),
        "local",
        &settle("local"),
    );
    assert_eq!(places(&placed)["A"], "local/main");
    assert_eq!(places(&placed)["B"], "arm/main", "a named node wins");
    assert!(placed.notes["s"][0].contains("apply again to move"));
    let gone = StoredSystem {
        deleting: true,
        ..system
    };
    let placed = place_settled(&[gone], &nodes(), "local", &settle("local"));
    assert!(placed.desired.nodes["leg"].systems[0].components.is_empty());
}

#[test]
fn the_generation_ages_a_spec_but_not_the_text_of_a_part() {
    let system = system("s", json!([{"instance": "A", "type": "T"}]));
    let at = |generation| {
        let settled = Settled {
            generation,
            ..Settled::default()
        };
        let settled = BTreeMap::from([("uid-s".to_owned(), settled)]);
        let mut placed = place_settled(std::slice::from_ref(&system), &nodes(), "local", &settled);
        placed.desired.nodes.remove("local").unwrap()
    };
    assert_ne!(digest(&at(1)), digest(&at(2)));
    assert_eq!(at(1).systems[0].digest(), at(2).systems[0].digest());
    assert_eq!(at(1).systems[0].digest(), at(0).systems[0].digest());
}

#[test]
fn where_a_component_may_still_run_is_in_its_nodes_spec_and_not_in_the_text_of_its_part() {
    let components = json!([{"instance": "A", "type": "T"}, {"instance": "B", "type": "T"}]);
    let system = system("s", components);
    let left = |left: &[(&str, &[&str])]| {
        let left = left.iter().map(|(instance, nodes)| {
            let nodes = nodes.iter().map(|node| (*node).to_owned());
            ((*instance).to_owned(), nodes.collect())
        });
        let settled = Settled {
            left: left.collect(),
            ..Settled::default()
        };
        let settled = BTreeMap::from([("uid-s".to_owned(), settled)]);
        let mut placed = place_settled(std::slice::from_ref(&system), &nodes(), "local", &settled);
        placed.desired.nodes.remove("local").unwrap()
    };
    let (settled, may) = (left(&[]), left(&[("A", &["arm", "leg"]), ("C", &["arm"])]));
    let part = &may.systems[0];
    assert_eq!(
        serde_json::to_value(&part.elsewhere).unwrap(),
        json!({"A": {"node": "arm", "required": true}})
    );
    assert_ne!(digest(&settled), digest(&may));
    assert_eq!(settled.systems[0].digest(), part.digest());
    assert_eq!(settled.systems[0], part.settled());
    assert_eq!(settled, left(&[("A", &["local"])]));
}
