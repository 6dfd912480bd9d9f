//! The manager service for people: what is made by hand is shown as drift and left alone.

mod ports;

use rts_tests::Stack;

const HELLO: &str = "manifests/hello/system.xml";

#[test]
fn a_component_made_by_hand_is_drift_and_goes_by_hand() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    let said = stack.expect(0, &["manager", "list"]);
    assert!(
        said.out.contains("hello.main") && said.out.contains("hello.Printer0"),
        "{said:#?}"
    );

    stack.expect(0, &["manager", "load", "hello.main", "ConfigSample"]);
    let said = stack.expect(0, &["manager", "factories", "hello.main"]);
    assert!(
        said.out.contains("ConfigSample") && said.out.contains("SineSource"),
        "{said:#?}"
    );
    stack.expect(
        0,
        &[
            "manager",
            "create",
            "ConfigSample?instance_name=Hand0&int_param0=42&manager=hello.main",
        ],
    );
    let hand = stack.named("components", "Hand0");
    assert_eq!(hand["status"]["drift"], true);
    assert_eq!(hand["status"]["state"], "Inactive");
    assert_eq!(
        hand["status"]["configuration"]["sets"]["default"]["int_param0"],
        "42"
    );
    let said = stack.expect(0, &["diff", HELLO]);
    assert!(
        format!("{}{}", said.out, said.err).contains("Hand0"),
        "diff shows the drift: {said:#?}"
    );
    let said = stack.expect(0, &["apply", HELLO]);
    assert!(said.out.contains("no changes"), "{said:#?}");
    assert_eq!(
        stack.named("components", "Hand0")["metadata"]["name"],
        "Hand0",
        "it is left alone"
    );

    stack.expect(
        0,
        &[
            "manager",
            "create",
            "ConfigSample?instance_name=Hand1&manager=bench",
        ],
    );
    assert_eq!(
        stack.named("components", "Hand1")["status"]["manager"],
        "bench"
    );
    assert_eq!(stack.get("managers").len(), 3);
    stack.expect(
        7,
        &[
            "manager",
            "create",
            "ConfigSample?instance_name=Hand1&manager=bench",
        ],
    );
    stack.expect(7, &["manager", "delete", "Sine0"]);
    stack.expect(0, &["manager", "delete", "Hand0"]);
    stack.expect(0, &["manager", "unload", "hello.main", "ConfigSample"]);
    assert_eq!(stack.get("components").len(), 4);

    stack.expect(0, &["teardown", "hello", "--yes"]);
    assert_eq!(
        stack.get("components").len(),
        1,
        "a manager that a person started outlives a system's end"
    );
    stack.leaves_nothing();
}

#[test]
fn a_composite_is_shown_with_the_state_of_its_members_and_goes_with_them() {
    let stack = Stack::new();
    stack.expect(0, &["apply", "manifests/hello/composite.xml"]);
    let composite = stack.named("components", "Loop0");
    assert_eq!(composite["status"]["state"], "Active");
    assert_eq!(
        composite["spec"]["composite"],
        serde_json::json!({"kind": "PeriodicStateShared", "members": ["Sine0", "Filter0"]})
    );
    let filter = stack.named("components", "Filter0");
    assert_eq!(filter["status"]["executionContext"]["name"], "Loop0");
    assert_eq!(filter["status"]["executionContext"]["order"], 20);
    assert_eq!(
        filter["status"]["runsWith"],
        serde_json::json!(["Sine0", "Filter0"])
    );
    assert_eq!(filter["status"]["rate"], 50.0, "that of the composite");
    let said = stack.expect(0, &["describe", "component", "Filter0"]);
    assert!(said.out.contains("Loop0 (order 20)"), "{said:#?}");
    let connector = stack.named("connectors", "Filter0.out-Printer0.in");
    assert_eq!(connector["status"]["state"], "Connected");
    // Nothing is to be done for it.
    let said = stack.expect(0, &["apply", "manifests/hello/composite.xml"]);
    assert!(said.out.contains("no changes"), "{said:#?}");

    let said = stack.expect(0, &["deactivate", "--dry-run", "Loop0"]);
    assert!(
        said.out.contains("component/Sine0") && said.out.contains("component/Filter0"),
        "{said:#?}"
    );
    // What is exported is the same system again.
    let exported = stack.expect(0, &["export", "composite"]).out;
    let file = stack.home().join("exported.xml");
    std::fs::write(&file, exported).unwrap();
    let said = stack.expect(0, &["apply", &file.display().to_string()]);
    assert!(said.out.contains("no changes"), "{said:#?}");
}
