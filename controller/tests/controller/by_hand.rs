//! What a person changes by hand in what runs: put back, left, or taken into the stored system, as its policy says.

use std::sync::Arc;
use std::time::Duration;

use crate::fleet::{Cluster, FakeAgent, systems};
use rts_controller_api::objects::{Connector, Phase, System};
use rts_schemas::system::{DriftPolicy, SystemSpec};

const CONNECTOR: &str = "Sine0.out-Filter0.in";

fn hello(policy: DriftPolicy) -> SystemSpec {
    let mut spec = systems::hello();
    for component in &mut spec.components {
        component.policy.drift = policy;
        let values = [("gain".to_owned(), "1".to_owned())];
        let sets = &mut component.configuration.sets;
        sets.insert("default".into(), values.into());
    }
    spec
}

async fn runs(policy: DriftPolicy) -> (Cluster, Arc<FakeAgent>) {
    let (cluster, agent) = Cluster::hello();
    cluster.apply(hello(policy)).await;
    cluster.until_phase("hello", Phase::Converged).await;
    agent.take_done();
    (cluster, agent)
}

async fn rounds() {
    tokio::time::sleep(Duration::from_secs(20)).await;
}

fn condition<'a>(system: &'a System, kind: &str) -> (&'a str, &'a str) {
    let mut all = system.status.conditions.iter();
    let found = all.find(|condition| condition.kind == kind).unwrap();
    (&found.status, &found.message)
}

fn connector(cluster: &Cluster, name: &str) -> Connector {
    let all = cluster.core.view.list::<Connector>().items;
    all.into_iter().find(|c| c.metadata.name == name).unwrap()
}

fn gain(agent: &FakeAgent, instance: &str) -> String {
    let inventory = agent.inventory_now();
    let mut all = inventory.managers.iter().flat_map(|m| &m.components);
    let found = all.find(|c| c.instance == instance).unwrap();
    found.configuration.sets["default"]["gain"].clone()
}

#[tokio::test(start_paused = true)]
async fn repair_puts_everything_back_and_tells_it_once() {
    let (cluster, agent) = runs(DriftPolicy::Repair).await;
    let before = agent.incarnations();
    agent.set_by_hand("Filter0", "gain", "7");
    agent.deactivate_by_hand("Printer0");
    agent.disconnect_by_hand("Sine0", CONNECTOR);
    rounds().await;
    let hello = cluster.until_phase("hello", Phase::Converged).await;
    assert_eq!(gain(&agent, "Filter0"), "1");
    assert_eq!(agent.incarnations(), before);
    assert_eq!(condition(&hello, "Drifted").0, "False");
    let mut told = cluster.told("Drifted");
    let mut repaired = cluster.told("DriftRepaired");
    told.sort();
    repaired.sort();
    let all = [
        "component/Filter0",
        "component/Printer0",
        "connector/Sine0.out-Filter0.in",
    ];
    assert_eq!(
        (told, repaired),
        (all.map(str::to_owned).into(), all.map(str::to_owned).into())
    );
    assert_eq!(cluster.stored().systems["hello"].generation, 1);
}

#[tokio::test(start_paused = true)]
async fn a_value_that_is_ignored_is_left_and_shown() {
    let (cluster, agent) = runs(DriftPolicy::Ignore).await;
    agent.set_by_hand("Filter0", "gain", "7");
    rounds().await;
    let hello = cluster.system("hello").unwrap();
    assert_eq!(hello.status.phase, Phase::Converged);
    assert!(hello.status.synced && hello.status.healthy);
    insta::assert_snapshot!(condition(&hello, "Synced").1, @"as written, but for what was changed by hand and is left");
    insta::assert_snapshot!(condition(&hello, "Drifted").1, @"component/Filter0 was changed by hand (configuration.default.gain: 1 -> 7); it is left so (see rtsctl.drift)");
    assert_eq!(hello.status.drift.len(), 1);
    let filter = cluster.component("Filter0").status;
    assert!(filter.drift);
    assert_eq!(filter.drift_fields, ["configuration.default.gain: 1 -> 7"]);
    assert_eq!(agent.take_done(), [""; 0]);
    assert_eq!(cluster.told("Drifted"), ["component/Filter0"]);

    agent.set_by_hand("Filter0", "gain", "8");
    rounds().await;
    assert_eq!(cluster.told("Drifted").len(), 2, "it is another one");
    agent.set_by_hand("Filter0", "gain", "1");
    rounds().await;
    let hello = cluster.system("hello").unwrap();
    assert_eq!(condition(&hello, "Drifted").0, "False");
    assert!(cluster.told("DriftRepaired").is_empty());
}

