//! The verbs that change by hand what runs: what they do, what they say, and what becomes of it.

#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

mod support;

use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::Value;
use support::Stack;

/// Longest time for what the controller does by itself.
const SOON: Duration = Duration::from_secs(20);
/// What is changed by hand stays.
const IGNORE: &str = "\
apiVersion: rtsctl.dev/v1
kind: Deployment
metadata: {name: ignore}
spec:
  components:
    Sine0: {drift: ignore}
    Filter0: {drift: ignore}
    Printer0: {drift: ignore}
";

/// The hello system runs, with the policy `ignore` when that is wanted.
fn hello(ignore: bool) -> Stack {
    let stack = Stack::up();
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("../manifests/hello/system.xml");
    std::fs::copy(manifest, stack.folder.path().join("hello.xml")).unwrap();
    std::fs::write(stack.folder.path().join("ignore.yaml"), IGNORE).unwrap();
    let overlay: &[&str] = if ignore { &["-f", "ignore.yaml"] } else { &[] };
    says(
        &stack,
        0,
        &[&["apply", "-f", "hello.xml"], overlay].concat(),
    );
    stack
}

/// Runs, which must end with a code; gives stdout and stderr.
#[track_caller]
fn says(stack: &Stack, code: i32, args: &[&str]) -> (String, String) {
    let (ended, out, err) = stack.run(args);
    assert_eq!(ended, code, "rtsctl {args:?}: {out}{err}");
    (out, err)
}

#[track_caller]
fn prints(stack: &Stack, args: &[&str], wanted: &str) {
    let (out, err) = says(stack, 0, args);
    assert_eq!(out.trim_end(), wanted, "{err}");
}

fn object(stack: &Stack, kind: &str, name: &str) -> Value {
    let (out, _) = says(stack, 0, &["get", kind, name, "-o", "json"]);
    serde_json::from_str(&out).unwrap()
}

