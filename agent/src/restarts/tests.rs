//! Deaths, what is held because of them, and the file.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use jiff::{SignedDuration, Timestamp};
use rts_host::disk::FileDisk;
use rts_plan::desired::{NodeSpec, NodeSystem, PlacedComponent, SystemRef};
use rts_plan::observed::ManagerObserved;
use rts_plan::restart::Ended;
use rts_schemas::system::{ComponentSpec, Policy, RestartPolicy};
use tokio::time::timeout;

use super::file::{load, save};
use super::memory::Memory;
use crate::fixtures::SlowDisk;
use crate::policies::Policies;

const NEVER: Policy = Policy {
    restart: RestartPolicy::Never,
    ..ALWAYS
};
const ALWAYS: Policy = Policy {
    restart: RestartPolicy::Always,
    on_disconnect: rts_schemas::system::OnDisconnect::Keep,
    reset_on_error: false,
    restart_limit: None,
    restart_window_ms: None,
    start_timeout_ms: None,
    liveness_timeout_ms: None,
    on_hang: rts_schemas::system::OnHang::Report,
    drift: rts_schemas::system::DriftPolicy::Repair,
};

fn system() -> SystemRef {
    SystemRef {
        name: "hello".to_owned(),
        uid: "1".to_owned(),
    }
}

fn spec(components: &[(&str, Policy)]) -> (NodeSpec, Policies) {
    let placed = |(instance, policy): &(&str, Policy)| PlacedComponent {
        spec: ComponentSpec {
            instance: (*instance).to_owned(),
            type_name: "T".to_owned(),
            full_id: String::new(),
            required: true,
            ports: Vec::new(),
            configuration: Default::default(),
            execution_context: Default::default(),
            placement: Default::default(),
            policy: policy.clone(),
            ..ComponentSpec::default()
        },
        manager: "main".to_owned(),
        stand_in: None,
        module_digest: None,
        recreate_hash: String::new(),
    };
    let spec = NodeSpec {
        node: "local".to_owned(),
        systems: vec![NodeSystem {
            system: system(),
            components: components.iter().map(placed).collect(),
            connectors: Vec::new(),
            orders: Default::default(),
            elsewhere: Default::default(),
            generation: 0,
        }],
    };
    let policies = Policies::of_spec(&spec);
    (spec, policies)
}

fn at(seconds: i64) -> Timestamp {
    Timestamp::UNIX_EPOCH + SignedDuration::from_secs(1_800_000_000 + seconds)
}

/// Components that live in the manager `one`.
fn living(instances: &[&str]) -> Memory {
    let mut memory = Memory::default();
    for instance in instances {
        memory.made(&system(), instance, "one");
    }
    memory
}

fn held(memory: &Memory) -> Vec<String> {
    memory.held().into_iter().map(|h| h.instance).collect()
}

/// What a manager says that holds `A`.
fn observed(incarnation: &str, restarts: u32) -> ManagerObserved {
    serde_json::from_value(serde_json::json!({
        "key": {"system": {"name": "hello", "uid": "1"}, "name": "main"},
        "incarnation": incarnation, "pid": 1, "started": "", "responsive": true, "modules": [],
        "components": [{"instance": "A", "type": "T", "system": {"name": "hello", "uid": "1"}, "incarnation": "a",
            "recreateHash": "", "state": "Active", "restarts": restarts, "created": "", "configuration": {},
            "executionKind": "periodic", "rate": 1.0, "executions": 0, "ports": [], "connectors": []}]
    }))
    .unwrap()
}

#[test]
fn a_death_counts_for_all_that_lived_there_and_holds_what_is_never_to_come_back() {
    let (_, policies) = spec(&[("A", ALWAYS), ("N", NEVER), ("Elsewhere", NEVER)]);
    let mut memory = living(&["A", "N"]);
    memory.made(&system(), "Elsewhere", "two");
    let told = memory.died("one", Ended::Signal(9), at(0), &policies);
    assert_eq!(told, memory.held());
    assert_eq!(held(&memory), ["N"]);
    assert!(
        told[0].reason.contains("rtsctl.restart is never"),
        "{}",
        told[0].reason
    );
    let counts = ["A", "N", "Elsewhere"].map(|name| memory.restarts(&system(), name));
    assert_eq!(counts, [1, 1, 0]);
    // A second word of the same death changes nothing.
    assert_eq!(
        memory.died("one", Ended::Unknown, at(1), &policies),
        Vec::new()
    );
    assert_eq!(memory.restarts(&system(), "A"), 1);
}

