//! Optional components that cannot run now: a remark, never a refusal, and nothing that others wait for.

use std::time::Duration;

use crate::fleet::served::{request, serve};
use crate::fleet::{Cluster, systems};
use rts_controller_api::objects::{Phase, SystemStatus};
use rts_schemas::system::SystemSpec;

/// Hello with a camera that is not required, and is connected with the filter.
fn with_camera() -> SystemSpec {
    let mut spec = systems::hello();
    let mut camera = systems::component("Camera0", "Camera");
    camera.required = false;
    spec.components.push(camera);
    let to_filter = systems::connector("Camera0.out", "Filter0.in");
    spec.connectors.push(to_filter);
    spec.orders
        .activation
        .push(systems::after("Sine0", "Camera0"));
    spec
}

fn on_mars() -> SystemSpec {
    let mut spec = with_camera();
    let camera = spec.components.last_mut().unwrap();
    camera.placement.node = Some("mars".into());
    spec
}

/// What `apply` takes for "all that is required runs": nothing to do, or only lasting waits of what is optional.
fn is_done(status: &SystemStatus) -> bool {
    let optional = |w: &rts_controller_api::objects::Waiting| !w.required && !w.transient;
    match status.phase {
        Phase::Converged => true,
        Phase::Degraded => !status.waiting_on.is_empty() && status.waiting_on.iter().all(optional),
        _ => false,
    }
}

async fn until_done(cluster: &Cluster) -> SystemStatus {
    let done = |s: Option<&rts_controller_api::objects::System>| {
        s.is_some_and(|s| s.status.active == 3 && s.status.healthy && is_done(&s.status))
    };
    cluster.until("hello", done).await.unwrap().status
}

#[tokio::test(start_paused = true)]
async fn an_optional_component_without_its_module_is_tried_again_while_the_rest_runs() {
    let (cluster, agent) = Cluster::hello();
    agent.fail("Install package/Camera@local", u32::MAX);
    let applied = cluster.apply(with_camera()).await;
    assert!(applied.changed);
    let status = until_done(&cluster).await;
    let waits = status.waiting_on.iter().map(|w| w.target.as_str());
    assert!(
        waits.clone().any(|t| t == "package/Camera@local"),
        "{status:#?}"
    );
    assert!(
        !cluster.stored().systems["hello"]
            .digests
            .contains_key("Camera")
    );

    // The file is put there afterwards: it comes up by itself, and is not made twice.
    let before = agent.incarnations();
    agent.fail("Install package/Camera@local", 0);
    let all = |s: Option<&rts_controller_api::objects::System>| s.unwrap().status.active == 4;
    cluster.until("hello", all).await;
    cluster.until_phase("hello", Phase::Converged).await;
    agent.take_done();
    tokio::time::sleep(Duration::from_secs(60)).await;
    assert_eq!(agent.take_done(), [""; 0]);
    let after = agent.incarnations();
    assert!(before.iter().all(|(name, id)| after[name] == *id));
    assert_eq!(cluster.stored().systems["hello"].generation, 1);

    // Applied again, nothing is restarted so as to pin its file.
    agent.state.lock().unwrap().types.insert("Camera".into());
    let again = cluster.apply(with_camera()).await;
    assert!(!again.changed && again.plan.is_empty(), "{:#?}", again.plan);
}

#[tokio::test(start_paused = true)]
async fn a_module_that_is_gone_by_now_is_no_reason_to_restart_what_runs() {
    let (cluster, agent) = Cluster::hello();
    agent.state.lock().unwrap().types.insert("Camera".into());
    cluster.apply(with_camera()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    agent.take_done();
    agent.state.lock().unwrap().types.remove("Camera");
    let again = cluster.apply(with_camera()).await;
    assert!(!again.changed && again.plan.is_empty(), "{:#?}", again.plan);
}

#[tokio::test]
async fn a_plan_says_what_is_optional_and_missing() {
    let (cluster, _agent) = Cluster::hello();
    let served = serve(cluster).await;
    let planned = served.controller.plan(&request(with_camera())).await;
    insta::assert_snapshot!(planned.unwrap().notes.join("\n"), @"component Camera0 is optional and its module Camera was not found on node local (looked for /modules/libCamera.so, /modules/Camera.so): it is tried again, the rest runs");
    let planned = served.controller.plan(&request(on_mars())).await;
    insta::assert_snapshot!(planned.unwrap().notes.join("\n"), @"component Camera0 of system hello is to run on node mars, which is not known (known: local): it is optional and waits, the rest runs");
    // Of the same type, and required: no remark takes that away.
    let mut spec = with_camera();
    spec.components.push(systems::component("Eye0", "Camera"));
    let refused = served.refused(spec).await;
    assert!(refused.contains("component Eye0") && !refused.contains("component Camera0"));
}

#[tokio::test(start_paused = true)]
async fn an_optional_component_waits_for_a_node_that_nobody_knows() {
    let (mut cluster, agent) = Cluster::hello();
    cluster.apply(on_mars()).await;
    until_done(&cluster).await;
    agent.take_done();
    let again = cluster.apply(on_mars()).await;
    assert!(!again.changed && again.plan.is_empty(), "{:#?}", again.plan);
    assert!(!cluster.stored().systems["hello"].nodes.contains("mars"));

    // The node comes: it runs there, and the system's end needs its word from now on.
    cluster.fleet.add("mars", &["Camera"]);
    cluster.join("mars", "m1");
    let all = |s: Option<&rts_controller_api::objects::System>| s.unwrap().status.active == 4;
    cluster.until("hello", all).await;
    assert!(cluster.stored().systems["hello"].nodes.contains("mars"));
}

#[tokio::test(start_paused = true)]
async fn the_end_of_a_system_needs_no_word_of_a_node_that_nobody_knows() {
    let (cluster, _agent) = Cluster::hello();
    cluster.apply(on_mars()).await;
    until_done(&cluster).await;
    rts_controller::delete(&cluster.core, "hello", None)
        .await
        .unwrap();
    cluster.until("hello", |s| s.is_none()).await;
}

#[tokio::test(start_paused = true)]
async fn a_node_that_is_lost_and_runs_only_optional_components_refuses_no_apply() {
    let (mut cluster, _agent) = Cluster::hello();
    let mars = cluster.fleet.add("mars", &["Camera"]);
    cluster.join("mars", "m1");
    let mut spec = on_mars();
    spec.connectors.pop();
    cluster.apply(spec.clone()).await;
    cluster.until_phase("hello", Phase::Converged).await;
    let before = cluster.stored().systems["hello"].digests.clone();
    mars.silence(true);
    tokio::time::sleep(Duration::from_secs(30)).await;
    spec.components[0].execution_context.rate = Some(50.0);
    assert!(cluster.apply(spec).await.changed);
    until_done(&cluster).await;
    assert_eq!(cluster.stored().systems["hello"].digests, before);
}

#[tokio::test]
async fn a_system_of_optional_components_alone_waits_for_the_first_of_its_nodes() {
    let cluster = Cluster::start(
        crate::fleet::FakeFleet::default(),
        rts_controller::store::MemoryStore::new("cluster"),
    );
    let served = serve(cluster).await;
    let mut spec = systems::hello();
    for component in &mut spec.components {
        component.required = false;
    }
    let refused = served.refused(spec).await;
    assert!(refused.contains("node-not-ready"), "{refused}");
}
