//! The loop on a fleet in memory, in paused time.

use std::time::Duration;

use crate::fleet::{Cluster, systems};
use rts_controller_api::objects::{Connector, Kind, Node, Phase};
use rts_controller_api::requests::{ApplyRequest, Expect};

#[tokio::test(start_paused = true)]
async fn an_applied_system_converges_and_applying_it_again_changes_nothing() {
    let (cluster, agent) = Cluster::hello();
    let applied = cluster.apply(systems::hello()).await;
    assert!(applied.changed && !applied.plan.steps.is_empty());
    let system = cluster.until_phase("hello", Phase::Converged).await;
    assert!(system.status.synced && system.status.healthy);
    assert_eq!((system.status.active, system.status.components), (3, 3));
    assert_eq!(system.metadata.generation, 1);
    assert!(system.status.waiting_on.is_empty());
    assert_eq!(cluster.component("Sine0").status.state, "Active");
    assert_eq!(cluster.component("Printer0").status.manager, "Printer0");
    let connectors = cluster.core.view.list::<Connector>().items;
    assert!(connectors.iter().all(|c| c.status.state == "Connected") && connectors.len() == 2);

    agent.take_done();
    let again = cluster.apply(systems::hello()).await;
    assert!(!again.changed && again.plan.is_empty());
    tokio::time::sleep(Duration::from_secs(30)).await;
    assert_eq!(cluster.system("hello").unwrap().metadata.generation, 1);
    assert!(agent.take_done().is_empty(), "nothing restarts");
}

#[tokio::test(start_paused = true)]
async fn the_activation_order_is_kept_and_told_as_events() {
    let (cluster, agent) = Cluster::hello();
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    let done = agent.take_done();
    let activations: Vec<_> = done.iter().filter(|d| d.starts_with("Activate")).collect();
    assert_eq!(
        activations,
        [
            "Activate component/Printer0",
            "Activate component/Filter0",
            "Activate component/Sine0"
        ]
    );
    let events = cluster.events();
    let told = |reason: &str| events.iter().filter(|e| e.spec.reason == reason).count();
    assert_eq!(
        (told("Applied"), told("Created"), told("Activated")),
        (1, 3, 3)
    );
    assert_eq!(told("Connected"), 2);
}

#[tokio::test(start_paused = true)]
async fn a_failing_step_degrades_its_system_backs_off_and_heals() {
    let (cluster, agent) = Cluster::hello();
    agent.fail("Create component/Printer0", 3);
    cluster.apply(systems::hello()).await;
    let system = cluster.until_phase("hello", Phase::Degraded).await;
    assert!(!system.status.synced && !system.status.healthy);
    let waiting = &system.status.waiting_on;
    let printer = waiting
        .iter()
        .find(|w| w.target == "component/Printer0")
        .unwrap();
    assert_eq!((printer.tries, printer.required), (1, true));
    assert!(printer.reason.contains("was told to fail") && printer.next_try.is_some());
    let shown = cluster.component("Printer0").status;
    assert_eq!(shown.state, "Unknown");
    assert!(shown.waiting_on.unwrap().starts_with("not created yet: "));

    let began = tokio::time::Instant::now();
    let system = cluster.until_phase("hello", Phase::Converged).await;
    // 0.5 s, 1 s, 2 s: no chance in this test.
    let took = began.elapsed();
    assert!(
        took >= Duration::from_millis(3500) && took < Duration::from_millis(3700),
        "{took:?}"
    );
    assert!(system.status.waiting_on.is_empty());
    let events = cluster.events();
    assert_eq!(
        events
            .iter()
            .filter(|e| e.spec.reason == "CreateFailed")
            .count(),
        3
    );
}

#[tokio::test(start_paused = true)]
async fn a_new_generation_tries_at_once_what_failed() {
    let (cluster, agent) = Cluster::hello();
    agent.fail("Create component/Printer0", 6);
    cluster.apply(systems::hello()).await;
    // After the sixth failure the next try is 16 s away.
    cluster
        .until("hello", |s| {
            s.unwrap().status.waiting_on.iter().any(|w| w.tries == 6)
        })
        .await;
    let began = tokio::time::Instant::now();
    let mut spec = systems::hello();
    spec.components[0].execution_context.rate = Some(50.0);
    assert_eq!(cluster.apply(spec).await.system.metadata.generation, 2);
    cluster.until_phase("hello", Phase::Converged).await;
    assert!(began.elapsed() < Duration::from_secs(1));
}

#[tokio::test(start_paused = true)]
async fn a_component_that_is_not_required_degrades_but_says_so() {
    let (cluster, agent) = Cluster::hello();
    agent.fail("LoadModule module/Printer@hello.Printer0", u32::MAX);
    let mut spec = systems::hello();
    spec.components[2].required = false;
    spec.orders = rts_schemas::system::Orders::default();
    cluster.apply(spec).await;
    let system = cluster.until_phase("hello", Phase::Degraded).await;
    assert_eq!(system.status.active, 2, "the rest comes up");
    assert!(
        system.status.waiting_on.iter().all(|w| !w.required),
        "{:#?}",
        system.status
    );
}