#[tokio::test(start_paused = true)]
async fn what_is_taken_away_and_left_so_is_not_healthy_and_ends_an_apply_soon() {
    let (cluster, agent) = runs(DriftPolicy::Ignore).await;
    agent.deactivate_by_hand("Filter0");
    agent.disconnect_by_hand("Filter0", "Filter0.out-Printer0.in");
    rounds().await;
    assert_eq!(agent.take_done(), [""; 0]);
    let again = cluster.apply(hello(DriftPolicy::Ignore)).await;
    assert!(!again.changed && again.plan.is_empty());
    let status = cluster.until_phase("hello", Phase::Degraded).await.status;
    assert!(status.synced && !status.healthy);
    // What a client needs so as not to wait any longer: required, and no next try.
    let waiting: Vec<_> = status
        .waiting_on
        .iter()
        .map(|w| (w.target.as_str(), w.required, w.transient, w.next_try))
        .collect();
    assert_eq!(
        waiting,
        [
            ("component/Filter0", true, false, None),
            ("connector/Filter0.out-Printer0.in", true, false, None)
        ]
    );
    let why = &status.waiting_on[0].reason;
    assert_eq!(
        why,
        "was deactivated by hand and is left so (see rtsctl.drift)"
    );
    let lost = connector(&cluster, "Filter0.out-Printer0.in").status;
    assert_eq!(lost.drift_fields, ["was disconnected by hand"]);
    assert!(lost.drift);
}

#[tokio::test(start_paused = true)]
async fn an_optional_component_that_is_left_inactive_is_no_fault() {
    let (cluster, agent) = Cluster::hello();
    let mut spec = hello(DriftPolicy::Ignore);
    spec.orders = Default::default();
    spec.components[2].required = false;
    cluster.apply(spec).await;
    cluster.until_phase("hello", Phase::Converged).await;
    agent.deactivate_by_hand("Printer0");
    rounds().await;
    let status = cluster.system("hello").unwrap().status;
    assert!(status.synced && status.healthy);
    assert!(status.waiting_on.iter().all(|w| !w.required));
}

#[tokio::test(start_paused = true)]
async fn what_is_adopted_is_stored_once_and_nothing_is_touched() {
    let (cluster, agent) = runs(DriftPolicy::Adopt).await;
    let before = (agent.incarnations(), cluster.stored());
    agent.set_by_hand("Filter0", "gain", "7");
    agent.disconnect_by_hand("Filter0", "Filter0.out-Printer0.in");
    agent.connect_by_hand(&systems::connector("Sine0.out", "Printer0.in"));
    let adopted = |s: Option<&System>| s.unwrap().metadata.generation == 2;
    cluster.until("hello", adopted).await;
    rounds().await;
    let hello = cluster.until_phase("hello", Phase::Converged).await;
    let stored = &cluster.stored().systems["hello"];
    assert_eq!((stored.generation, stored.index), (2, 2), "stored once");
    assert_eq!(hello.status.check_index, 2);
    assert_eq!(stored.digests, before.1.systems["hello"].digests);
    let sets = &stored.spec.components[1].configuration.sets;
    assert_eq!(sets["default"]["gain"], "7");
    let names: Vec<_> = stored
        .spec
        .connectors
        .iter()
        .map(|c| c.name.as_str())
        .collect();
    assert_eq!(names, [CONNECTOR, "Sine0.out-Printer0.in"]);
    assert_eq!(agent.take_done(), [""; 0]);
    assert_eq!(agent.incarnations(), before.0);
    assert_eq!(condition(&hello, "Drifted").0, "False");
    assert_eq!(cluster.told("DriftAdopted").len(), 3);
    let told = agent.state.lock().unwrap().spec.clone().unwrap();
    assert_eq!(told.spec.systems[0].connectors.len(), 2);
}

