//! An apply that relies on what its user has seen: on nothing else being changed meanwhile, and on nothing restarting.

use crate::fleet::served::{Served, problem, request, serve, text};
use crate::fleet::{Cluster, systems};
use rts_controller_api::objects::Phase;
use rts_controller_api::requests::{ApplyRequest, ApplyResult, Expect};
use rts_schemas::system::SystemSpec;

fn valued(value: &str) -> SystemSpec {
    let mut spec = systems::hello();
    let sets = &mut spec.components[0].configuration.sets;
    sets.insert(
        "default".into(),
        [("gain".to_owned(), value.to_owned())].into(),
    );
    spec
}

fn expecting(spec: SystemSpec, expect: Expect) -> ApplyRequest {
    ApplyRequest {
        expect,
        ..request(spec)
    }
}

fn at(index: u64) -> Expect {
    Expect {
        index: Some(index),
        ..Expect::default()
    }
}

fn no_restart() -> Expect {
    Expect {
        no_restart: true,
        ..Expect::default()
    }
}

async fn hello() -> (Served, std::sync::Arc<crate::fleet::FakeAgent>) {
    let (cluster, agent) = Cluster::hello();
    let served = serve(cluster).await;
    apply(&served, request(systems::hello())).await;
    served.until_converged("hello").await;
    (served, agent)
}

async fn apply(served: &Served, request: ApplyRequest) -> ApplyResult {
    served.controller.apply(&request).await.unwrap()
}

/// What a person reviews, and what comes back to be applied.
async fn reviewed(served: &Served, spec: SystemSpec) -> ApplyRequest {
    let planned = served
        .controller
        .plan(&request(spec.clone()))
        .await
        .unwrap();
    let expect = Expect {
        index: Some(planned.index),
        digest: Some(planned.digest),
        no_restart: false,
        max_stand_ins: None,
    };
    expecting(spec, expect)
}

/// Refused in the same way by a plan and by an apply, and nothing is stored.
async fn refused(served: &Served, request: &ApplyRequest) -> rts_controller_api::Problem {
    let before = served.cluster.stored();
    let planned = problem(served.controller.plan(request).await);
    let applied = problem(served.controller.apply(request).await);
    assert_eq!(planned, applied);
    assert_eq!(served.cluster.stored().systems, before.systems);
    applied
}

#[tokio::test]
async fn a_reviewed_plan_is_applied_when_nothing_came_between() {
    let (cluster, _agent) = Cluster::hello();
    let served = serve(cluster).await;
    // Also the first of a system, which has no identity yet.
    let first = reviewed(&served, systems::hello()).await;
    assert_eq!(first.expect.index, Some(0));
    assert!(apply(&served, first.clone()).await.changed);
    served.until_converged("hello").await;
    let again = refused(&served, &first).await;
    assert_eq!((again.status, again.code.as_str()), (409, "stale-plan"));
    let next = reviewed(&served, valued("2")).await;
    assert!(apply(&served, next).await.changed);
}

#[tokio::test]
async fn another_apply_in_between_makes_a_plan_stale() {
    let (served, _agent) = hello().await;
    let reviewed = reviewed(&served, valued("2")).await;
    apply(&served, request(valued("3"))).await;
    served.until_converged("hello").await;
    let refused = refused(&served, &reviewed).await;
    insta::assert_snapshot!("stale_by_another_apply", text(&refused));
}

#[tokio::test]
async fn a_process_that_died_in_between_makes_a_plan_stale() {
    let (served, agent) = hello().await;
    let reviewed = reviewed(&served, valued("2")).await;
    agent.fail("StartManager manager/hello.Printer0", 1_000);
    agent.kill("hello.Printer0");
    let refused = refused(&served, &reviewed).await;
    insta::assert_snapshot!("stale_by_a_death", text(&refused));
    let reviewed = self::reviewed(&served, valued("2")).await;
    assert_eq!(reviewed.expect.index, Some(1), "nothing was stored");
}

/// Waits until a target has failed and is not tried again at once.
async fn until_in_back_off(served: &Served, target: &str) {
    let waits = |s: Option<&rts_controller_api::objects::System>| {
        let waiting = &s.unwrap().status.waiting_on;
        let own = waiting.iter().find(|w| w.target == target);
        own.is_some_and(|w| w.next_try.is_some())
    };
    served.cluster.until("hello", waits).await;
}

