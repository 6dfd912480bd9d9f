//! The loop on a fleet in memory: what hangs, is slow, silent, or of yesterday holds nothing else up.

use std::time::Duration;

use crate::fleet::{Cluster, systems};
use rts_controller_api::objects::{Component, Phase};
use rts_schemas::system::{Condition, PortKind, SystemSpec, WaitFor};

/// One component that is activated after 20 s.
fn slow() -> SystemSpec {
    let mut spec = systems::hello();
    spec.name = "slow".into();
    spec.full_id = "RTSystem:rtsctl:slow:1.0".into();
    spec.components = vec![systems::component("Slow0", "Printer")];
    spec.connectors.clear();
    spec.orders.activation = vec![Condition {
        target: "Slow0".into(),
        sequence: 0,
        wait: Some(WaitFor::Time {
            milliseconds: 20_000,
        }),
    }];
    spec
}

#[tokio::test(start_paused = true)]
async fn a_slow_system_holds_up_no_other_and_hides_nothing() {
    let (cluster, agent) = Cluster::hello();
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    let began = tokio::time::Instant::now();
    cluster.apply(slow()).await;
    cluster
        .until("slow", |s| {
            s.is_some_and(|s| s.status.phase == Phase::Progressing && s.status.progress.done >= 3)
        })
        .await;
    agent.kill("hello.Printer0");
    cluster
        .until("hello", |s| s.unwrap().status.phase != Phase::Converged)
        .await;
    assert!(began.elapsed() < Duration::from_secs(3), "it is seen");
    let healed = cluster.until_phase("hello", Phase::Converged).await;
    assert_eq!(healed.status.active, 3);
    assert!(began.elapsed() < Duration::from_secs(6), "and mended");
    let slow = cluster.system("slow").unwrap().status;
    assert_eq!(slow.phase, Phase::Progressing);
    cluster.until_phase("slow", Phase::Converged).await;
    assert!(began.elapsed() < Duration::from_secs(25));
}

#[tokio::test(start_paused = true)]
async fn an_unchanged_apply_does_not_call_what_is_dead_converged() {
    let (cluster, agent) = Cluster::hello();
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    agent.kill("hello.Printer0");
    let again = cluster.apply(systems::hello()).await;
    assert!(!again.changed);
    assert_ne!(again.system.status.phase, Phase::Converged);
    cluster.until_phase("hello", Phase::Converged).await;
}

#[tokio::test(start_paused = true)]
async fn a_silent_manager_is_torn_down_too() {
    let (cluster, agent) = Cluster::hello();
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    agent.hang("hello.main");
    let stuck = cluster.until_phase("hello", Phase::Degraded).await.status;
    let manager = stuck
        .waiting_on
        .iter()
        .find(|w| w.target == "manager/hello.main");
    let reason = &manager.unwrap().reason;
    assert!(reason.contains("kill -9"), "{reason}");
    agent.take_done();
    rts_controller::delete(&cluster.core, "hello", None)
        .await
        .unwrap();
    cluster.until("hello", |s| s.is_none()).await;
    assert!(agent.inventory_now().managers.is_empty());
    let done = agent.take_done();
    assert!(done.contains(&"StopManager manager/hello.main".to_owned()));
    assert!(
        !done.contains(&"Deactivate component/Sine0".to_owned()),
        "{done:?}"
    );
}

#[tokio::test(start_paused = true)]
async fn a_profile_with_service_connectors_converges_and_says_so() {
    let (cluster, _agent) = Cluster::hello();
    let mut spec = systems::hello();
    let mut service = systems::connector("Sine0.svc", "Printer0.svc");
    service.kind = PortKind::Service;
    spec.connectors.push(service);
    cluster.apply(spec).await;
    let status = cluster.until_phase("hello", Phase::Converged).await.status;
    let told = |n: &String| n.starts_with("service connector Sine0.svc-Printer0.svc");
    assert!(status.notes.iter().any(told), "{:?}", status.notes);
}

