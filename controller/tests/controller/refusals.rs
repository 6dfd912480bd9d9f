//! What the API refuses, and how it says so, over a real Unix socket.

use crate::fleet::served::{problem, request, serve};
use crate::fleet::{Cluster, systems};
use rts_controller_api::requests::{ApplyRequest, Expect};
use rts_schemas::system::Placement;

#[tokio::test]
async fn every_fault_of_a_spec_is_named_at_once() {
    let (cluster, _agent) = Cluster::hello();
    let served = serve(cluster).await;
    let mut spec = systems::hello();
    spec.components[0].execution_context.rate = Some(0.0);
    spec.components[1].instance = "Sine0".into();
    spec.connectors[1].target.instance = "Nobody".into();
    insta::assert_snapshot!("many_faults", served.refused(spec).await);
}

#[tokio::test]
async fn an_execution_context_in_two_processes_is_refused() {
    let (cluster, _agent) = Cluster::hello();
    let served = serve(cluster).await;
    let mut spec = systems::hello();
    for component in &mut spec.components {
        component.execution_context.name = Some("control".to_owned());
        component.execution_context.rate = None;
    }
    spec.components[1].placement.isolated = true;
    let refused = served.refused(spec).await;
    assert!(refused.contains("execution-context-apart"), "{refused}");
}

#[tokio::test]
async fn what_the_modules_do_not_know_is_refused() {
    let (cluster, agent) = Cluster::hello();
    agent.describe(
        "SineSource",
        &["out:out:TimedDouble"],
        &["amplitude:double:", "frequency:double:0<x<=100"],
    );
    agent.describe(
        "LowPassFilter",
        &["in:in:TimedLong", "out:out:TimedDouble"],
        &[],
    );
    let served = serve(cluster).await;
    let mut spec = systems::hello();
    let values = [
        ("amplitud", "2"),
        ("amplitude", "big"),
        ("frequency", "200"),
    ]
    .map(|(name, value)| (name.to_owned(), value.to_owned()));
    spec.components[0]
        .configuration
        .sets
        .insert("default".into(), values.into());
    spec.components[1].configuration.sets.insert(
        "a/b".into(),
        [("alpha".to_owned(), "0.1".to_owned())].into(),
    );
    spec.connectors
        .push(systems::connector("Sine0.ot", "Filter0.out"));
    // Nothing is known of Printer0: nothing is said against it.
    spec.connectors
        .push(systems::connector("Sine0.out", "Printer0.anything"));
    insta::assert_snapshot!("against_the_modules", served.refused(spec).await);
    agent.describe(
        "LowPassFilter",
        &["in:in:TimedDouble", "out:out:TimedDouble"],
        &[],
    );
    let applied = served.controller.apply(&request(systems::hello())).await;
    assert!(applied.unwrap().changed);
}

#[tokio::test]
async fn an_interface_type_that_does_not_reach_is_refused() {
    let (cluster, _agent) = Cluster::hello();
    let served = serve(cluster).await;
    let mut spec = systems::hello();
    spec.components[2].placement.isolated = true;
    let mut choose = |connector: usize, word: &str| {
        let name = "dataport.interface_type".to_owned();
        let properties = &mut spec.connectors[connector].properties;
        properties.insert(name, word.to_owned());
        spec.clone()
    };
    choose(0, "direct");
    let across = choose(1, "inproc");
    insta::assert_snapshot!("out_of_reach", served.refused(across).await);
    let reaches = choose(1, "shared_memory");
    let applied = served.controller.apply(&request(reaches)).await;
    assert!(applied.unwrap().changed);
}

#[tokio::test]
async fn names_rates_and_orders_follow_one_rule() {
    let (cluster, _agent) = Cluster::hello();
    let served = serve(cluster).await;
    let mut spec = systems::hello();
    spec.components[0].execution_context.rate = Some(2e6);
    spec.components[0].placement.manager = Some("../../evil".into());
    spec.components[1].instance = " .Filter0".into();
    spec.components[2].instance = "x".repeat(129);
    spec.connectors[1].name = "a/b".into();
    insta::assert_snapshot!("one_rule", served.refused(spec).await);
    let mut spec = systems::hello();
    spec.name = "Hello".into();
    let refused = served.controller.apply(&request(spec)).await;
    assert_eq!(problem(refused).code, "bad-system-name");
}

