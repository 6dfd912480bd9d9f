//! What a person changes by hand in a running system, and what becomes of it.

use std::time::Duration;

use rts_tests::{Profile, Stack};
use serde_json::Value;

fn status<'a>(items: &'a [Value], name: &str) -> &'a Value {
    let found = items.iter().find(|item| item["metadata"]["name"] == name);
    found.map_or(&Value::Null, |item| &item["status"])
}

fn is(items: &[Value], name: &str, state: &str) -> bool {
    status(items, name)["state"] == state
}

fn gain(items: &[Value]) -> &Value {
    &status(items, "middle")["configuration"]["sets"]["default"]["gain"]
}

/// Source → middle → sink in three processes, all with one policy for drift.
fn three(policy: &str) -> Profile {
    Profile::new("three")
        .component("source", "SineSource")
        .with("manager", "a")
        .with("drift", policy)
        .component("middle", "LowPassFilter")
        .with("manager", "b")
        .with("drift", policy)
        .parameter("gain", "1.0")
        .component("sink", "Printer")
        .with("manager", "c")
        .with("drift", policy)
        .connect("source.out", "middle.in")
        .connect("middle.out", "sink.in")
}

fn applied(stack: &Stack, policy: &str) -> String {
    let file = stack.write("three.xml", three(policy).xml());
    let file = file.to_string_lossy().into_owned();
    stack.expect(0, &["apply", &file]);
    file
}

/// One change of each kind.
fn change_by_hand(stack: &Stack) {
    stack.expect(0, &["conf", "middle", "set", "gain", "2.0"]);
    stack.expect(0, &["deactivate", "sink"]);
    stack.expect(0, &["disconnect", "source.out", "middle.in"]);
    stack.expect(0, &["connect", "source.out", "sink.in"]);
}

const OWN: &str = "source.out-middle.in";
const EXTRA: &str = "source.out-sink.in";

#[test]
fn what_was_changed_by_hand_is_put_back() {
    let stack = Stack::new();
    let file = applied(&stack, "repair");
    let before = stack.witness();
    change_by_hand(&stack);
    stack.until("components", "all is as written", |components| {
        gain(components) == "1.0" && is(components, "sink", "Active")
    });
    stack.until("connectors", "wired as written", |connectors| {
        is(connectors, OWN, "Connected") && status(connectors, EXTRA).is_null()
    });
    stack.expect(0, &["diff", &file]);
    let after = stack.witness();
    for name in ["source", "middle", "sink"] {
        assert_eq!(
            before.of(name).info.incarnation,
            after.of(name).info.incarnation
        );
    }
    let events = stack.expect(0, &["events"]).out;
    for reason in ["ChangedByHand", "Drifted", "DriftRepaired"] {
        assert!(events.contains(reason), "no {reason} in {events}");
    }
    stack.leaves_nothing();
}

#[test]
fn what_is_to_be_ignored_stays_whoever_dies() {
    let stack = Stack::new();
    let file = applied(&stack, "ignore");
    change_by_hand(&stack);
    let stays = || {
        let components = stack.get("components");
        assert_eq!(gain(&components), "2.0", "{components:#?}");
        assert!(is(&components, "sink", "Inactive"), "{components:#?}");
        let connectors = stack.get("connectors");
        assert!(is(&connectors, EXTRA, "Connected"), "{connectors:#?}");
        assert!(!is(&connectors, OWN, "Connected"), "{connectors:#?}");
    };
    stays();
    // It is told, and is no difference.
    let diff = stack.expect(0, &["diff", &file]).out;
    for word in ["gain", "ignore", "source.out-sink.in", "component/sink"] {
        assert!(diff.contains(word), "no {word} in {diff}");
    }
    let system = stack.named("systems", "three");
    let drifted = system["status"]["conditions"]
        .as_array()
        .expect("conditions");
    let drifted = drifted.iter().find(|c| c["type"] == "Drifted");
    assert_eq!(drifted.expect("a condition")["status"], "True");
    // An agent alone heals, and heals this not.
    stack.kill_9("rts-controller");
    stack.kill_9("rts-agent");
    std::thread::sleep(Duration::from_secs(5));
    stack.expect(0, &["up"]);
    std::thread::sleep(Duration::from_secs(1));
    stays();
    // The same file again changes nothing either; another wish does.
    stack.expect(0, &["conf", "middle", "get", "gain"]);
    let changed = three("ignore")
        .xml()
        .replace(r#"rts:data="1.0""#, r#"rts:data="3.0""#);
    let changed = stack.write("changed.xml", changed);
    stack.rtsctl(&["apply", "--timeout", "5s", &changed.to_string_lossy()]);
    stack.until("components", "the new value is set", |components| {
        gain(components) == "3.0"
    });
    // A person ends what a person began.
    stack.expect(0, &["activate", "sink"]);
    stack.expect(0, &["disconnect", "source.out", "sink.in"]);
    stack.expect(0, &["connect", "source.out", "middle.in"]);
    stack.until("systems", "nothing is left to tell", |systems| {
        status(systems, "three")["healthy"] == true
    });
    stack.expect(0, &["diff", &changed.to_string_lossy()]);
    stack.leaves_nothing();
}

#[test]
fn what_is_to_be_adopted_becomes_the_wish_and_can_be_exported() {
    let stack = Stack::new();
    let file = applied(&stack, "adopt");
    let before = stack.witness();
    // As it was applied, an export is no change.
    let as_applied = stack.expect(0, &["export", "three"]).out;
    let as_applied = stack.write("as-applied.xml", as_applied);
    let said = stack.expect(0, &["apply", &as_applied.to_string_lossy()]);
    assert_eq!(said.out.trim(), "no changes");
    stack.expect(0, &["conf", "middle", "set", "gain", "2.0"]);
    stack.expect(0, &["disconnect", "source.out", "middle.in"]);
    stack.expect(0, &["connect", "source.out", "sink.in"]);
    stack.until("systems", "it is stored", |systems| {
        let system = systems.iter().find(|s| s["metadata"]["name"] == "three");
        let spec = &system.expect("the system")["spec"];
        let names: Vec<_> = spec["connectors"]
            .as_array()
            .expect("connectors")
            .iter()
            .map(|c| c["name"].as_str())
            .collect();
        let gain = &spec["components"][1]["configuration"]["sets"]["default"]["gain"];
        gain == "2.0" && !names.contains(&Some(OWN)) && names.contains(&Some(EXTRA))
    });
    stack.until("connectors", "the wiring stays", |connectors| {
        is(connectors, EXTRA, "Connected") && status(connectors, OWN).is_null()
    });
    assert_eq!(gain(&stack.get("components")), "2.0");
    let after = stack.witness();
    for name in ["source", "middle", "sink"] {
        assert_eq!(
            before.of(name).info.incarnation,
            after.of(name).info.incarnation
        );
    }
    // The next change counts against the new wish.
    stack.expect(0, &["conf", "middle", "set", "gain", "2.5"]);
    stack.until("systems", "it is stored, too", |systems| {
        let system = systems.iter().find(|s| s["metadata"]["name"] == "three");
        let components = &system.expect("the system")["spec"]["components"];
        components[1]["configuration"]["sets"]["default"]["gain"] == "2.5"
    });
    let exported = stack
        .home()
        .parent()
        .expect("a folder")
        .join("exported.xml");
    stack.expect(
        0,
        &["export", "three", "--out", &exported.to_string_lossy()],
    );
    let said = stack.expect(0, &["apply", &exported.to_string_lossy()]);
    assert_eq!(said.out.trim(), "no changes");
    stack.expect(1, &["diff", &file]);
    stack.leaves_nothing();
}