#[tokio::test(start_paused = true)]
async fn a_silent_node_is_unknown_keeps_its_last_state_and_comes_back_untouched() {
    let (cluster, agent) = Cluster::hello();
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    agent.take_done();
    agent.silence(true);
    cluster.until("hello", |s| !s.unwrap().status.synced).await;
    tokio::time::sleep(Duration::from_secs(4)).await;
    let node = cluster.core.view.get::<Node>("local").unwrap();
    assert_eq!(node.status.state, "Unknown");
    let sine = cluster.component("Sine0").status;
    assert_eq!(
        (sine.state.as_str(), sine.last_known_state.as_deref()),
        ("Unknown", Some("Active"))
    );
    let system = cluster.system("hello").unwrap();
    assert_eq!(system.status.phase, Phase::Degraded);
    assert!(
        system
            .status
            .waiting_on
            .iter()
            .any(|w| w.target == "node/local")
    );

    agent.silence(false);
    cluster.until_phase("hello", Phase::Converged).await;
    assert!(agent.take_done().is_empty(), "healthy work is left alone");
}

#[tokio::test(start_paused = true)]
async fn a_dead_manager_starts_again_after_a_short_delay_and_a_dying_one_ever_later() {
    let (cluster, agent) = Cluster::hello();
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    let sine = cluster.component("Sine0").status.incarnation;
    let mut delays = Vec::new();
    for _ in 0..3 {
        agent.kill("hello.Printer0");
        let began = tokio::time::Instant::now();
        cluster.until("hello", |s| !s.unwrap().status.healthy).await;
        cluster.until_phase("hello", Phase::Converged).await;
        delays.push(began.elapsed().as_secs_f64());
    }
    // Seen with the next heartbeat (up to 1 s), then 0.5 s, 1 s, 2 s.
    assert!(delays[0] >= 0.5 && delays[0] <= 1.6, "{delays:?}");
    assert!(delays[2] >= 2.0 && delays[2] <= 3.1, "{delays:?}");
    let now = cluster.component("Sine0").status.incarnation;
    assert_eq!(now, sine, "only that process was disturbed");
}