#[test]
fn what_nothing_is_known_of_died_where_it_belongs() {
    let (_, policies) = spec(&[("A", NEVER), ("N", NEVER), ("Gone", NEVER)]);
    let mut memory = living(&["Gone"]);
    memory.made(&system(), "N", "two");
    memory.gone(&system(), "Gone");
    let main = rts_plan::desired::ManagerKey {
        system: Some(system()),
        name: "main".to_owned(),
    };
    memory.assume(&system(), policies.placed_in(&main), "one");
    memory.died("one", Ended::Unknown, at(0), &policies);
    assert_eq!(
        held(&memory),
        ["A"],
        "N lives in another start, and Gone was deleted"
    );
}

#[test]
fn what_is_stopped_or_deleted_does_not_die() {
    let (_, policies) = spec(&[("A", NEVER), ("N", NEVER)]);
    let mut memory = living(&["A", "N"]);
    memory.gone(&system(), "N");
    memory.left("one");
    // An answer from before says nothing any more.
    assert!(!memory.seen(&observed("one", 0), memory.told()));
    memory.died("one", Ended::Code(0), at(0), &policies);
    assert_eq!(held(&memory), [""; 0]);
    assert_eq!(memory.restarts(&system(), "A"), 0);
}

#[test]
fn what_was_told_to_go_and_is_there_all_the_same_dies_with_its_process() {
    let (_, policies) = spec(&[("A", NEVER)]);
    let dies = |memory: &mut Memory| {
        memory.died("one", Ended::Signal(9), at(0), &policies);
        held(memory) == ["A"]
    };
    // It was said to be absent, and its manager says later that it is there.
    let mut memory = living(&["A"]);
    let before = memory.told();
    memory.gone(&system(), "A");
    assert!(!memory.seen(&observed("one", 0), before), "old news");
    assert!(memory.seen(&observed("one", 0), memory.told()));
    assert!(dies(&mut memory));
    // While it is deleted nothing is believed; when that failed, it lives where it did.
    let mut memory = living(&["A"]);
    memory.leaving(&system(), "A");
    assert!(!memory.seen(&observed("one", 0), memory.told()));
    assert!(!dies(&mut memory.clone()));
    memory.made(&system(), "A", "one");
    assert!(dies(&mut memory));
    // When that succeeded, an answer from before does not bring it back.
    let mut memory = living(&["A"]);
    memory.leaving(&system(), "A");
    let before = memory.told();
    memory.gone(&system(), "A");
    assert!(!memory.seen(&observed("one", 0), before));
    assert!(!dies(&mut memory));
}

#[test]
fn a_limit_counts_the_deaths_within_its_window_only() {
    let limited = Policy {
        restart_limit: Some(2),
        restart_window_ms: Some(60_000),
        ..ALWAYS
    };
    let (_, policies) = spec(&[("A", limited)]);
    let mut memory = Memory::default();
    let mut die = |seconds| {
        memory.made(&system(), "A", "one");
        !memory
            .died("one", Ended::Code(1), at(seconds), &policies)
            .is_empty()
    };
    let outcomes = [0, 30, 70, 100, 110].map(&mut die);
    assert_eq!(outcomes, [false, false, false, false, true]);
    assert_eq!(memory.restarts(&system(), "A"), 5);
}

#[test]
fn it_is_held_until_its_system_changes_or_it_is_there_again() {
    let (same, policies) = spec(&[("A", NEVER)]);
    let dead = || {
        let mut memory = living(&["A"]);
        memory.died("one", Ended::Signal(11), at(0), &policies);
        memory
    };
    let mut memory = dead();
    memory.keep(&same, None, &policies);
    assert!(!memory.seen(&observed("one", 0), memory.told()));
    assert_eq!(held(&memory), ["A"]);
    let (changed, policies) = spec(&[("A", NEVER), ("B", ALWAYS)]);
    memory.keep(&changed, Some(&same), &policies);
    assert_eq!(held(&memory), [""; 0]);
    assert_eq!(memory.restarts(&system(), "A"), 1, "the count goes on");

    let mut memory = dead();
    assert!(memory.seen(&observed("two", 0), memory.told()));
    assert_eq!(held(&memory), [""; 0]);

    let mut memory = dead();
    let none = NodeSpec::default();
    memory.keep(&none, None, &Policies::of_spec(&none));
    assert_eq!(held(&memory), [""; 0]);
    assert_eq!(memory.restarts(&system(), "A"), 0);
}

async fn again(path: &Path, boot: &str) -> Memory {
    load(&FileDisk, path, Some(boot)).await.unwrap()
}

