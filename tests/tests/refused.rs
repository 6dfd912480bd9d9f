//! Systems with faults: refused before anything is touched, or blocked with a reason while the rest comes up.

use rts_tests::{Said, Stack};
use serde_json::Value;

const HELLO: &str = "manifests/hello/system.xml";

/// Applies a bad file beside a running system: exit 3, nothing that runs changes, and the message is the snapshot.
#[track_caller]
fn refused(file: &str) -> String {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    let running = |stack: &Stack| -> Vec<(Value, Value)> {
        let key = |c: &Value| {
            (
                c["metadata"]["name"].clone(),
                c["status"]["incarnation"].clone(),
            )
        };
        stack.get("components").iter().map(key).collect()
    };
    let before = running(&stack);
    let Said { err, out, .. } = stack.expect(3, &["apply", file]);
    assert_eq!(out, "", "results only on stdout");
    assert_eq!(running(&stack), before, "nothing that runs changes");
    assert_eq!(stack.get("systems").len(), 1, "nothing is stored");
    stack.leaves_nothing();
    err
}

#[test]
fn malformed() {
    insta::assert_snapshot!(refused("manifests/invalid/malformed.xml"));
}

#[test]
fn unknown_port() {
    insta::assert_snapshot!(refused("manifests/invalid/unknown-port.xml"));
}

#[test]
fn cycle_among_hard_orders() {
    insta::assert_snapshot!(refused("manifests/invalid/cycle.xml"));
}

#[test]
fn module_that_cannot_be_found() {
    insta::assert_snapshot!(refused("manifests/invalid/missing-module.xml"));
}

/// A profile with one good component and one of the given type.
fn pair(type_name: &str, parameters: &str) -> String {
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:test:pair:1.0" rts:version="0.2" xmlns:rts="http://www.openrtp.org/namespaces/rts" xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext">
  <rts:Components rts:id="RTC:rtsctl:example:ConfigSample:1.0" rts:instanceName="Good0" rts:pathUri="localhost/Good0.rtc" rts:isRequired="true"/>
  <rts:Components rts:id="RTC:rtsctl:example:{type_name}:1.0" rts:instanceName="Bad0" rts:pathUri="localhost/Bad0.rtc" rts:isRequired="true" rts:activeConfigurationSet="default">
    <rts:ConfigurationSets rts:id="default">{parameters}</rts:ConfigurationSets>
    <rtsExt:Properties rtsExt:name="rtsctl.isolated" rtsExt:value="true"/>
  </rts:Components>
</rts:RtsProfile>
"#
    )
}

/// Applies it: exit 5, `Good0` Active, `Bad0` not and with a reason.
#[track_caller]
fn blocked(stack: &Stack, file: &std::path::Path) -> (String, String) {
    let said = stack.expect(5, &["apply", &file.to_string_lossy()]);
    assert_eq!(
        stack.named("components", "Good0")["status"]["state"],
        "Active",
        "the rest comes up"
    );
    let bad = stack.named("components", "Bad0");
    assert_ne!(bad["status"]["state"], "Active");
    let reason = bad["status"]["waitingOn"]
        .as_str()
        .unwrap_or_default()
        .to_owned();
    (said.err, reason)
}

#[test]
fn a_module_that_fails_at_dlopen_blocks_its_component() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(
        folder.path().join("libgarbage.so"),
        "this is no shared library",
    )
    .expect("a file");
    let stack = Stack::with_modules(folder.path());
    let file = stack.write("pair.xml", pair("Garbage", ""));
    let (err, reason) = blocked(&stack, &file);
    assert!(
        err.contains("libgarbage.so") && err.contains("Bad0"),
        "{err}"
    );
    assert!(reason.contains("libgarbage.so"), "{reason}");
    stack.leaves_nothing();
}

#[test]
fn a_module_that_fails_at_init_blocks_its_component() {
    let stack = Stack::new();
    let fault = r#"<rts:ConfigurationData rts:name="fault" rts:data="error-initialize"/>"#;
    let file = stack.write("pair.xml", pair("Misbehaving", fault));
    let (err, reason) = blocked(&stack, &file);
    assert!(
        err.contains("Bad0") && err.contains("on_initialize"),
        "{err}"
    );
    assert!(reason.contains("on_initialize"), "{reason}");
    // Mended, it comes up.
    let file = stack.write("pair.xml", pair("Misbehaving", ""));
    stack.expect(0, &["apply", &file.to_string_lossy()]);
    stack.leaves_nothing();
}