#[tokio::test(start_paused = true)]
async fn a_module_that_has_changed_since_is_not_taken_up_by_an_adoption() {
    let (cluster, agent) = runs(DriftPolicy::Adopt).await;
    let before = cluster.stored().systems["hello"].digests.clone();
    agent.rebuild("LowPassFilter");
    agent.set_by_hand("Filter0", "gain", "7");
    let adopted = |s: Option<&System>| s.unwrap().metadata.generation == 2;
    cluster.until("hello", adopted).await;
    rounds().await;
    assert_eq!(cluster.stored().systems["hello"].digests, before);
    assert_eq!(agent.take_done(), [""; 0]);
}

#[tokio::test(start_paused = true)]
async fn what_cannot_be_adopted_is_left_and_told_once() {
    let (cluster, agent) = runs(DriftPolicy::Adopt).await;
    // Its module knows no parameter of that name.
    agent.describe("LowPassFilter", &["in:in:A", "out:out:A"], &["other"]);
    agent.set_by_hand("Filter0", "gain", "7");
    tokio::time::sleep(Duration::from_secs(300)).await;
    let hello = cluster.system("hello").unwrap();
    assert_eq!(
        (hello.metadata.generation, hello.status.phase),
        (1, Phase::Converged)
    );
    assert_eq!(condition(&hello, "Drifted").0, "True");
    assert_eq!(gain(&agent, "Filter0"), "7");
    assert_eq!(cluster.told("DriftNotAdopted"), ["system/hello"]);
    assert!(agent.state.lock().unwrap().resolved < 20, "no hot loop");
    // It is tried again now and then.
    agent.describe("LowPassFilter", &["in:in:A", "out:out:A"], &["gain"]);
    let adopted = |s: Option<&System>| s.unwrap().metadata.generation == 2;
    cluster.until("hello", adopted).await;
}

/// A node of another component of the system, with a system over both nodes.
async fn over_two_nodes() -> (Cluster, Arc<FakeAgent>, Arc<FakeAgent>) {
    let (mut cluster, agent) = Cluster::hello();
    let other = cluster.fleet.add("other", &["Printer"]);
    cluster.join("other", "o1");
    let mut spec = hello(DriftPolicy::Adopt);
    spec.components[2].placement.node = Some("other".into());
    spec.connectors.truncate(1);
    cluster.apply(spec).await;
    cluster.until_phase("hello", Phase::Converged).await;
    agent.take_done();
    other.take_done();
    (cluster, agent, other)
}

#[tokio::test(start_paused = true)]
async fn what_waits_for_a_node_to_be_adopted_says_so_and_is_adopted_soon_after_it_is_back() {
    let (cluster, agent, other) = over_two_nodes().await;
    other.silence(true);
    tokio::time::sleep(Duration::from_secs(30)).await;
    agent.set_by_hand("Filter0", "gain", "7");
    tokio::time::sleep(Duration::from_secs(60)).await;
    let hello = cluster.system("hello").unwrap();
    assert_eq!(hello.metadata.generation, 1);
    insta::assert_snapshot!("not_adopted_yet", condition(&hello, "Drifted").1);
    assert_eq!(cluster.told("DriftNotAdopted"), ["system/hello"]);
    other.silence(false);
    tokio::time::sleep(Duration::from_secs(8)).await;
    assert_eq!(cluster.stored().systems["hello"].generation, 2);
    assert_eq!([agent.take_done(), other.take_done()].concat(), [""; 0]);
}

