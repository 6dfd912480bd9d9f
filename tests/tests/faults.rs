//! Things that go wrong at run time: told, healed or ended, and never covered up.

use std::process::Command;
use std::time::{Duration, Instant};

use rts_tests::{Stack, processes_of};
use serde_json::Value;

const HELLO: &str = "manifests/hello/system.xml";

fn pid(stack: &Stack, component: &str) -> u32 {
    let pid = stack.named("components", component)["status"]["pid"].as_u64();
    pid.and_then(|pid| pid.try_into().ok()).expect("a pid")
}

fn signal(pid: u32, name: &str) {
    let status = Command::new("kill")
        .args([&format!("-{name}"), &pid.to_string()])
        .status();
    assert!(status.expect("kill starts").success());
}

fn daemon(stack: &Stack, name: &str) -> Vec<u32> {
    let named = |pid: &u32| {
        std::fs::read_to_string(format!("/proc/{pid}/comm")).is_ok_and(|comm| comm.trim() == name)
    };
    processes_of(&stack.home())
        .into_iter()
        .filter(named)
        .collect()
}

/// One component of a type with parameters of its default set.
fn single(name: &str, type_name: &str, parameters: &str) -> String {
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:test:{name}:1.0" rts:version="0.2" xmlns:rts="http://www.openrtp.org/namespaces/rts" xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext">
  <rts:Components rts:id="RTC:rtsctl:example:{type_name}:1.0" rts:instanceName="{name}0" rts:pathUri="localhost/{name}0.rtc" rts:isRequired="true" rts:activeConfigurationSet="default">
    <rts:ConfigurationSets rts:id="default">{parameters}</rts:ConfigurationSets>
  </rts:Components>
</rts:RtsProfile>
"#
    )
}

fn parameter(name: &str, value: &str) -> String {
    format!(r#"<rts:ConfigurationData rts:name="{name}" rts:data="{value}"/>"#)
}

#[test]
fn a_stopped_manager_is_told_and_does_not_keep_a_teardown_from_its_end() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    let printer = pid(&stack, "Printer0");
    signal(printer, "STOP");
    stack.until(
        "components",
        "Printer0 is not said to be Active any more",
        |components| {
            components.iter().any(|c| {
                c["metadata"]["name"] == "Printer0"
                    && c["status"]["waitingOn"]
                        .as_str()
                        .is_some_and(|why| why.contains("answer"))
            })
        },
    );
    stack.expect(1, &["diff", HELLO]);
    let begun = Instant::now();
    stack.expect(0, &["teardown", "hello", "--yes"]);
    assert!(
        begun.elapsed() < Duration::from_secs(25),
        "asked, SIGTERM, SIGKILL: {:?}",
        begun.elapsed()
    );
    assert!(!rts_tests::alive(printer));
    stack.leaves_nothing();
}

#[test]
fn diff_is_not_content_while_a_wanted_component_does_not_run() {
    let stack = Stack::new();
    let file = stack.write(
        "bad.xml",
        single(
            "bad",
            "Misbehaving",
            &parameter("fault", "error-initialize"),
        ),
    );
    let file = file.to_string_lossy();
    stack.expect(5, &["apply", &file]);
    let said = stack.expect(1, &["diff", &file]);
    assert!(said.out.contains("bad0"), "{said:#?}");
    stack.leaves_nothing();
}

#[test]
fn a_component_that_hangs_is_not_healthy() {
    let stack = Stack::new();
    let file = stack.write(
        "hang.xml",
        single("hang", "Misbehaving", &parameter("fault", "hang-execute")),
    );
    stack.rtsctl(&["apply", &file.to_string_lossy()]);
    stack.until("systems", "the system is not healthy", |systems| {
        systems
            .iter()
            .any(|s| s["status"]["healthy"] == false && s["status"]["phase"] == "Degraded")
    });
    let component = stack.named("components", "hang0");
    let why = component["status"]["waitingOn"]
        .as_str()
        .unwrap_or_default()
        .to_owned();
    assert!(why.contains("on_execute"), "{component:#}");
    stack.leaves_nothing();
}

#[test]
fn a_parameter_that_leaves_the_profile_goes_back_to_its_default() {
    let stack = Stack::new();
    let gain = |stack: &Stack| -> Value {
        stack.named("components", "filter0")["status"]["configuration"]["sets"]["default"]["gain"]
            .clone()
    };
    let with = stack.write(
        "filter.xml",
        single("filter", "LowPassFilter", &parameter("gain", "5.0")),
    );
    stack.expect(0, &["apply", &with.to_string_lossy()]);
    assert_eq!(gain(&stack), "5.0");
    let without = stack.write("filter.xml", single("filter", "LowPassFilter", ""));
    stack.expect(0, &["apply", &without.to_string_lossy()]);
    assert_eq!(gain(&stack), "1.0");
    stack.leaves_nothing();
}

#[test]
fn what_the_module_does_not_know_is_refused_before_anything_starts() {
    let stack = Stack::new();
    stack.expect(0, &["up"]);
    let file = stack.write(
        "filter.xml",
        single("filter", "LowPassFilter", &parameter("gian", "5.0")),
    );
    let said = stack.expect(3, &["apply", &file.to_string_lossy()]);
    assert!(
        said.err.contains("gian") && said.err.contains("gain"),
        "{said:#?}"
    );
    assert!(
        said.err.contains("filter.xml:"),
        "it names the place: {said:#?}"
    );
    assert_eq!(stack.get("systems").len(), 0);
    assert_eq!(stack.get("managers").len(), 0);
    stack.leaves_nothing();
}