#[tokio::test]
async fn a_cycle_names_all_its_members() {
    let (cluster, _agent) = Cluster::hello();
    let served = serve(cluster).await;
    let mut spec = systems::hello();
    spec.orders
        .activation
        .push(systems::after("Printer0", "Sine0"));
    insta::assert_snapshot!("order_cycle", served.refused(spec).await);
}

#[tokio::test]
async fn a_missing_module_is_refused_before_anything_is_disturbed() {
    let (cluster, agent) = Cluster::hello();
    let served = serve(cluster).await;
    let mut spec = systems::hello();
    spec.components.push(systems::component("Ghost0", "Ghost"));
    spec.orders
        .activation
        .push(systems::after("Printer0", "Sine0"));
    insta::assert_snapshot!("module_not_found_and_cycle", served.refused(spec).await);
    assert!(agent.take_done().is_empty());
}

#[tokio::test]
async fn nodes_that_are_unknown_or_not_there_are_told_apart() {
    let cluster = Cluster::start(
        crate::fleet::FakeFleet::default(),
        rts_controller::store::MemoryStore::new("cluster"),
    );
    let served = serve(cluster).await;
    insta::assert_snapshot!("node_not_ready", served.refused(systems::hello()).await);
    let mut spec = systems::hello();
    spec.components[0].placement = Placement {
        node: Some("mars".into()),
        ..Placement::default()
    };
    insta::assert_snapshot!("unknown_node", served.refused(spec).await);
}

#[tokio::test]
async fn clashes_with_what_is_stored_are_conflicts() {
    let (cluster, _agent) = Cluster::hello();
    let served = serve(cluster).await;
    served
        .controller
        .apply(&request(systems::hello()))
        .await
        .unwrap();
    let mut other = systems::hello();
    other.name = "second".into();
    insta::assert_snapshot!("instance_clash", served.refused(other).await);
    let mut invalid = systems::hello();
    invalid.name = "second".into();
    invalid
        .orders
        .activation
        .push(systems::after("Printer0", "Sine0"));
    let refused = served.controller.apply(&request(invalid)).await;
    assert_eq!(
        problem(refused).code,
        "order-cycle",
        "its own faults go first"
    );
    let mut stranger = systems::hello();
    stranger.full_id = "RTSystem:someone:else:1.0".into();
    insta::assert_snapshot!("other_system", served.refused(stranger.clone()).await);
    let replaced = ApplyRequest {
        spec: stranger,
        replace: true,
        targets: Vec::new(),
        expect: Expect::default(),
    };
    assert!(served.controller.apply(&replaced).await.unwrap().changed);
}

#[tokio::test]
async fn errors_are_problem_documents() {
    let (cluster, _agent) = Cluster::hello();
    let served = serve(cluster).await;
    let send = async |method, path: &str, body: &str| {
        let request = served
            .http
            .request(method, path)
            .header("content-type", "application/json")
            .body(body.to_owned());
        let problem = problem(served.http.text(request).await);
        format!("{} {} {}", problem.status, problem.code, problem.detail)
    };
    use reqwest::Method;
    let lines = [
        send(Method::GET, "/v1/nothing", "").await,
        send(Method::PATCH, "/v1/systems", "").await,
        send(Method::PUT, "/v1/systems/hello", "{").await,
        send(
            Method::PUT,
            "/v1/systems/hello",
            "{\"spec\": {\"name\": \"hello\"}}",
        )
        .await,
        send(Method::GET, "/v1/systems?watch=maybe", "").await,
        send(Method::GET, "/v1/systems?watch=true&resourceVersion=x", "").await,
        send(Method::GET, "/v1/components/local/Nobody", "").await,
        send(Method::GET, "/v1/components/mars/Sine0/log", "").await,
        send(Method::GET, "/v1/components/local/Sine0/log", "").await,
        send(Method::POST, "/v1/nodes/UPPER/sessions", "{}").await,
    ];
    insta::assert_snapshot!("problems", lines.join("\n"));
}