#[tokio::test(start_paused = true)]
async fn what_changes_once_more_while_it_is_adopted_is_not_put_back() {
    let (cluster, agent) = runs(DriftPolicy::Adopt).await;
    // The module is asked for before what runs is looked at: it waits there, and meanwhile another value is set.
    agent.deafen("modules", true);
    agent.set_by_hand("Filter0", "gain", "7");
    tokio::time::sleep(Duration::from_secs(7)).await;
    let asked = agent.state.lock().unwrap().resolved;
    agent.set_by_hand("Filter0", "gain", "8");
    agent.deafen("modules", false);
    let adopted = |s: Option<&System>| s.unwrap().metadata.generation >= 2;
    cluster.until("hello", adopted).await;
    rounds().await;
    assert!(agent.state.lock().unwrap().resolved > asked);
    assert_eq!(gain(&agent, "Filter0"), "8");
    assert_eq!(agent.take_done(), [""; 0], "it was never set back");
}

#[tokio::test(start_paused = true)]
async fn an_adoption_neither_restarts_what_failed_nor_forgets_its_tries() {
    let (cluster, agent) = runs(DriftPolicy::Adopt).await;
    agent.fail("StartManager manager/hello.Printer0", 1_000);
    agent.kill("hello.Printer0");
    tokio::time::sleep(Duration::from_secs(300)).await;
    let next = |cluster: &Cluster| {
        let waiting = cluster.system("hello").unwrap().status.waiting_on;
        waiting.iter().filter_map(|w| w.next_try).max().unwrap()
    };
    let before = next(&cluster);
    agent.set_by_hand("Filter0", "gain", "7");
    let adopted = |s: Option<&System>| s.unwrap().metadata.generation == 2;
    cluster.until("hello", adopted).await;
    tokio::time::sleep(Duration::from_secs(1)).await;
    let far = next(&cluster).duration_since(cluster.core.clock.now());
    assert!(next(&cluster) == before || far.as_secs() > 20, "{far:?}");
}

#[tokio::test(start_paused = true)]
async fn nothing_is_adopted_while_something_of_the_system_is_to_be_restarted() {
    let (cluster, agent) = runs(DriftPolicy::Adopt).await;
    // It is replaced at once when it has run for a while.
    tokio::time::sleep(Duration::from_secs(700)).await;
    let stop = "StopManager manager/hello.Printer0";
    agent.slow_step(stop, Duration::from_secs(40));
    agent.expire("hello.Printer0", "it hangs");
    agent.set_by_hand("Filter0", "gain", "7");
    tokio::time::sleep(Duration::from_secs(30)).await;
    assert_eq!(cluster.told("DriftNotAdopted"), ["system/hello"]);
    assert_eq!(cluster.stored().systems["hello"].generation, 1);
    let adopted = |s: Option<&System>| s.unwrap().metadata.generation == 2;
    cluster.until("hello", adopted).await;
    cluster.until_phase("hello", Phase::Converged).await;
    assert_eq!(gain(&agent, "Filter0"), "7");
}

#[tokio::test(start_paused = true)]
async fn what_died_is_repaired_only_once_it_is_there_again() {
    let (cluster, agent) = runs(DriftPolicy::Repair).await;
    agent.fail("Configure component/Printer0", 1_000);
    agent.set_by_hand("Printer0", "gain", "7");
    tokio::time::sleep(Duration::from_secs(6)).await;
    assert_eq!(cluster.told("Drifted"), ["component/Printer0"]);
    agent.fail("StartManager manager/hello.Printer0", 1_000);
    agent.kill("hello.Printer0");
    rounds().await;
    assert!(cluster.told("DriftRepaired").is_empty());
    agent.fail("StartManager manager/hello.Printer0", 0);
    cluster.until_phase("hello", Phase::Converged).await;
    rounds().await;
    assert_eq!(cluster.told("DriftRepaired"), ["component/Printer0"]);
}

#[tokio::test(start_paused = true)]
async fn a_component_that_was_deactivated_cannot_be_adopted_and_is_left() {
    let (cluster, agent) = runs(DriftPolicy::Adopt).await;
    agent.deactivate_by_hand("Filter0");
    rounds().await;
    let hello = cluster.system("hello").unwrap();
    assert_eq!(hello.metadata.generation, 1);
    assert_eq!(hello.status.phase, Phase::Degraded);
    assert_eq!(agent.take_done(), [""; 0]);
    assert_eq!(cluster.told("Drifted"), ["component/Filter0"]);
    insta::assert_snapshot!(condition(&hello, "Healthy").1, @"Filter0 was deactivated by hand and is left so (see rtsctl.drift)");
}

