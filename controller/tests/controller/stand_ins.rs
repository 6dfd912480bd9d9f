//! Stand-ins are decided when a system is applied, and stay until it is applied again.

use crate::fleet::served::{problem, request, serve};
use crate::fleet::{Cluster, systems};
use rts_controller_api::objects::{Component, Phase};
use rts_schemas::system::{ExecutionKind, StandIn, SystemSpec};

/// Hello with a camera whose module no node has.
fn with_camera(when: Option<StandIn>) -> SystemSpec {
    let mut spec = systems::hello();
    let mut camera = systems::component("Camera0", "Camera");
    camera.stand_in.when = when;
    spec.components.push(camera);
    let mut to_filter = systems::connector("Camera0.out", "Filter0.in");
    to_filter.data_type = Some("IDL:RTC/TimedDouble:1.0".into());
    spec.connectors.push(to_filter);
    spec
}

/// Names of the components that are stand-ins.
fn stand_ins(cluster: &Cluster) -> Vec<String> {
    let all = cluster.core.view.list::<Component>();
    let stand_ins = all.items.into_iter().filter(|c| c.status.stand_in);
    stand_ins.map(|c| c.metadata.name).collect()
}

#[tokio::test(start_paused = true)]
async fn what_has_no_module_gets_a_stand_in_until_the_module_is_there_and_it_is_applied_again() {
    let (cluster, agent) = Cluster::hello();
    let spec = with_camera(Some(StandIn::Missing));
    cluster.apply(spec.clone()).await;
    let system = cluster.until_phase("hello", Phase::Converged).await;
    assert_eq!(system.status.stand_ins, 1);
    assert_eq!(stand_ins(&cluster), ["Camera0"]);
    let notes = &system.status.notes;
    let told = "1 of 4 components are stand-ins: Camera0";
    assert!(notes.iter().any(|note| note == told), "{notes:?}");
    let done = agent.take_done();
    assert!(
        !done.iter().any(|step| step.contains("/Camera@")),
        "{done:?}"
    );
    // Nobody decides anything without being asked.
    agent.state.lock().unwrap().types.insert("Camera".into());
    let mut cluster = cluster.restart().await;
    cluster.join("local", "s2");
    cluster.until_phase("hello", Phase::Converged).await;
    assert_eq!(agent.take_done(), [""; 0]);
    let applied = cluster.apply(spec.clone()).await;
    assert!(applied.changed);
    let system = cluster.until_phase("hello", Phase::Converged).await;
    assert_eq!(
        (system.status.stand_ins, system.metadata.generation),
        (0, 2)
    );
    let done = agent.take_done();
    assert!(
        done.iter().any(|step| step == "Create component/Camera0"),
        "{done:?}"
    );
    assert!(
        cluster.stored().systems["hello"]
            .digests
            .contains_key("Camera")
    );
    assert!(!cluster.apply(spec).await.changed);
}

#[tokio::test(start_paused = true)]
async fn always_means_also_beside_a_module_and_with_any_execution_context() {
    let (cluster, _agent) = Cluster::hello();
    let mut spec = systems::hello();
    let filter = spec.components.iter_mut().find(|c| c.instance == "Filter0");
    let filter = filter.unwrap();
    filter.stand_in.when = Some(StandIn::Always);
    filter.execution_context.kind = ExecutionKind::EventDriven;
    for connector in &mut spec.connectors {
        connector.data_type = Some("IDL:RTC/TimedDouble:1.0".into());
    }
    cluster.apply(spec).await;
    cluster.until_phase("hello", Phase::Converged).await;
    assert_eq!(stand_ins(&cluster), ["Filter0"]);
    let stored = cluster.stored().systems["hello"].clone();
    assert!(stored.stand_ins.contains("Filter0"));
    assert_eq!(stored.digests.len(), 2, "{:?}", stored.digests);
}

#[tokio::test]
async fn too_many_are_refused_before_anything_changes() {
    let (cluster, agent) = Cluster::hello();
    let served = serve(cluster).await;
    let never = problem(served.controller.apply(&request(with_camera(None))).await);
    assert_eq!(
        (never.status, never.code.as_str()),
        (422, "module-not-found")
    );
    let mut most = request(with_camera(Some(StandIn::Missing)));
    most.expect.max_stand_ins = Some(0);
    let refused = problem(served.controller.apply(&most).await);
    assert_eq!(
        (refused.status, refused.code.as_str()),
        (422, "too-many-stand-ins")
    );
    insta::assert_snapshot!(refused.detail, @"1 of 4 components of system hello would be stand-ins, and at most 0 may be");
    assert_eq!(refused.errors[0].pointer, "/spec/components/3");
    assert_eq!(agent.take_done(), [""; 0]);
    most.expect.max_stand_ins = Some(1);
    served.controller.apply(&most).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_connector_at_an_undetermined_port_holds_nobody_up() {
    let (cluster, _agent) = Cluster::hello();
    let mut spec = with_camera(Some(StandIn::Missing));
    spec.connectors.last_mut().unwrap().data_type = None;
    let name = spec.connectors.last().unwrap().name.clone();
    cluster.apply(spec).await;
    cluster.until_phase("hello", Phase::Converged).await;
    let all = cluster
        .core
        .view
        .list::<rts_controller_api::objects::Connector>();
    let found = all
        .items
        .into_iter()
        .find(|c| c.metadata.name == name)
        .unwrap();
    insta::assert_snapshot!(found.status.waiting_on.unwrap(), @"is not made: port Camera0.out of a stand-in is undetermined: its data type is not known");
}