/// Waits until an object is as it should be.
#[track_caller]
fn until(stack: &Stack, kind: &str, name: &str, done: impl Fn(&Value) -> bool) {
    let end = Instant::now() + SOON;
    loop {
        let object = object(stack, kind, name);
        if done(&object) {
            return;
        }
        assert!(Instant::now() < end, "{object:#}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn states_are_changed_by_hand_and_stay_when_drift_is_ignored() {
    let stack = hello(true);
    prints(
        &stack,
        &["deactivate", "Filter0", "--dry-run"],
        "component/Filter0 would be deactivated",
    );
    assert_eq!(
        object(&stack, "component", "Filter0")["status"]["state"],
        "Active"
    );

    let (out, err) = says(&stack, 0, &["deactivate", "Filter0"]);
    assert_eq!(out, "component/Filter0 deactivated\n");
    assert!(err.contains("note: system hello leaves it so"), "{err}");
    prints(
        &stack,
        &["deactivate", "local/Filter0"],
        "component/Filter0 is Inactive already",
    );
    until(&stack, "component", "Filter0", |c| {
        c["status"]["state"] == "Inactive" && c["status"]["drift"] == true
    });
    let (page, _) = says(&stack, 0, &["describe", "component/Filter0"]);
    assert!(page.contains("was deactivated by hand"), "{page}");
    assert!(page.contains("By hand:"), "{page}");
    let (table, err) = says(&stack, 0, &["get", "components", "-o", "wide"]);
    assert!(table.contains("DRIFT"), "{table}");
    assert!(
        err.contains("1 component was changed by hand (drift): Filter0"),
        "{err}"
    );

    let (out, err) = says(&stack, 2, &["activate", "component/Filter0", "Fitler0"]);
    assert_eq!(out, "", "nothing is done if a name is wrong");
    assert!(err.contains("did you mean `Filter0`?"), "{err}");
    let (_, err) = says(
        &stack,
        5,
        &["apply", "-f", "hello.xml", "-f", "ignore.yaml"],
    );
    assert!(
        err.contains("until `rtsctl activate Filter0`") && !err.contains("goes on trying"),
        "{err}"
    );
    prints(
        &stack,
        &["activate", "Filter0"],
        "component/Filter0 activated",
    );
    until(&stack, "component", "Filter0", |c| {
        c["status"]["state"] == "Active" && c["status"]["drift"] == false
    });
    let (_, err) = says(&stack, 7, &["reset", "Filter0"]);
    assert!(err.contains("there is nothing to reset"), "{err}");
}

#[test]
fn values_are_set_by_hand_and_exported() {
    let stack = hello(true);
    prints(&stack, &["conf", "Filter0", "get", "gain"], "1.0");
    let set = "component/Filter0 configured: default.gain: 1.0 -> -2.5";
    prints(&stack, &["conf", "Filter0", "set", "gain", "-2.5"], set);
    prints(&stack, &["conf", "Filter0", "get", "gain"], "-2.5");
    prints(
        &stack,
        &["conf", "Filter0", "set", "gain=-2.5"],
        "component/Filter0 is configured so already",
    );
    let (out, _) = says(&stack, 0, &["conf", "Filter0"]);
    insta::assert_snapshot!(out, @r"
    SET       PARAMETER  VALUE  WANTED
    default*  alpha      0.1    -
    default*  gain       -2.5   1.0
    ");
    let (out, _) = says(&stack, 0, &["conf", "Filter0", "-o", "json"]);
    let conf: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(conf["sets"]["default"]["gain"], "-2.5");
    let yaml = ["conf", "Filter0", "set", "gain", "3", "-o", "yaml"];
    let (_, err) = says(&stack, 2, &yaml);
    assert!(err.contains("--output is for what is shown"), "{err}");
    let (_, err) = says(&stack, 2, &["conf", "Filter0", "get", "gian"]);
    assert!(err.contains("did you mean `gain`?"), "{err}");
    for wrong in [["set", "gian=1"].as_slice(), &["act", "fast"]] {
        let (_, err) = says(&stack, 2, &[&["conf", "Filter0"], wrong].concat());
        assert!(err.contains("cannot configure component/Filter0"), "{err}");
    }

    prints(
        &stack,
        &["export", "hello", "--out", "again.xml"],
        "system/hello exported to again.xml",
    );
    let now = ["diff", "-f", "hello.xml", "-f", "ignore.yaml"];
    let (plan, _) = says(&stack, 0, &now);
    assert!(plan.contains("drift: component/Filter0"), "{plan}");
    says(&stack, 0, &["apply", "again.xml"]);
    until(&stack, "component", "Filter0", |c| {
        c["status"]["drift"] == false
            && c["spec"]["configuration"]["sets"]["default"]["gain"] == "-2.5"
    });
    let (plan, _) = says(&stack, 0, &["diff", "again.xml"]);
    assert_eq!(plan, "Plan: 0 to add, 0 to change, 0 to remove\n");
}

#[test]
fn connectors_are_made_and_removed_by_hand() {
    let stack = hello(true);
    let name = "Sine0.out-Filter0.in";
    let ends = ["Sine0.out", "Filter0.in"];
    let target = format!("connector/{name}");
    prints(
        &stack,
        &["connect", ends[0], ends[1]],
        &format!("{target} is connected already"),
    );
    prints(
        &stack,
        &["disconnect", ends[1], ends[0]],
        &format!("{target} disconnected"),
    );
    until(&stack, "connector", name, |c| {
        c["status"]["state"] == "Disconnected"
    });
    prints(
        &stack,
        &["connect", ends[0], ends[1]],
        &format!("{target} connected"),
    );
    until(&stack, "connector", name, |c| {
        c["status"]["state"] == "Connected"
    });

    let extra = ["connect", "Sine0.out", "Printer0.in", "--name", "spy"];
    prints(&stack, &extra, "connector/spy connected");
    until(&stack, "connector", "spy", |c| c["status"]["drift"] == true);
    let (xml, _) = says(&stack, 0, &["export", "hello"]);
    assert!(xml.contains("Printer0.in"), "{xml}");
    prints(
        &stack,
        &["disconnect", "hello/spy"],
        "connector/spy disconnected",
    );
    let (_, err) = says(&stack, 2, &["disconnect", "Sine0.out", "Printer0.in"]);
    assert!(err.contains("there is no connector between"), "{err}");
    let (_, err) = says(&stack, 2, &["connect", "Sine0", "Filter0.in"]);
    assert!(err.contains("names no port"), "{err}");
}

#[test]
fn what_is_changed_by_hand_is_put_back_and_that_is_said() {
    let stack = hello(false);
    let (_, err) = says(&stack, 0, &["conf", "Filter0", "set", "gain", "9"]);
    assert!(
        err.starts_with("warning: system hello repairs drift"),
        "{err}"
    );
    until(&stack, "component", "Filter0", |c| {
        c["status"]["configuration"]["sets"]["default"]["gain"] == "1.0"
    });
    let (_, err) = says(&stack, 0, &["deactivate", "Filter0"]);
    assert!(err.starts_with("warning: "), "{err}");
    until(&stack, "component", "Filter0", |c| {
        c["status"]["state"] == "Active"
    });
    let (_, err) = says(&stack, 0, &["disconnect", "Sine0.out", "Filter0.in"]);
    assert!(
        err.starts_with("warning: system hello repairs drift"),
        "{err}"
    );
    until(&stack, "connector", "Sine0.out-Filter0.in", |c| {
        c["status"]["state"] == "Connected" && c["status"]["drift"] == false
    });
}

#[test]
fn a_component_that_refuses_is_5_and_can_be_reset() {
    let stack = Stack::up();
    let create = "Misbehaving?instance_name=F0&fault=error-activate";
    says(&stack, 0, &["manager", "create", create]);
    let (_, err) = says(&stack, 5, &["activate", "F0"]);
    assert!(err.contains("told to fail on_activated"), "{err}");
    let (_, err) = says(&stack, 7, &["activate", "F0"]);
    assert!(err.contains("rtsctl reset F0"), "{err}");
    until(&stack, "component", "F0", |c| {
        c["status"]["state"] == "Error"
    });
    prints(
        &stack,
        &["reset", "F0", "--dry-run"],
        "component/F0 would be reset",
    );
    prints(&stack, &["reset", "F0"], "component/F0 reset");
    let set = "component/F0 configured: default.fault: error-activate -> none";
    prints(&stack, &["conf", "F0", "set", "fault", "none"], set);
    prints(&stack, &["activate", "F0"], "component/F0 activated");
    stack.kill_agent();
    says(&stack, 4, &["deactivate", "F0"]);
}

#[test]
fn a_component_that_is_driven_from_outside_runs_as_many_cycles_as_it_is_ticked() {
    let stack = Stack::up();
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("../manifests/hello/system.xml");
    let text = std::fs::read_to_string(manifest).unwrap();
    // The source is driven from outside, the filter by what the source sends.
    let kinds = text.replacen("PERIODIC", "OTHER", 1);
    let kinds = kinds.replacen("PERIODIC", "EVENT_DRIVEN", 1);
    std::fs::write(stack.folder.path().join("driven.xml"), kinds).unwrap();
    says(&stack, 0, &["apply", "driven.xml"]);
    assert_eq!(
        object(&stack, "component", "Sine0")["status"]["executions"],
        0
    );
    prints(
        &stack,
        &["tick", "Sine0", "-n", "2", "--dry-run"],
        "component/Sine0 would be ticked",
    );
    for _ in 0..2 {
        prints(
            &stack,
            &["tick", "Sine0", "-n", "2"],
            "component/Sine0 ticked",
        );
    }
    until(&stack, "component", "Sine0", |c| {
        c["status"]["executions"] == 4
    });
    until(&stack, "connector", "Sine0.out-Filter0.in", |c| {
        c["status"]["samplesReceived"] == 4
    });
    until(&stack, "component", "Filter0", |c| {
        (1..=4).contains(&c["status"]["executions"].as_u64().unwrap())
    });
    let (page, _) = says(&stack, 0, &["describe", "component", "Printer0"]);
    for line in ["Execution time:", "Jitter:", "Overruns:"] {
        assert!(page.contains(line), "{page}");
    }
    let (_, err) = says(&stack, 7, &["tick", "Filter0"]);
    assert!(
        err.contains("the execution context of Filter0 is event-driven"),
        "{err}"
    );
}