#[test]
fn deleted_sockets_come_back() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    for socket in ["run/controller.sock", "run/local/agent.sock"] {
        std::fs::remove_file(stack.home().join(socket)).expect("a socket");
        let deadline = Instant::now() + Duration::from_secs(5);
        while !stack.home().join(socket).exists() {
            assert!(Instant::now() < deadline, "{socket} is not bound again");
            std::thread::sleep(Duration::from_millis(50));
        }
    }
    assert_eq!(stack.get("components").len(), 3);
    stack.expect(0, &["logs", "Printer0"]);
    stack.leaves_nothing();
}

#[test]
fn down_finds_what_runs_even_without_its_run_folder() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    std::fs::remove_dir_all(stack.home().join("run")).expect("a folder");
    stack.leaves_nothing();
}

#[test]
fn an_agent_that_starts_again_keeps_managers_whose_lock_file_is_gone() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    let before = pid(&stack, "Sine0");
    for pid in daemon(&stack, "rts-agent") {
        rts_tests::kill(pid);
    }
    let folders = std::fs::read_dir(stack.home().join("run/local")).expect("the node's folder");
    for folder in folders.flatten().filter(|entry| entry.path().is_dir()) {
        let _ = std::fs::remove_file(folder.path().join("lock"));
    }
    stack.expect(0, &["up"]);
    stack.until("components", "all are Active", |components| {
        components.len() == 3 && components.iter().all(|c| c["status"]["state"] == "Active")
    });
    assert_eq!(
        pid(&stack, "Sine0"),
        before,
        "a healthy manager is not killed for want of a file"
    );
    stack.leaves_nothing();
}

#[test]
fn one_slow_system_does_not_keep_another_from_healing() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    let slow = single("slow", "ConfigSample", "").replace(
        "</rts:RtsProfile>",
        r#"<rts:Activation><rts:targets rts:sequence="1"><rts:TargetComponent rts:id="0" rts:instanceName="slow0" rts:componentId=""/><rts:WaitTime rts:waitTime="15000"/></rts:targets></rts:Activation></rts:RtsProfile>"#,
    );
    let file = stack.write("slow.xml", slow);
    let said = stack.rtsctl(&["apply", &file.to_string_lossy(), "--timeout", "1s"]);
    assert_eq!(said.code, 6, "{said:#?}");
    let printer = pid(&stack, "Printer0");
    rts_tests::kill(printer);
    stack.until("components", "Printer0 heals meanwhile", |components| {
        components.iter().any(|c| {
            c["metadata"]["name"] == "Printer0"
                && c["status"]["state"] == "Active"
                && c["status"]["pid"].as_u64() != Some(printer.into())
        })
    });
    assert_ne!(
        stack.named("components", "slow0")["status"]["state"],
        "Active"
    );
    stack.leaves_nothing();
}

#[test]
fn a_component_that_is_never_to_be_restarted_stays_down_and_says_why() {
    let stack = Stack::new();
    let never = single("motor", "ConfigSample", "").replace(
        "</rts:Components>",
        r#"<rtsExt:Properties rtsExt:name="rtsctl.restart" rtsExt:value="never"/></rts:Components>"#,
    );
    let file = stack.write("motor.xml", never);
    stack.expect(0, &["apply", &file.to_string_lossy()]);
    rts_tests::kill(pid(&stack, "motor0"));
    stack.until("components", "motor0 is down and says why", |components| {
        components.iter().any(|c| {
            c["status"]["state"] != "Active"
                && c["status"]["waitingOn"]
                    .as_str()
                    .is_some_and(|why| why.contains("never"))
        })
    });
    std::thread::sleep(Duration::from_secs(2));
    assert_eq!(stack.get("managers").len(), 0, "nothing starts it again");
    stack.expect(1, &["diff", &file.to_string_lossy()]);
    stack.leaves_nothing();
}

#[test]
fn a_killed_controller_is_missed_by_nobody() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    for pid in daemon(&stack, "rts-controller") {
        rts_tests::kill(pid);
    }
    let comm =
        |pid: &u32| std::fs::read_to_string(format!("/proc/{pid}/cmdline")).unwrap_or_default();
    let printer = || {
        let managers = daemon(&stack, "rts-manager");
        managers
            .into_iter()
            .find(|pid| comm(pid).contains("Printer0"))
    };
    let before = printer().expect("the process of Printer0");
    rts_tests::kill(before);
    let deadline = Instant::now() + Duration::from_secs(10);
    while printer().is_none_or(|pid| pid == before) {
        assert!(
            Instant::now() < deadline,
            "the agent heals without a controller"
        );
        std::thread::sleep(Duration::from_millis(100));
    }
    stack.expect(0, &["up"]);
    stack.until("connectors", "samples arrive again", |connectors| {
        connectors.len() == 2
            && connectors
                .iter()
                .all(|c| c["status"]["samplesReceived"].as_u64() >= Some(3))
    });
    stack.leaves_nothing();
}