#[tokio::test]
async fn what_waits_for_its_next_try_is_restarted_by_a_change_and_so_refused() {
    let (served, agent) = hello().await;
    // Sine0 moves to a process of its own: it is stopped, and cannot be stopped yet.
    let mut spec = valued("1");
    spec.components[0].placement.isolated = true;
    agent.fail("Deactivate component/Sine0", 1_000);
    apply(&served, request(spec.clone())).await;
    until_in_back_off(&served, "component/Sine0").await;
    for value in ["2", "3"] {
        let sets = &mut spec.components[0].configuration.sets;
        let set = sets.entry("default".into()).or_default();
        set.insert("gain".into(), value.into());
        let refused = refused(&served, &expecting(spec.clone(), no_restart())).await;
        assert_eq!(
            (refused.status, refused.code.as_str()),
            (409, "would-restart")
        );
    }
}

#[tokio::test]
async fn the_next_try_of_what_failed_makes_no_other_plan() {
    let (served, agent) = hello().await;
    agent.fail("StartManager manager/hello.Printer0", 1_000);
    agent.kill("hello.Printer0");
    until_in_back_off(&served, "manager/hello.Printer0").await;
    // Its connector is cut with the second try at the latest; then it is tried every few seconds.
    tokio::time::sleep(std::time::Duration::from_millis(1_800)).await;
    let mut digests = std::collections::BTreeSet::new();
    for _ in 0..20 {
        tokio::time::sleep(std::time::Duration::from_millis(150)).await;
        let planned = served.controller.plan(&request(valued("2"))).await.unwrap();
        let mut steps = planned.plan.steps.iter();
        let starts = |s: &rts_plan::plan::Step| s.target == "manager/hello.Printer0";
        assert!(steps.any(starts), "{:#?}", planned.plan);
        digests.insert(planned.digest);
    }
    assert_eq!(digests.len(), 1);
    let reviewed = reviewed(&served, valued("2")).await;
    assert!(apply(&served, reviewed).await.changed);
}

#[tokio::test]
async fn what_another_system_restarts_is_no_restart_of_this_one() {
    let (served, agent) = hello().await;
    let mut other = systems::hello();
    other.name = "hello2".into();
    other.full_id = "RTSystem:rtsctl:other:1.0".into();
    other.components = vec![systems::component("Other0", "Printer")];
    other.connectors.clear();
    other.orders = Default::default();
    apply(&served, request(other.clone())).await;
    served.until_converged("hello2").await;
    agent.fail("Deactivate component/Other0", 1_000);
    other.components[0].type_name = "LowPassFilter".into();
    agent.slow_step(
        "Deactivate component/Other0",
        std::time::Duration::from_secs(5),
    );
    apply(&served, request(other)).await;
    let planned = served.controller.plan(&request(valued("2"))).await.unwrap();
    let restarts = planned.plan.changes.iter();
    let restarts: Vec<_> = restarts
        .filter(|c| c.action == rts_plan::plan::Action::Restart)
        .map(|c| c.target.as_str())
        .collect();
    assert!(restarts.contains(&"component/Other0"), "{restarts:?}");
    let calm = expecting(valued("2"), no_restart());
    assert!(apply(&served, calm).await.changed);
}

#[tokio::test]
async fn what_is_stored_and_moves_nothing_is_planned_and_reviewed_too() {
    let (served, agent) = hello().await;
    agent.take_done();
    let mut spec = systems::hello();
    spec.components[0].policy.restart = rts_schemas::system::RestartPolicy::Never;
    spec.components[1].required = false;
    spec.orders = Default::default();
    let planned = served
        .controller
        .plan(&request(spec.clone()))
        .await
        .unwrap();
    insta::assert_snapshot!("stored_only", rts_plan::render(&planned.plan));
    assert!(planned.plan.steps.is_empty());
    let reviewed = reviewed(&served, spec.clone()).await;
    let mut edited = reviewed.clone();
    edited.spec.components[0].policy.reset_on_error = true;
    let refused = refused(&served, &edited).await;
    assert_eq!(refused.code, "stale-plan");
    assert!(apply(&served, reviewed).await.changed);
    served.until_converged("hello").await;
    let again = apply(&served, request(spec)).await;
    assert!(!again.changed && again.plan.is_empty());
    assert_eq!(agent.take_done(), [""; 0]);
}

#[tokio::test]
async fn what_goes_on_in_another_system_makes_no_plan_stale() {
    let (served, agent) = hello().await;
    let mut other = systems::hello();
    other.name = "other".into();
    other.full_id = "RTSystem:rtsctl:other:1.0".into();
    other.components = vec![systems::component("Other0", "Printer")];
    other.connectors.clear();
    other.orders = Default::default();
    apply(&served, request(other)).await;
    served.until_converged("other").await;
    let reviewed = reviewed(&served, valued("2")).await;
    agent.fail("StartManager manager/other.main", 1_000);
    agent.kill("other.main");
    let planned = served.controller.plan(&reviewed).await.unwrap();
    assert!(
        planned
            .plan
            .changes
            .iter()
            .any(|c| c.target == "component/Other0")
    );
    assert!(apply(&served, reviewed).await.changed);
}