#[tokio::test(start_paused = true)]
async fn what_an_agent_holds_stays_away_and_the_status_says_why() {
    let (cluster, agent) = Cluster::hello();
    let mut spec = systems::hello();
    cluster.apply(spec.clone()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    agent.hold("Printer0", "its process ended and rtsctl.restart is never");
    agent.kill("hello.Printer0");
    let status = cluster.until_phase("hello", Phase::Degraded).await.status;
    tokio::time::sleep(Duration::from_secs(90)).await;
    assert_eq!(agent.inventory_now().managers.len(), 1, "it stays away");
    let mut waiting = status.waiting_on.iter();
    let waits = waiting.find(|w| w.target == "component/Printer0");
    assert!(waits.unwrap().reason.contains("rtsctl.restart is never"));
    let shown = cluster.component("Printer0").status.waiting_on.unwrap();
    assert!(shown.contains("rtsctl.restart is never"), "{shown}");
    // The agent frees what it holds when the system changes.
    agent.state.lock().unwrap().held.clear();
    spec.components[0].execution_context.rate = Some(50.0);
    cluster.apply(spec).await;
    cluster.until_phase("hello", Phase::Converged).await;
}

#[tokio::test(start_paused = true)]
async fn a_manager_that_is_replaced_again_and_again_waits_ever_longer() {
    let (cluster, agent) = Cluster::hello();
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    agent.expire("hello.Printer0", "on_execute has not returned for 5 s");
    cluster
        .until("hello", |s| {
            s.unwrap().status.waiting_on.iter().any(|w| w.tries == 1)
        })
        .await;
    cluster.until_phase("hello", Phase::Converged).await;
    let told = cluster.events();
    let told = told.iter().find(|e| e.spec.reason == "BackOff").unwrap();
    assert!(
        told.spec
            .message
            .contains("has not returned for 5 s; started again in 0.5 s"),
        "{}",
        told.spec.message
    );
}

#[tokio::test(start_paused = true)]
async fn a_callback_that_does_not_return_is_not_healthy() {
    let (cluster, agent) = Cluster::hello();
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    agent.change("Sine0", |c| {
        c.hangs = Some("has been in on_execute for 11 s".into());
    });
    let status = cluster.until_phase("hello", Phase::Degraded).await.status;
    assert!(!status.healthy);
    let healthy = status
        .conditions
        .iter()
        .find(|c| c.kind == "Healthy")
        .unwrap();
    assert_eq!(healthy.message, "Sine0 has been in on_execute for 11 s");
    let waits = cluster.component("Sine0").status.waiting_on;
    assert_eq!(waits.unwrap(), "has been in on_execute for 11 s");
    agent.change("Sine0", |c| c.hangs = None);
    cluster.until_phase("hello", Phase::Converged).await;
}

#[tokio::test(start_paused = true)]
async fn the_count_of_restarts_outlives_the_component() {
    let (cluster, agent) = Cluster::hello();
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    agent.change("Printer0", |c| c.restarts = 4);
    cluster.core.refresh().await;
    let before = cluster.component("Printer0").status;
    agent.fail("Create component/Printer0", 3);
    agent.kill("hello.Printer0");
    cluster.until_phase("hello", Phase::Degraded).await;
    let absent: Component = cluster.component("Printer0");
    assert_eq!(absent.status.state, "Unknown");
    assert_eq!(absent.status.restarts, 4);
    assert_eq!(absent.status.incarnation, before.incarnation);
}

#[tokio::test(start_paused = true)]
async fn a_failure_of_an_old_generation_blocks_nothing() {
    let (cluster, agent) = Cluster::hello();
    agent.fail("Create component/Printer0", 1);
    agent.slow(Duration::from_millis(300));
    cluster.apply(systems::hello()).await;
    cluster
        .until("hello", |s| {
            let running = &s.unwrap().status.progress.running;
            running.contains(&"Create component/Printer0".to_owned())
        })
        .await;
    let mut spec = systems::hello();
    spec.components[0].execution_context.rate = Some(50.0);
    cluster.apply(spec).await;
    cluster
        .until("hello", |_| {
            cluster
                .events()
                .iter()
                .any(|e| e.spec.reason == "CreateFailed")
        })
        .await;
    assert!(cluster.core.backoff().failing().next().is_none());
    cluster.until_phase("hello", Phase::Converged).await;
}

#[tokio::test(start_paused = true)]
async fn one_answer_that_does_not_come_makes_no_node_unknown() {
    let (cluster, agent) = Cluster::hello();
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    let mut changes = cluster.core.view.subscribe();
    agent.silence(true);
    cluster.core.wake.notify_one();
    tokio::time::sleep(Duration::from_millis(2600)).await;
    agent.silence(false);
    let mut phases = Vec::new();
    let watch = async {
        loop {
            phases.push(cluster.system("hello").unwrap().status.phase);
            assert_eq!(cluster.component("Sine0").status.state, "Active");
            changes.changed().await.unwrap();
        }
    };
    let _ = tokio::time::timeout(Duration::from_secs(4), watch).await;
    assert!(!phases.contains(&Phase::Degraded), "{phases:?}");
    assert_eq!(phases.last(), Some(&Phase::Converged));
}

#[tokio::test(start_paused = true)]
async fn a_wait_longer_than_the_usual_deadline_is_waited_out() {
    let (cluster, agent) = Cluster::hello();
    let mut spec = slow();
    spec.orders.activation[0].wait = Some(WaitFor::Time {
        milliseconds: 90_000,
    });
    cluster.apply(spec).await;
    cluster.until_phase("slow", Phase::Converged).await;
    let done = agent.take_done();
    let creations = done.iter().filter(|d| d.starts_with("Create")).count();
    assert_eq!(creations, 1, "in one run");
    let skipped = cluster
        .events()
        .iter()
        .any(|e| e.spec.reason == "ActivateFailed");
    assert!(!skipped);
}

#[tokio::test(start_paused = true)]
async fn results_that_were_lost_on_the_way_are_asked_for_again() {
    let (cluster, agent) = Cluster::hello();
    agent.state.lock().unwrap().lost_results = 2;
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    let done = agent.take_done();
    let creations = done.iter().filter(|d| d.starts_with("Create")).count();
    assert_eq!(creations, 3, "nothing was done twice: {done:?}");
    assert_eq!(agent.state.lock().unwrap().batches.len(), 1);
}

/// Printer0 died and its policy is never.
async fn held() -> (Cluster, std::sync::Arc<crate::fleet::FakeAgent>) {
    let (cluster, agent) = Cluster::hello();
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    agent.hold(
        "Printer0",
        "it ended by itself; apply a change to have it start",
    );
    agent.kill("hello.Printer0");
    cluster.until_phase("hello", Phase::Degraded).await;
    (cluster, agent)
}

fn back_offs(cluster: &Cluster) -> Vec<String> {
    let events = cluster.events().into_iter();
    let found = events.filter(|e| e.spec.reason == "BackOff");
    found.map(|e| e.spec.message).collect()
}

#[tokio::test(start_paused = true)]
async fn what_was_held_and_torn_down_did_not_die_when_it_is_applied_again() {
    let (cluster, agent) = held().await;
    rts_controller::delete(&cluster.core, "hello", None)
        .await
        .unwrap();
    cluster.until("hello", |s| s.is_none()).await;
    agent.state.lock().unwrap().held.clear();
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    assert_eq!(back_offs(&cluster), Vec::<String>::new());
}

#[tokio::test(start_paused = true)]
async fn what_is_no_longer_held_is_started_without_delay() {
    let (cluster, agent) = held().await;
    tokio::time::sleep(Duration::from_secs(10)).await;
    {
        let mut state = agent.state.lock().unwrap();
        state.held.clear();
        state.revision += 1;
    }
    cluster.until_phase("hello", Phase::Converged).await;
    assert_eq!(back_offs(&cluster), Vec::<String>::new());
}

#[tokio::test(start_paused = true)]
async fn an_apply_is_judged_by_what_was_seen_after_its_agents_took_it() {
    let (cluster, agent) = held().await;
    agent.state.lock().unwrap().lets_go = true;
    let mut changed = systems::hello();
    changed.components[2].execution_context.rate = Some(25.0);
    cluster.apply(changed).await;
    cluster
        .until("hello", |s| {
            let s = s.unwrap();
            let judged = s.status.observed_generation == 2;
            assert!(
                !judged || s.status.phase != Phase::Degraded,
                "{:?}",
                s.status
            );
            judged && s.status.phase == Phase::Converged
        })
        .await;
    assert_eq!(back_offs(&cluster), Vec::<String>::new());
}

#[tokio::test(start_paused = true)]
async fn what_is_held_is_said_again_when_the_same_is_applied() {
    let (cluster, _agent) = held().await;
    let result = cluster.apply(systems::hello()).await;
    assert!(!result.changed);
    let planned = result.plan.waiting_on.iter();
    let planned = planned.map(|w| (w.target.as_str(), w.reason.as_str()));
    let status = result.system.status.waiting_on.iter();
    let status = status.map(|w| (w.target.as_str(), w.reason.as_str()));
    let said = (
        "component/Printer0",
        "it ended by itself; apply a change to have it start",
    );
    assert!(planned.into_iter().any(|w| w == said));
    assert!(status.into_iter().any(|w| w == said));
    assert_eq!(result.system.status.phase, Phase::Degraded);
}

#[tokio::test(start_paused = true)]
async fn a_controller_whose_loop_is_stuck_gives_no_sign_of_life() {
    let fleet = crate::fleet::FakeFleet::default();
    let agent = fleet.add("local", &[]);
    // A controller whose loop does not run.
    let core = crate::fleet::core(&fleet, &rts_controller::store::MemoryStore::new("cluster"));
    rts_controller::greet(&core, "local", crate::fleet::greeting(&agent, "s1")).unwrap();
    let beat = || {
        let beat = rts_agent_api::session::Heartbeat {
            inventory_revision: 1,
            delta: None,
            events: Vec::new(),
        };
        rts_controller::heartbeat(&core, "local", "s1", beat)
    };
    tokio::time::sleep(Duration::from_secs(14)).await;
    beat().unwrap();
    tokio::time::sleep(Duration::from_secs(2)).await;
    let refused = beat().unwrap_err();
    assert_eq!(
        (refused.status, refused.code.as_str(), refused.retryable),
        (503, "reconcile-stuck", true)
    );
    let refused = rts_controller::greet(&core, "local", crate::fleet::greeting(&agent, "s1"));
    assert_eq!(refused.unwrap_err().code, "reconcile-stuck");
    tokio::spawn(rts_controller::Reconciler::new(std::sync::Arc::clone(&core)).run());
    tokio::time::sleep(Duration::from_millis(100)).await;
    beat().unwrap();
    for _ in 0..60 {
        tokio::time::sleep(Duration::from_secs(1)).await;
        beat().unwrap();
    }
}
