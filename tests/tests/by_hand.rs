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