#[tokio::test]
async fn what_would_restart_is_refused_and_named() {
    let (served, agent) = hello().await;
    let calm = expecting(valued("2"), no_restart());
    assert!(apply(&served, calm).await.changed);
    served.until_converged("hello").await;
    let before = agent.incarnations();
    let mut spec = valued("2");
    spec.components[0].placement.isolated = true;
    spec.components[2].type_name = "LowPassFilter".into();
    let refused = refused(&served, &expecting(spec, no_restart())).await;
    let pids = regex_free(&text(&refused));
    insta::assert_snapshot!("would_restart", pids);
    assert_eq!(agent.incarnations(), before);
}

/// Without the numbers of processes.
fn regex_free(text: &str) -> String {
    let mut parts = text.split("pid ");
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        out.push_str("pid N");
        out.push_str(part.trim_start_matches(|c: char| c.is_ascii_digit()));
    }
    out
}

#[tokio::test]
async fn an_index_names_one_change_also_after_a_teardown_and_a_restart() {
    let (served, _agent) = hello().await;
    let index = async |served: &Served| {
        let plan: rts_controller_api::requests::PlanResult =
            served.http.get("/v1/systems/hello/plan").await.unwrap();
        let shown = served.cluster.system("hello").unwrap().status.check_index;
        assert_eq!(plan.index, shown);
        shown
    };
    assert_eq!(index(&served).await, 1);
    let same = apply(&served, request(systems::hello())).await;
    assert_eq!((same.changed, same.index), (false, 1));
    let changed = apply(&served, request(valued("2"))).await;
    assert_eq!((changed.index, index(&served).await), (2, 2));
    let chained = apply(&served, expecting(valued("3"), at(changed.index))).await;
    assert_eq!(chained.index, 3);
    served.controller.delete("hello").await.unwrap();
    assert_eq!(
        served.cluster.system("hello").unwrap().status.check_index,
        4
    );
    served.cluster.until("hello", |s| s.is_none()).await;

    let none = served.controller.plan(&request(valued("3"))).await.unwrap();
    assert_eq!(none.index, 0);
    let cluster = served.cluster.restart().await;
    let mut cluster = cluster;
    cluster.join("local", "s2");
    let served = serve(cluster).await;
    let again = apply(&served, expecting(valued("3"), at(0))).await;
    assert_eq!(again.index, 5);
    let stale = refused(&served, &expecting(valued("1"), at(3))).await;
    assert_eq!(stale.code, "stale-plan");
    assert!(stale.detail.contains("is at index 5 now"), "{stale:?}");
}

#[tokio::test]
async fn targets_change_their_part_alone() {
    let (served, _agent) = hello().await;
    let mut spec = valued("2");
    let other = &mut spec.components[1].configuration.sets;
    other.insert(
        "default".into(),
        [("alpha".to_owned(), "9".to_owned())].into(),
    );
    let of = |targets: &[&str]| ApplyRequest {
        targets: targets.iter().map(|t| (*t).to_owned()).collect(),
        ..request(spec.clone())
    };
    let targeted = of(&["component/Sine0"]);
    let planned = served.controller.plan(&targeted).await.unwrap().plan;
    let changes: Vec<_> = planned.changes.iter().map(|c| c.target.as_str()).collect();
    assert_eq!(changes, ["component/Sine0"]);
    apply(&served, targeted).await;
    served.until_converged("hello").await;
    let stored = &served.cluster.stored().systems["hello"].spec;
    assert_eq!(**stored, valued("2"));
    let unknown = refused(&served, &of(&["component/Snie0"])).await;
    insta::assert_snapshot!("unknown_target", text(&unknown));
}

#[tokio::test]
async fn a_target_of_another_system_is_refused_as_all_of_it_is() {
    let (served, _agent) = hello().await;
    let mut spec = valued("2");
    spec.full_id = "RTSystem:somebody:else:1.0".into();
    let targeted = ApplyRequest {
        targets: vec!["Sine0".into()],
        ..request(spec)
    };
    assert_eq!(refused(&served, &targeted).await.code, "other-system");
}

#[tokio::test(start_paused = true)]
async fn of_two_applies_on_one_index_one_is_stale() {
    let (cluster, _agent) = Cluster::hello();
    cluster.apply(systems::hello()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    let one = expecting(valued("2"), at(1));
    let two = expecting(valued("3"), at(1));
    let (one, two) = tokio::join!(
        rts_controller::apply(&cluster.core, "hello", one, None),
        rts_controller::apply(&cluster.core, "hello", two, None),
    );
    let codes: Vec<_> = [one, two]
        .into_iter()
        .filter_map(|result| Some(result.err()?.code))
        .collect();
    assert_eq!(codes, ["stale-plan"]);
}
