//! The hello system: applied, seen to run, changed, taken down.

mod smoke;

use std::time::Duration;

use rts_tests::{Stack, processes_of};
use serde_json::Value;

const HELLO: &str = "manifests/hello/system.xml";
const CHANGED: &str = "manifests/hello/changed.xml";

fn pid(stack: &Stack, component: &str) -> u64 {
    stack.named("components", component)["status"]["pid"]
        .as_u64()
        .expect("a pid")
}

fn incarnations(stack: &Stack) -> Vec<(String, String)> {
    let text = |v: &Value| v.as_str().expect("text").to_owned();
    let items = stack.get("components");
    items
        .iter()
        .map(|c| {
            (
                text(&c["metadata"]["name"]),
                text(&c["status"]["incarnation"]),
            )
        })
        .collect()
}

fn flowing(connectors: &[Value]) -> bool {
    connectors.len() == 2
        && connectors
            .iter()
            .all(|c| c["status"]["samplesReceived"].as_u64() >= Some(3))
}

#[test]
fn apply_makes_it_run_and_a_second_apply_changes_nothing() {
    let stack = Stack::new();
    stack.expect(0, &["up"]);
    let said = stack.expect(0, &["apply", "--timings", HELLO]);
    assert!(
        said.err.contains("converged") || said.out.contains("converged"),
        "{said:#?}"
    );
    // Where the time went: a span of each program.
    for span in ["critical path: ", "read files", "decide", "Activate"] {
        assert!(said.out.contains(span), "{span}: {said:#?}");
    }

    let components = stack.get("components");
    assert_eq!(components.len(), 3);
    for component in &components {
        assert_eq!(component["status"]["state"], "Active");
        assert_eq!(component["status"]["node"], "local");
        assert_eq!(component["status"]["restarts"], 0);
        assert_eq!(component["spec"]["system"], "hello");
    }
    assert_eq!(
        pid(&stack, "Sine0"),
        pid(&stack, "Filter0"),
        "one manager, one process"
    );
    assert_ne!(
        pid(&stack, "Sine0"),
        pid(&stack, "Printer0"),
        "isolated: a process of its own"
    );

    let connectors = stack.until("connectors", "samples arrive on both connectors", flowing);
    for connector in connectors {
        assert_eq!(connector["status"]["state"], "Connected");
        assert!(
            connector["status"]["samplesReceived"].as_u64()
                <= connector["status"]["samplesSent"].as_u64()
        );
    }
    let transport = |name: &str| stack.named("connectors", name)["status"]["transport"].clone();
    assert_eq!(transport("Sine0.out-Filter0.in"), "direct");
    assert_eq!(transport("Filter0.out-Printer0.in"), "shm");

    let before = incarnations(&stack);
    let said = stack.expect(0, &["apply", HELLO]);
    assert!(said.out.contains("no changes"), "{said:#?}");
    assert_eq!(incarnations(&stack), before, "nothing restarts");

    let picture = stack.expect(0, &["export", "hello", "-o", "svg"]).out;
    assert!(picture.contains("Sine0: SineSource, Active"), "{picture}");
    let log = stack.expect(0, &["logs", "Printer0"]);
    assert!(log.out.lines().count() >= 2, "{log:#?}");

    stack.expect(0, &["teardown", "hello", "--yes"]);
    assert_eq!(stack.get("components").len(), 0);
    assert_eq!(stack.get("managers").len(), 0);
    assert_eq!(stack.get("systems").len(), 0);
    let left = processes_of(&stack.home().join("run/local"));
    assert!(left.is_empty(), "manager processes are left: {left:?}");
    stack.leaves_nothing();
}

/// Two overlays in their order, beside a profile that is not touched.
#[test]
fn overlays_are_laid_over_a_profile_one_after_the_other() {
    let stack = Stack::new();
    let [lab, bench] = ["lab", "bench"].map(|name| format!("manifests/hello/{name}.yaml"));
    let files = ["-f", HELLO, "-f", &lab, "-f", &bench];
    stack.expect(0, &[&["apply"], &files[..]].concat());
    let system = stack.named("systems", "hello");
    let policy = |index: usize| system["spec"]["components"][index]["policy"].clone();
    let manager = |name: &str| stack.named("components", name)["status"]["manager"].clone();
    assert_eq!(
        manager("Printer0"),
        "signal",
        "no longer in its own process"
    );
    assert_eq!(policy(2)["restart"], "always");
    assert_eq!(
        manager("Filter0"),
        "signal",
        "as the first says, and the second leaves"
    );
    assert_eq!(policy(1)["restart"], "on-failure");
    assert_eq!(policy(1)["resetOnError"], true);
    assert_eq!(policy(1)["startTimeoutMs"], 5000);
    let sine = stack.named("components", "Sine0");
    let values = &sine["spec"]["configuration"]["sets"]["default"];
    assert_eq!(
        (&values["amplitude"], &values["frequency"]),
        (&"1.0".into(), &"2.0".into())
    );
    let conf = stack.expect(0, &["conf", "Sine0", "get", "frequency"]);
    assert_eq!(conf.out.trim(), "2.0", "the component has it");
    let plan = stack.expect(0, &[&["apply"], &files[..]].concat());
    assert!(plan.out.contains("no changes"), "{plan:#?}");
    stack.leaves_nothing();
}

