//! Smoke tests that fail: the exit code, and that the report names who is to blame.

use rts_tests::{Stack, root};
use serde_json::Value;

use super::{HELLO, MISBEHAVING, Smoked, smoke};

/// Smoke test of the system with a component that misbehaves.
#[track_caller]
fn misbehaves(code: i32, parameters: &str, arguments: &[&str]) -> Smoked {
    with("Misbehaving0", code, parameters, arguments)
}

/// The same with other parameters of any component.
#[track_caller]
fn with(component: &str, code: i32, parameters: &str, arguments: &[&str]) -> Smoked {
    let stack = Stack::new();
    let overlay = stack.write(
        "fault.yaml",
        format!(
            "apiVersion: rtsctl.dev/v1\nkind: Deployment\nspec: {{components: {{{component}: {{startTimeout: 1s, \
             configuration: {{sets: {{default: {{{parameters}}}}}}}}}}}}}\n"
        ),
    );
    let overlay = overlay.to_str().expect("a path");
    let arguments = [&[MISBEHAVING, "-f", overlay, "-o", "json"], arguments].concat();
    smoke(&stack, code, &arguments)
}

/// What of a report is the same each time: how the checks ended, and the words of the first log.
fn story(smoked: &Smoked) -> String {
    let status = &smoked.document()["status"];
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let mut story = format!("exit {}\n", status["exitCode"]);
    for check in status["checks"].as_array().expect("checks") {
        let (name, result) = (text(&check["name"]), text(&check["result"]));
        if result != "failed" {
            story.push_str(&format!("{name}: {result}\n"));
            continue;
        }
        story.push_str(&format!("{name}: failed: {}\n", text(&check["message"])));
        for component in check["components"].as_array().expect("components") {
            story.push_str(&format!("  component {}\n", text(component)));
        }
    }
    let log = &status["evidence"]["logs"][0];
    if log["of"].is_string() {
        story.push_str(&format!("log of {}:\n", text(&log["of"])));
        for line in log["lines"].as_array().expect("lines") {
            let line = text(line);
            let (_, words) = line.split_once(' ').expect("a time, then words");
            story.push_str(&format!("  {words}\n"));
        }
    }
    story
}

/// Numbers of processes are others each time.
fn without_pids(text: &str) -> String {
    let mut parts = text.split("(pid ");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| {
        text + "(pid N" + part.trim_start_matches(|c: char| c.is_ascii_digit())
    })
}

#[track_caller]
fn has_evidence(smoked: &Smoked) {
    let evidence = &smoked.document()["status"]["evidence"];
    assert!(
        !evidence["plan"]["steps"]
            .as_array()
            .expect("steps")
            .is_empty()
    );
    let events = evidence["events"].as_array().expect("events");
    let about = |event: &Value| event["spec"]["object"] == "component/Misbehaving0";
    assert!(events.iter().any(about), "{events:#?}");
}

#[test]
fn a_component_that_never_activates() {
    let smoked = misbehaves(1, "fault: error-activate", &[]);
    insta::assert_snapshot!(story(&smoked));
    has_evidence(&smoked);
}

#[test]
fn a_component_that_crashes_again_and_again() {
    // Late enough for the checks before it, on a busy machine too.
    let fault = "fault: crash-later, after: 2.5";
    let smoked = misbehaves(1, fault, &["--no-faults", "--steady", "4s"]);
    insta::assert_snapshot!(story(&smoked));
    has_evidence(&smoked);
}

#[test]
fn a_component_that_sends_nothing() {
    let smoked = with("Source0", 6, "path: /dev/null", &["--timeout", "2s"]);
    insta::assert_snapshot!(story(&smoked));
}

#[test]
fn a_component_that_leaves_processes_behind() {
    let stack = Stack::new();
    let overlay = "apiVersion: rtsctl.dev/v1\nkind: Deployment\nspec: {components: {Misbehaving0: {configuration: {sets: {default: {fault: grandchildren}}}}}}\n";
    let overlay = stack.write("fault.yaml", overlay);
    let overlay = overlay.to_str().expect("a path");
    let mut command = super::command(
        &stack,
        &[MISBEHAVING, "-f", overlay, "-o", "json", "--no-faults"],
    );
    // A control group would hold them.
    command.env(rts_host::cgroup::VARIABLE, "off");
    let smoked = super::ended(command.spawn().expect("rtsctl starts"));
    assert_eq!(smoked.code, 1, "{smoked:#?}");
    super::leaves_nothing(&smoked.home());
    insta::assert_snapshot!(without_pids(&story(&smoked)));
}

/// The text for people, of a type that is not there.
#[test]
fn a_component_whose_module_is_not_there() {
    let stack = Stack::new();
    let profile = std::fs::read_to_string(root().join(HELLO)).expect("the manifest");
    let profile = stack.write("system.xml", profile.replace(":Printer:", ":Plotter:"));
    let smoked = smoke(&stack, 3, &[profile.to_str().expect("a path")]);
    let text = smoked
        .out
        .replace(&profile.display().to_string(), "system.xml");
    assert!(text.contains("cannot plan system/hello: 1 error"), "{text}");
    assert!(
        text.contains("component Printer0: no module of type Plotter on node local"),
        "{text}"
    );
    assert!(text.contains("system.xml:43:17"), "{text}");
    assert!(
        text.ends_with("s)\n") && text.contains("1 of 3 checks failed: apply"),
        "{text}"
    );
}

/// Ports of two types: nothing is started for it.
#[test]
fn a_connector_between_two_types() {
    let stack = Stack::new();
    let said = stack.expect(3, &["smoke", "manifests/invalid/data-type-mismatch.xml"]);
    assert!(said.err.contains("error[data-type-mismatch]"), "{said:#?}");
    assert!(!said.err.contains("rts-smoke"), "{said:#?}");
}

#[test]
fn a_start_that_takes_too_long() {
    let fault = "fault: slow-activate, seconds: 0.5";
    let budgets = [
        "--no-faults",
        "--budget",
        "apply=250ms",
        "--budget",
        "total=1m",
    ];
    let smoked = misbehaves(1, fault, &budgets);
    let checks = &smoked.document()["status"]["checks"];
    let apply = &checks[1];
    assert_eq!(apply["result"], "failed");
    let message = apply["message"].as_str().expect("a message");
    assert!(message.ends_with("and its budget is 0.25 s"), "{message}");
    let path = apply["details"].as_array().expect("details").iter();
    let slow = path.filter_map(Value::as_str);
    let slow: Vec<_> = slow
        .filter(|line| line.contains(" Activate component/Misbehaving0 ("))
        .collect();
    assert_eq!(slow.len(), 1, "{apply:#?}");
    assert_eq!(
        (&checks[9]["name"], &checks[9]["result"]),
        (&"total".into(), &"passed".into())
    );
}

/// Files that cannot be written are told, after the report.
#[test]
fn a_report_that_cannot_be_written() {
    let stack = Stack::new();
    let arguments = [
        HELLO,
        "--no-faults",
        "--steady",
        "10ms",
        "--junit",
        "/nowhere/smoke.xml",
    ];
    let smoked = smoke(&stack, 2, &arguments);
    assert!(smoked.out.contains("9 checks passed") || smoked.out.contains("8 checks passed"));
    assert!(
        smoked.err.contains("cannot write /nowhere/smoke.xml"),
        "{smoked:#?}"
    );
}