#[tokio::test(start_paused = true)]
async fn a_deleted_system_is_taken_down_then_forgotten() {
    let (cluster, agent) = Cluster::hello();
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    agent.slow(Duration::from_millis(100));
    let system = rts_controller::delete(&cluster.core, "hello", None)
        .await
        .unwrap();
    assert_eq!(system.status.phase, Phase::Terminating);
    let request = ApplyRequest {
        spec: systems::hello(),
        replace: true,
        targets: Vec::new(),
        expect: Expect::default(),
    };
    let refused = rts_controller::apply(&cluster.core, "hello", request, None).await;
    assert_eq!(refused.unwrap_err().code, "terminating");
    let version = cluster.core.view.revision();
    cluster.until("hello", |s| s.is_none()).await;
    assert!(agent.inventory_now().managers.is_empty(), "nothing is left");
    assert!(cluster.stored().systems.is_empty());
    let (changes, _) = cluster.core.view.changes(Kind::System, version).unwrap();
    assert!(
        changes
            .last()
            .unwrap()
            .json(true)
            .starts_with(r#"{"type":"DELETED""#)
    );
    tokio::time::sleep(Duration::from_secs(6)).await;
    let spec = agent.state.lock().unwrap().spec.clone().unwrap();
    assert!(spec.spec.systems.is_empty(), "the empty set was sent too");
}

#[tokio::test(start_paused = true)]
async fn an_unknown_node_keeps_a_system_terminating() {
    let (cluster, agent) = Cluster::hello();
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    agent.silence(true);
    tokio::time::sleep(Duration::from_secs(5)).await;
    rts_controller::delete(&cluster.core, "hello", None)
        .await
        .unwrap();
    tokio::time::sleep(Duration::from_secs(60)).await;
    let system = cluster.system("hello").unwrap();
    assert_eq!(system.status.phase, Phase::Terminating);
    assert!(
        system
            .status
            .waiting_on
            .iter()
            .any(|w| w.target == "node/local")
    );
    agent.silence(false);
    cluster.until("hello", |s| s.is_none()).await;
}

#[tokio::test(start_paused = true)]
async fn a_restarted_controller_goes_on_from_its_store_and_disturbs_nothing() {
    let (cluster, agent) = Cluster::hello();
    cluster.apply(systems::hello()).await;
    let before = cluster.until_phase("hello", Phase::Converged).await;
    let version = cluster.core.view.revision();
    agent.take_done();
    let mut cluster = cluster.restart().await;
    let system = cluster.system("hello").unwrap();
    assert_eq!(system.metadata.uid, before.metadata.uid);
    assert_ne!(
        system.status.phase,
        Phase::Converged,
        "nothing is known yet"
    );
    assert!(
        cluster.core.view.revision() > version,
        "revisions never go back"
    );
    assert_eq!(
        cluster
            .core
            .view
            .changes(Kind::System, version)
            .unwrap_err()
            .status,
        410
    );
    cluster.join("local", "s1");
    cluster.until_phase("hello", Phase::Converged).await;
    assert!(agent.take_done().is_empty());
    assert_eq!(cluster.stored().nodes["local"].generation, 1);
}

#[tokio::test(start_paused = true)]
async fn an_apply_during_a_run_cancels_what_has_not_started() {
    let (cluster, agent) = Cluster::hello();
    agent.slow(Duration::from_millis(200));
    cluster.apply(systems::hello()).await;
    cluster
        .until("hello", |s| s.unwrap().status.progress.done >= 2)
        .await;
    let mut spec = systems::hello();
    spec.components.truncate(2);
    spec.connectors.truncate(1);
    spec.orders.activation.remove(0);
    cluster.apply(spec).await;
    cluster.until_phase("hello", Phase::Converged).await;
    let done = agent.take_done();
    assert!(
        !done.contains(&"Activate component/Printer0".to_owned()),
        "{done:?}"
    );
    assert!(
        cluster.core.backoff().failing().next().is_none(),
        "a cancelled step is no failure"
    );
}

#[tokio::test(start_paused = true)]
async fn steps_of_two_nodes_wait_for_each_other() {
    let (mut cluster, agent) = Cluster::hello();
    let other = cluster.fleet.add("other", &["Printer"]);
    cluster.join("other", "t1");
    let mut spec = systems::hello();
    spec.components[2].placement.node = Some("other".into());
    spec.connectors.truncate(1);
    other.slow(Duration::from_millis(300));
    cluster.apply(spec).await;
    let system = cluster.until_phase("hello", Phase::Converged).await;
    assert_eq!(system.status.active, 3);
    assert!(
        other
            .take_done()
            .contains(&"Activate component/Printer0".to_owned())
    );
    let done = agent.take_done();
    assert_eq!(done.last().unwrap(), "Activate component/Sine0");
    rts_controller::delete(&cluster.core, "hello", None)
        .await
        .unwrap();
    cluster.until("hello", |s| s.is_none()).await;
}

#[tokio::test(start_paused = true)]
async fn the_loss_of_an_agent_ends_its_steps_at_once() {
    let (cluster, agent) = Cluster::hello();
    agent.slow(Duration::from_secs(50));
    cluster.apply(systems::hello()).await;
    cluster
        .until("hello", |s| !s.unwrap().status.progress.running.is_empty())
        .await;
    let began = tokio::time::Instant::now();
    agent.silence(true);
    cluster
        .until("hello", |s| s.unwrap().status.progress.running.is_empty())
        .await;
    assert!(began.elapsed() < Duration::from_secs(5));
}

#[tokio::test(start_paused = true)]
async fn progress_is_shown_and_counters_raise_no_version() {
    let (cluster, agent) = Cluster::hello();
    agent.slow(Duration::from_millis(100));
    cluster.apply(systems::hello()).await;
    let found = cluster
        .until("hello", |s| s.unwrap().status.progress.done == 3)
        .await
        .unwrap();
    assert_eq!(found.status.phase, Phase::Progressing);
    assert!(found.status.progress.total > 8 && found.status.progress.running.len() <= 8);
    cluster.until_phase("hello", Phase::Converged).await;
    let version = cluster.core.view.revision();
    agent.count();
    cluster.core.refresh().await;
    assert_eq!(cluster.component("Sine0").status.executions, 1);
    assert_eq!(cluster.core.view.revision(), version);
}

#[tokio::test(start_paused = true)]
async fn what_nobody_will_try_again_has_no_next_try() {
    let (cluster, agent) = Cluster::hello();
    agent.fail("Activate component/Printer0", 1);
    agent.ends_in_error("Printer0");
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Degraded).await;
    tokio::time::sleep(Duration::from_secs(30)).await;
    let status = cluster.system("hello").unwrap().status;
    let printer = status
        .waiting_on
        .iter()
        .find(|w| w.target == "component/Printer0");
    let printer = printer.unwrap();
    assert_eq!(printer.next_try, None);
    assert!(printer.reason.starts_with("in Error"), "{}", printer.reason);
    assert_eq!(status.phase, Phase::Degraded);
}

#[tokio::test(start_paused = true)]
async fn a_node_that_greets_again_in_its_old_session_is_said_to_be_back() {
    let (cluster, agent) = Cluster::hello();
    assert_eq!(cluster.told("NodeReady").len(), 1);
    let greet =
        || rts_controller::greet(&cluster.core, "local", crate::fleet::greeting(&agent, "s1"));
    greet().unwrap();
    assert_eq!(cluster.told("NodeReady").len(), 1, "it was not away");
    agent.silence(true);
    tokio::time::sleep(Duration::from_secs(5)).await;
    assert_eq!(cluster.told("NodeUnknown").len(), 1);
    greet().unwrap();
    assert_eq!(cluster.told("NodeReady").len(), 2);
}