/// A circle through an order of an overlay is shown where the overlay closes it, and nothing is started.
#[test]
fn a_cycle_through_an_overlay_names_its_line() {
    let stack = Stack::new();
    let circle = stack.write(
        "circle.yaml",
        "apiVersion: rtsctl.dev/v1\nkind: Deployment\nspec:\n  order:\n    activation:\n      \
         - { component: Sine0, wait: 1ms }\n      - { component: Printer0, after: Sine0 }\n",
    );
    let said = stack.expect(3, &["apply", HELLO, "-f", circle.to_str().expect("a path")]);
    assert!(said.err.contains("circle.yaml:7:9"), "{said:#?}");
    assert!(
        said.err.contains("a cycle of Filter0, Printer0, Sine0"),
        "{said:#?}"
    );
    assert_eq!(stack.get("components").len(), 0);
    stack.leaves_nothing();
}

#[test]
fn the_yaml_twin_is_the_same_system() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    let before = incarnations(&stack);
    let said = stack.expect(0, &["apply", "manifests/hello/system.yaml"]);
    assert!(said.out.contains("no changes"), "{said:#?}");
    assert_eq!(incarnations(&stack), before);
    stack.leaves_nothing();
}

#[test]
fn a_set_up_of_rtc_conf_files_runs_as_a_system() {
    let stack = Stack::new();
    let (profile, overlay) = (stack.write("made.xml", ""), stack.write("made.yaml", ""));
    let (profile, overlay) = (profile.display().to_string(), overlay.display().to_string());
    let conf = |name: &str| format!("manifests/rtc_conf/conf/{name}");
    stack.expect(
        0,
        &[
            "convert",
            &conf("rtc_cpp.conf"),
            &conf("rtc_py.conf"),
            "--rtc",
            "manifests/rtc_conf/rtc",
            "--out",
            &profile,
            "--overlay",
            &overlay,
        ],
    );
    stack.expect(0, &["apply", &profile, "-f", &overlay]);
    for component in stack.get("components") {
        assert_eq!(component["status"]["state"], "Active");
        let manager = match component["metadata"]["name"].as_str() {
            Some("Printer0") => "manager_py",
            _ => "manager_cpp",
        };
        assert_eq!(component["status"]["manager"], manager);
    }
    let sine = stack.named("components", "Sine0");
    assert_eq!(sine["status"]["configuration"]["active"], "slow");
    stack.until("connectors", "samples arrive on both connectors", flowing);
    stack.leaves_nothing();
}

#[test]
fn diff_says_what_changes_and_apply_does_just_that() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    stack.until("connectors", "samples arrive", flowing);
    stack.expect(0, &["diff", HELLO]);
    let before = incarnations(&stack);
    let said = stack.expect(1, &["diff", CHANGED]);
    for word in ["Filter0", "gain", "Printer0", "hello.Printer0", "Plan:"] {
        assert!(
            said.out.contains(word),
            "diff says nothing of {word}: {said:#?}"
        );
    }
    assert_eq!(incarnations(&stack), before, "diff changes nothing");
    let plan = stack.expect(1, &["diff", CHANGED, "-o", "json"]);
    let plan: Value = serde_json::from_str(&plan.out).expect("JSON");
    assert!(plan["changes"].as_array().is_some_and(|c| !c.is_empty()));
    assert!(plan["steps"].as_array().is_some_and(|c| {
        c.iter()
            .all(|s| s["kind"].is_string() && s["needs"].is_array())
    }));
    assert!(plan["restarts"].as_array().is_some_and(|c| !c.is_empty()));

    let sine = pid(&stack, "Sine0");
    stack.expect(0, &["apply", CHANGED]);
    let same = |name: &str| {
        let at = |list: &[(String, String)]| {
            list.iter().find(|(n, _)| n == name).map(|(_, i)| i.clone())
        };
        at(&before) == at(&incarnations(&stack))
    };
    assert!(
        same("Sine0") && same("Filter0"),
        "values and rates are set in place"
    );
    assert!(!same("Printer0"), "a moved component is made again");
    assert_eq!(pid(&stack, "Sine0"), sine);
    assert_eq!(pid(&stack, "Printer0"), sine, "it moved into main");
    let filter = stack.named("components", "Filter0");
    assert_eq!(
        filter["status"]["configuration"]["sets"]["default"]["gain"],
        "2.0"
    );
    assert_eq!(stack.named("components", "Sine0")["status"]["rate"], 200.0);
    assert_eq!(stack.get("managers").len(), 1);
    stack.expect(0, &["diff", CHANGED]);
    stack.leaves_nothing();
}