#[tokio::test]
async fn the_file_outlives_the_agent_and_a_reboot_forgets_what_speaks_against_a_start() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("restarts.json");
    let (_, policies) = spec(&[("A", NEVER), ("B", ALWAYS)]);
    let mut memory = living(&["A"]);
    memory.died("one", Ended::Signal(9), at(0), &policies);
    memory.made(&system(), "B", "two");
    save(&FileDisk, &path, Some("boot"), memory.components())
        .await
        .unwrap();

    let mut later = again(&path, "boot").await;
    assert_eq!(later.held(), memory.held());
    later.died("two", Ended::Unknown, at(9), &policies);
    assert_eq!(later.restarts(&system(), "B"), 1);

    let mut rebooted = again(&path, "another boot").await;
    assert_eq!(held(&rebooted), [""; 0]);
    assert_eq!(rebooted.restarts(&system(), "A"), 1);
    rebooted.died("two", Ended::Unknown, at(9), &policies);
    assert_eq!(rebooted.restarts(&system(), "B"), 0, "it did not live on");
}

#[tokio::test]
async fn a_damaged_file_is_put_aside() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("restarts.json");
    for text in ["{", r#"{"version": 2, "bootId": null, "components": []}"#] {
        std::fs::write(&path, text).unwrap();
        assert_eq!(again(&path, "boot").await.components(), []);
        let aside = folder.path().join("restarts.json.damaged");
        assert_eq!(std::fs::read_to_string(&aside).unwrap(), text);
        assert!(!path.exists());
    }
    save(&FileDisk, &path, Some("boot"), Vec::new())
        .await
        .unwrap();
    assert_eq!(again(&path, "boot").await.components(), []);
    assert!(path.exists());
}

#[tokio::test]
async fn a_file_that_cannot_be_read_is_an_error_and_stays() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("restarts.json");
    std::fs::create_dir(&path).unwrap();
    assert!(load(&FileDisk, &path, Some("boot")).await.is_err());
    assert!(path.is_dir(), "it is not put aside");
    let loaded = super::Restarts::load(Arc::new(FileDisk), folder.path(), None).await;
    let error = loaded.err().unwrap();
    assert!(error.to_string().contains("restarts.json"), "{error}");
}

#[test]
fn the_same_system_in_other_words_pardons_nobody() {
    let (spec, policies) = spec(&[("A", NEVER)]);
    let mut memory = living(&["A"]);
    memory.died("one", Ended::Signal(11), at(0), &policies);
    // As the controller of another version writes it.
    let part = std::collections::BTreeMap::from([("1".to_owned(), "other words".to_owned())]);
    let other = Policies::of_parts(&spec, part);
    let mut counted = spec.clone();
    counted.systems[0].generation = 7;
    memory.keep(&counted, Some(&spec), &other);
    assert_eq!(held(&memory), ["A"]);
    // After the next start of the agent, too.
    memory.keep(&counted, None, &other);
    assert_eq!(held(&memory), ["A"]);
    // Nor does it matter where else a component may still run.
    let mut may = counted.clone();
    let there = serde_json::json!({"A": {"node": "arm", "required": true}});
    may.systems[0].elsewhere = serde_json::from_value(there).unwrap();
    memory.keep(&may, Some(&counted), &Policies::of_spec(&may));
    assert_eq!(held(&memory), ["A"]);
    memory.keep(&counted, Some(&may), &other);
    assert_eq!(held(&memory), ["A"]);
    // Applied again as it was, it is to be tried again.
    let before = counted.clone();
    counted.systems[0].generation = 8;
    memory.keep(&counted, Some(&before), &policies);
    assert_eq!(held(&memory), [""; 0]);
}

#[tokio::test(start_paused = true)]
async fn a_write_goes_on_when_its_caller_gives_up_and_no_other_begins_meanwhile() {
    let (disk, mut begins, go) = SlowDisk::new("restarts.json");
    let state = Path::new("/nowhere");
    let restarts = super::Restarts::load(disk.clone(), state, None).await;
    let restarts = restarts.unwrap();
    let save = |instance: &'static str| {
        restarts.change(|m| m.made(&system(), instance, "one"));
        restarts.save()
    };
    let soon = Duration::from_secs(1);
    assert!(timeout(soon, save("A")).await.is_err());
    begins.recv().await.unwrap();
    assert!(timeout(soon, save("B")).await.is_err());
    assert!(begins.try_recv().is_err(), "it waits for the first");
    go.send(()).unwrap();
    go.send(()).unwrap();
    timeout(soon, save("C")).await.unwrap();
    restarts.save().await;
    let written = disk.written.lock().unwrap();
    let texts: Vec<_> = written.iter().map(|t| String::from_utf8_lossy(t)).collect();
    assert_eq!(texts.len(), 2, "nothing has changed since: {texts:?}");
    assert!(texts[0].contains("\"A\"") && !texts[0].contains("\"B\""));
    assert!(texts[1].contains("\"B\"") && texts[1].contains("\"C\""));
}
