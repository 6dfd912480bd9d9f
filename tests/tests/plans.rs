//! Plans that are read, kept, checked and narrowed; orders with time-outs and optional components.

use rts_tests::{Profile, Stack, kill_9};
use serde_json::Value;

fn three() -> Profile {
    Profile::new("three")
        .component("source", "SineSource")
        .with("manager", "a")
        .component("middle", "LowPassFilter")
        .with("manager", "b")
        .parameter("gain", "1.0")
        .component("sink", "Printer")
        .with("manager", "c")
        .connect("source.out", "middle.in")
        .connect("middle.out", "sink.in")
}

fn write(stack: &Stack, name: &str, profile: &Profile) -> String {
    let file = stack.write(name, profile.xml());
    file.to_string_lossy().into_owned()
}

fn changed(stack: &Stack, gain: &str) -> String {
    let text = three()
        .xml()
        .replace(r#"rts:data="1.0""#, &format!(r#"rts:data="{gain}""#));
    let file = stack.write(&format!("gain-{gain}.xml"), text);
    file.to_string_lossy().into_owned()
}

fn gain(stack: &Stack) -> Value {
    let middle = stack.named("components", "middle");
    middle["status"]["configuration"]["sets"]["default"]["gain"].clone()
}

#[test]
fn a_kept_plan_is_carried_out_or_refused() {
    let stack = Stack::new();
    stack.expect(0, &["up"]);
    let first = write(&stack, "three.xml", &three());
    let folder = stack.home().parent().expect("a folder").to_owned();
    let kept = |name: &str| folder.join(name).to_string_lossy().into_owned();
    stack.expect(0, &["plan", &first, "--out", &kept("first.plan")]);
    stack.expect(0, &["apply", &kept("first.plan")]);
    // Twice is too often: the plan was for a world without it.
    let said = stack.expect(7, &["apply", &kept("first.plan")]);
    assert!(said.err.contains("plan again"), "{said:#?}");
    // Somebody else was faster.
    stack.expect(
        0,
        &["plan", &changed(&stack, "2.0"), "--out", &kept("two.plan")],
    );
    stack.expect(0, &["apply", &changed(&stack, "3.0")]);
    stack.expect(7, &["apply", &kept("two.plan")]);
    assert_eq!(gain(&stack), "3.0");
    // What runs has changed: a component that is held, since its process died, would be made now.
    let never = three().with("restart", "never").xml();
    let never = stack.write("never.xml", never);
    let never = never.to_string_lossy();
    stack.expect(0, &["apply", &never]);
    stack.expect(
        0,
        &["plan", &changed(&stack, "2.0"), "--out", &kept("dead.plan")],
    );
    kill_9(stack.witness().of("sink").pid);
    stack.until("components", "the death is seen", |components| {
        let sink = components.iter().find(|c| c["metadata"]["name"] == "sink");
        sink.is_some_and(|c| c["status"]["state"] != "Active")
    });
    stack.expect(7, &["apply", &kept("dead.plan")]);
    stack.leaves_nothing();
}

#[test]
fn a_check_index_is_for_one_state_of_the_system_also_after_a_teardown() {
    let stack = Stack::new();
    stack.expect(0, &["up"]);
    let first = write(&stack, "three.xml", &three());
    let index = |file: &str| -> String {
        let plan = stack.expect(0, &["plan", file, "-o", "json"]).out;
        let plan: Value = serde_json::from_str(&plan).expect("JSON");
        plan["index"].as_u64().expect("a number").to_string()
    };
    assert_eq!(index(&first), "0");
    stack.expect(0, &["apply", &first, "--check-index", "0"]);
    let one = index(&first);
    stack.expect(7, &["apply", &changed(&stack, "2.0"), "--check-index", "0"]);
    stack.expect(
        0,
        &["apply", &changed(&stack, "2.0"), "--check-index", &one],
    );
    stack.expect(7, &["plan", &first, "--check-index", &one]);
    stack.expect(0, &["teardown", "three", "--yes"]);
    stack.expect(0, &["apply", &first]);
    assert_ne!(index(&first), one);
    let two = index(&first);
    stack.kill_9("rts-controller");
    stack.expect(0, &["up"]);
    assert_eq!(index(&first), two);
    stack.leaves_nothing();
}

#[test]
fn targets_change_nothing_else() {
    let stack = Stack::new();
    let first = write(&stack, "three.xml", &three());
    stack.expect(0, &["apply", &first]);
    let before = stack.witness();
    // Both the filter and the printer change; only one of them is meant.
    let both = three()
        .xml()
        .replace(r#"rts:data="1.0""#, r#"rts:data="2.0""#);
    let both = both.replace(
        r#"rtsctl.manager" rtsExt:value="c""#,
        r#"rtsctl.manager" rtsExt:value="d""#,
    );
    let both = stack.write("both.xml", both);
    let both = both.to_string_lossy();
    stack.expect(2, &["apply", &both, "--target", "component/nobody"]);
    stack.expect(9, &["apply", &both, "--no-restart"]);
    stack.expect(0, &["apply", &both, "--target", "middle", "--no-restart"]);
    assert_eq!(gain(&stack), "2.0");
    let after = stack.witness();
    for name in ["source", "middle", "sink"] {
        assert_eq!(
            before.of(name).info.incarnation,
            after.of(name).info.incarnation
        );
    }
    stack.expect(1, &["diff", &both]);
    stack.expect(0, &["diff", &both, "--target", "component/middle"]);
    stack.leaves_nothing();
}

#[test]
fn an_optional_component_that_fails_holds_nobody_up() {
    let stack = Stack::new();
    let profile = Profile::new("arm")
        .component("camera", "Misbehaving")
        .optional()
        .with("manager", "a")
        .parameter("fault", "error-activate")
        .component("motor", "Printer")
        .with("manager", "b")
        .order("Activation", &["camera", "motor"], 0);
    let file = write(&stack, "arm.xml", &profile);
    let said = stack.expect(0, &["apply", &file]);
    assert!(said.err.contains("camera"), "it is told: {said:#?}");
    assert_eq!(
        stack.named("components", "motor")["status"]["state"],
        "Active"
    );
    stack.leaves_nothing();
}

#[test]
fn a_wait_that_runs_out_fails_the_one_who_waits() {
    let stack = Stack::new();
    let profile = Profile::new("slow")
        .component("sensor", "Misbehaving")
        .with("manager", "a")
        .with("startTimeout", "20s")
        .parameter("fault", "slow-activate")
        .parameter("seconds", "3")
        .component("motor", "Printer")
        .with("manager", "b")
        .sync("Activation", "motor", "sensor", 200);
    let file = write(&stack, "slow.xml", &profile);
    // In the end all is well: what ran out of time is tried again.
    stack.expect(0, &["apply", &file]);
    let events = stack.expect(0, &["events"]).out;
    assert!(events.contains("200 ms"), "{events}");
    stack.leaves_nothing();
}

#[test]
fn a_mended_module_gets_a_new_process_also_when_its_component_never_came_up() {
    let folder = tempfile::tempdir().expect("a folder");
    let module = folder.path().join("libmisbehaving.so");
    let original =
        std::fs::read(rts_tests::programs().join("libmisbehaving.so")).expect("the module");
    std::fs::write(&module, &original).expect("a copy");
    let stack = Stack::with_modules(folder.path());
    let profile = |fault: &str| {
        Profile::new("lab")
            .component("camera", "Misbehaving")
            .parameter("fault", fault)
            .component("light", "Printer")
    };
    let file = write(&stack, "lab.xml", &profile("error-initialize"));
    stack.expect(5, &["apply", &file]);
    let before = stack.witness().of("light").pid;
    // Another file, as a compiler writes it: what lies behind an ELF's end is not loaded.
    let mended = folder.path().join("mended");
    std::fs::write(&mended, [original.as_slice(), b"mended"].concat()).expect("a new file");
    std::fs::rename(&mended, &module).expect("in its place");
    let file = write(&stack, "mended.xml", &profile("none"));
    let plan = stack.expect(0, &["plan", &file]).out;
    assert!(
        plan.contains("the module file of Misbehaving changed"),
        "{plan}"
    );
    stack.expect(0, &["apply", &file]);
    assert_ne!(stack.witness().of("light").pid, before);
    assert_eq!(
        stack.named("components", "camera")["status"]["state"],
        "Active"
    );
    stack.leaves_nothing();
}