#[test]
fn a_killed_manager_comes_back_and_nothing_else_is_touched() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    stack.until("connectors", "samples arrive", flowing);
    let sine = pid(&stack, "Sine0");
    let printer = pid(&stack, "Printer0");
    rts_tests::kill(printer.try_into().expect("a pid"));
    stack.until(
        "components",
        "Printer0 is Active again in a new process",
        |components| {
            let state = |c: &Value| {
                c["status"]["state"] == "Active" && c["status"]["pid"].as_u64() != Some(printer)
            };
            components
                .iter()
                .any(|c| c["metadata"]["name"] == "Printer0" && state(c))
        },
    );
    stack.until("connectors", "samples arrive again", flowing);
    assert_eq!(pid(&stack, "Sine0"), sine);
    assert_eq!(
        stack.named("components", "Printer0")["status"]["restarts"],
        1
    );
    assert_eq!(stack.named("components", "Sine0")["status"]["restarts"], 0);
    let events = stack.get("events");
    assert!(
        events.iter().any(|e| e["spec"]["reason"] == "ManagerDied"),
        "{events:#?}"
    );
    stack.leaves_nothing();
}

#[test]
fn two_stacks_run_side_by_side() {
    let (one, two) = (Stack::new(), Stack::new());
    one.expect(0, &["apply", HELLO]);
    two.expect(0, &["apply", HELLO]);
    one.expect(0, &["teardown", "hello", "--yes"]);
    assert_eq!(two.get("components").len(), 3);
    assert!(
        two.get("components")
            .iter()
            .all(|c| c["status"]["state"] == "Active")
    );
    one.leaves_nothing();
    std::thread::sleep(Duration::from_millis(100));
    assert_eq!(two.get("components").len(), 3);
    two.leaves_nothing();
}

/// A stand-in between real components, in their process and in another: they read what it sends and it reads what they do.
#[test]
fn a_stand_in_works_among_real_components_and_its_process_heals() {
    let stack = Stack::new();
    stack.expect(0, &["up"]);
    let overlay = "apiVersion: rtsctl.dev/v1\nkind: Deployment\nspec:\n  components:\n    Filter0: { standIn: always }\n";
    let overlay = stack.write("overlay.yaml", overlay).display().to_string();
    let said = stack.expect(0, &["apply", HELLO, "-f", &overlay]);
    assert!(said.out.contains("1 of 3 are stand-ins"), "{said:#?}");
    stack.until("connectors", "samples arrive on both connectors", flowing);
    assert_eq!(
        stack.named("components", "Filter0")["status"]["standIn"],
        true
    );
    assert_eq!(
        stack.named("components", "Sine0")["status"]["standIn"],
        false
    );
    let log = stack.expect(0, &["logs", "Printer0"]).out;
    assert!(!log.contains("WARN") && !log.contains("ERROR"), "{log}");

    // Recorded data goes the same way as what the component would send.
    // Each value lasts longer than the printer waits from line to line.
    let values = format!("{}{}", "1.5, ".repeat(20), "42.5, ".repeat(20));
    let played = format!(
        "apiVersion: rtsctl.dev/v1\nkind: Deployment\nspec:\n  components:\n    Filter0: {{ standIn: {{ when: always, data: {{ out: [{values}] }} }} }}\n"
    );
    let played = stack.write("played.yaml", &played).display().to_string();
    stack.expect(0, &["apply", HELLO, "-f", &played]);
    stack.until("connectors", "samples arrive on both connectors", flowing);
    stack.until("components", "values are played again and again", |_| {
        let log = stack.expect(0, &["logs", "Printer0"]).out;
        let mut after = log.as_str();
        let order = [" 1.5", " 42.5", " 1.5", " 42.5"];
        order.iter().all(|value| match after.split_once(value) {
            Some((_, rest)) => {
                after = rest;
                true
            }
            None => false,
        })
    });

    // The component itself takes its place, and back: the others stay.
    let sine = stack.named("components", "Sine0")["status"]["incarnation"].clone();
    stack.expect(0, &["apply", HELLO]);
    assert_eq!(
        stack.named("components", "Filter0")["status"]["standIn"],
        false
    );
    let crash = "apiVersion: rtsctl.dev/v1\nkind: Deployment\nspec:\n  components:\n    Filter0: { isolated: true, standIn: { when: always, crashAfter: 500ms } }\n";
    let crash = stack.write("crash.yaml", crash).display().to_string();
    stack.expect(0, &["apply", HELLO, "-f", &crash]);
    assert_eq!(
        stack.named("components", "Sine0")["status"]["incarnation"],
        sine
    );
    stack.until("components", "it crashed and was made again", |all| {
        let filter = all.iter().find(|c| c["metadata"]["name"] == "Filter0");
        filter.is_some_and(|c| c["status"]["restarts"].as_u64() >= Some(1))
    });
    stack.leaves_nothing();
}