/// Its values are part of the stored system, and nothing activates what a person stopped.
#[tokio::test(start_paused = true)]
async fn the_values_of_a_component_that_was_deactivated_are_adopted() {
    let (cluster, agent) = runs(DriftPolicy::Adopt).await;
    agent.set_by_hand("Filter0", "gain", "7");
    agent.deactivate_by_hand("Filter0");
    let adopted = |s: Option<&System>| s.unwrap().metadata.generation == 2;
    cluster.until("hello", adopted).await;
    rounds().await;
    let hello = cluster.system("hello").unwrap();
    assert_eq!(hello.metadata.generation, 2);
    assert_eq!(hello.status.phase, Phase::Degraded);
    assert_eq!(agent.take_done(), [""; 0]);
    assert_eq!(gain(&agent, "Filter0"), "7");
    insta::assert_snapshot!(condition(&hello, "Healthy").1, @"Filter0 was deactivated by hand and is left so (see rtsctl.drift)");
}

/// However fast a person goes on, what was set last is what is stored and what runs.
#[tokio::test(start_paused = true)]
async fn the_last_of_many_changes_is_adopted() {
    let (cluster, agent) = runs(DriftPolicy::Adopt).await;
    for value in 101..=120 {
        agent.set_by_hand("Filter0", "gain", &value.to_string());
        tokio::task::yield_now().await;
    }
    agent.deactivate_by_hand("Printer0");
    rounds().await;
    let stored = cluster.stored().systems["hello"].spec.clone();
    assert_eq!(
        stored.components[1].configuration.sets["default"]["gain"],
        "120"
    );
    assert_eq!(gain(&agent, "Filter0"), "120");
    assert_eq!(agent.take_done(), [""; 0]);
}

#[tokio::test(start_paused = true)]
async fn another_profile_replaces_what_was_changed_by_hand() {
    let (cluster, agent) = runs(DriftPolicy::Ignore).await;
    agent.set_by_hand("Filter0", "gain", "7");
    rounds().await;
    let mut spec = hello(DriftPolicy::Ignore);
    let sets = &mut spec.components[1].configuration.sets;
    sets.insert(
        "default".into(),
        [("gain".to_owned(), "3".to_owned())].into(),
    );
    cluster.apply(spec).await;
    let hello = cluster.until_phase("hello", Phase::Converged).await;
    assert_eq!(gain(&agent, "Filter0"), "3");
    assert_eq!(condition(&hello, "Drifted").0, "False");
}

#[tokio::test(start_paused = true)]
async fn a_node_that_is_silent_for_a_while_repairs_nothing_and_tells_nothing_again() {
    let (cluster, agent) = runs(DriftPolicy::Ignore).await;
    agent.set_by_hand("Filter0", "gain", "7");
    rounds().await;
    agent.silence(true);
    rounds().await;
    agent.silence(false);
    rounds().await;
    assert_eq!(cluster.told("Drifted"), ["component/Filter0"]);
    assert_eq!(
        condition(&cluster.system("hello").unwrap(), "Drifted").0,
        "True"
    );
}

#[tokio::test(start_paused = true)]
async fn another_generation_does_not_tell_the_same_drift_again() {
    let (cluster, agent) = runs(DriftPolicy::Adopt).await;
    agent.deactivate_by_hand("Printer0");
    rounds().await;
    agent.set_by_hand("Filter0", "gain", "7");
    let adopted = |s: Option<&System>| s.unwrap().metadata.generation == 2;
    cluster.until("hello", adopted).await;
    rounds().await;
    assert_eq!(
        cluster.told("Drifted"),
        ["component/Printer0", "component/Filter0"]
    );
    assert_eq!(cluster.told("DriftRepaired"), [""; 0]);
}
