//! The API over a real Unix socket, on a fleet in memory.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod fleet;

use std::path::PathBuf;
use std::time::Duration;

use fleet::{Cluster, greeting, systems};
use rts_agent_api::session::{Heartbeat, SessionClient};
use rts_controller_api::client::Controller;
use rts_controller_api::objects::{Component, Kind, Node, Phase, System};
use rts_controller_api::requests::ApplyRequest;
use rts_controller_api::watch::{Watch, WatchType};
use rts_controller_api::{ClientError, Problem};
use rts_http::client::Client;
use rts_schemas::system::{Placement, SystemSpec};

struct Served {
    cluster: Cluster,
    controller: Controller,
    http: Client,
    socket: PathBuf,
    end: tokio::sync::watch::Sender<bool>,
    server: tokio::task::JoinHandle<()>,
    _folder: tempfile::TempDir,
}

async fn serve(cluster: Cluster) -> Served {
    let folder = tempfile::Builder::new()
        .prefix("rc")
        .tempdir_in("/tmp")
        .unwrap();
    let socket = folder.path().join("c.sock");
    let listener = rts_http::server::bind(&socket).unwrap();
    let (end, ending) = tokio::sync::watch::channel(false);
    let router = rts_controller::router(cluster.core.clone(), ending.clone());
    let mut told = ending.clone();
    let server = tokio::spawn(async move {
        let shutdown = async move {
            let _ = told.wait_for(|end| *end).await;
        };
        rts_http::server::serve(listener, router, shutdown)
            .await
            .unwrap();
    });
    let http = Client::unix(&socket, Duration::from_secs(10)).unwrap();
    Served {
        cluster,
        controller: Controller::new(http.clone()),
        http,
        socket,
        end,
        server,
        _folder: folder,
    }
}

fn request(spec: SystemSpec) -> ApplyRequest {
    ApplyRequest {
        spec,
        replace: false,
    }
}

fn problem<T: std::fmt::Debug>(result: Result<T, ClientError>) -> Problem {
    match result {
        Err(ClientError::Problem(problem)) => problem,
        other => panic!("no problem document: {other:?}"),
    }
}

fn text(problem: &Problem) -> String {
    serde_json::to_string_pretty(problem).unwrap()
}

impl Served {
    async fn refused(&self, spec: SystemSpec) -> String {
        let before = self.cluster.stored();
        let problem = problem(self.controller.apply(&request(spec)).await);
        let after = self.cluster.stored();
        assert_eq!(before.systems, after.systems, "nothing is stored");
        text(&problem)
    }

    async fn until_converged(&self, name: &str) -> System {
        self.cluster.until_phase(name, Phase::Converged).await
    }
}

#[tokio::test]
async fn a_system_is_applied_listed_planned_and_deleted() {
    let (cluster, _agent) = Cluster::hello();
    let served = serve(cluster).await;
    assert!(served.controller.ready().await);
    let planned = served
        .controller
        .plan(&request(systems::hello()))
        .await
        .unwrap();
    assert!(!planned.plan.steps.is_empty());
    assert!(
        served.cluster.stored().systems.is_empty(),
        "a plan stores nothing"
    );
    let applied = served
        .controller
        .apply(&request(systems::hello()))
        .await
        .unwrap();
    assert!(applied.changed);
    assert_eq!(planned.plan.steps.len(), applied.plan.steps.len());
    served.until_converged("hello").await;
    let list = served
        .controller
        .list::<Component>(Kind::Component)
        .await
        .unwrap();
    let names: Vec<_> = list
        .items
        .iter()
        .map(|c| c.metadata.name.as_str())
        .collect();
    assert_eq!(names, ["Filter0", "Printer0", "Sine0"]);
    let one = served.controller.component("local", "Sine0").await.unwrap();
    assert_eq!(one.status.state, "Active");
    let connectors: serde_json::Value = served
        .http
        .get("/v1/connectors/hello/Sine0.out-Filter0.in")
        .await
        .unwrap();
    assert_eq!(connectors["status"]["state"], "Connected");
    let deleted = served.controller.delete("hello").await.unwrap();
    assert_eq!(deleted.status.phase, Phase::Terminating);
    served.cluster.until("hello", |s| s.is_none()).await;
    assert_eq!(problem(served.controller.system("hello").await).status, 404);
    assert_eq!(problem(served.controller.delete("hello").await).status, 404);
}

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
async fn what_the_modules_do_not_know_is_refused() {
    let (cluster, agent) = Cluster::hello();
    agent.describe(
        "SineSource",
        &["out:out:TimedDouble"],
        &["amplitude", "frequency"],
    );
    agent.describe(
        "LowPassFilter",
        &["in:in:TimedLong", "out:out:TimedDouble"],
        &[],
    );
    let served = serve(cluster).await;
    let mut spec = systems::hello();
    let values = [("amplitud".to_owned(), "2".to_owned())];
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
        fleet::FakeFleet::default(),
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
    };
    assert!(served.controller.apply(&replaced).await.unwrap().changed);
}

#[tokio::test]
async fn if_match_guards_an_apply() {
    let (cluster, _agent) = Cluster::hello();
    let served = serve(cluster).await;
    served
        .controller
        .apply(&request(systems::hello()))
        .await
        .unwrap();
    served.until_converged("hello").await;
    let put = |tag: &str| {
        served
            .http
            .request(reqwest::Method::PUT, "/v1/systems/hello")
            .header("if-match", tag)
            .json(&request(systems::hello()))
    };
    let refused = problem(served.http.text(put("\"1\"")).await);
    assert_eq!(
        (refused.status, refused.code.as_str()),
        (412, "precondition-failed")
    );
    let get = served
        .http
        .request(reqwest::Method::GET, "/v1/systems/hello");
    let response = served.http.accept(get).await.unwrap();
    let tag = response.headers()["etag"].to_str().unwrap().to_owned();
    served.http.text(put(&tag)).await.unwrap();
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

async fn next<T: serde::de::DeserializeOwned>(watch: &mut Watch<T>) -> (WatchType, u64, Option<T>) {
    let event = tokio::time::timeout(Duration::from_secs(20), watch.next());
    let event = event.await.unwrap().unwrap().unwrap();
    (
        event.kind,
        event.resource_version.parse().unwrap(),
        event.object,
    )
}

#[tokio::test]
async fn a_watch_goes_on_where_a_list_or_an_older_watch_ended() {
    let (cluster, agent) = Cluster::hello();
    agent.slow(Duration::from_millis(5));
    let served = serve(cluster).await;
    let list = served
        .controller
        .list::<System>(Kind::System)
        .await
        .unwrap();
    let from = &list.metadata.resource_version;
    let mut watch = served
        .controller
        .watch::<System>(Kind::System, from)
        .await
        .unwrap();
    served
        .controller
        .apply(&request(systems::hello()))
        .await
        .unwrap();
    let (kind, first, _) = next(&mut watch).await;
    assert_eq!(kind, WatchType::Added);
    let mut last = first;
    loop {
        let (kind, version, object) = next(&mut watch).await;
        assert!(kind == WatchType::Modified && version > last);
        last = version;
        if object.unwrap().status.phase == Phase::Converged {
            break;
        }
    }
    // A reader that comes back by Last-Event-ID sees only what came after.
    let resume = served
        .http
        .request(
            reqwest::Method::GET,
            "/v1/systems?watch=true&resourceVersion=0",
        )
        .header("last-event-id", first.to_string());
    let mut lines = rts_http::lines::Lines::of(served.http.accept(resume).await.unwrap());
    let id = lines.next().await.unwrap().unwrap();
    let data = lines.next().await.unwrap().unwrap();
    assert!(
        id.strip_prefix("id: ").unwrap().parse::<u64>().unwrap() > first,
        "{id}"
    );
    assert!(data.starts_with(r#"data: {"type":"MODIFIED""#), "{data}");
    // Without a version a watch begins with everything.
    let all = served
        .http
        .request(reqwest::Method::GET, "/v1/nodes?watch=true");
    let mut lines = rts_http::lines::Lines::of(served.http.accept(all).await.unwrap());
    let data = lines.next().await.unwrap().unwrap();
    assert!(data.starts_with(r#"data: {"type":"ADDED""#), "{data}");
}

#[tokio::test]
async fn a_watch_from_nothing_has_no_id_before_everything_was_sent() {
    let (cluster, _agent) = Cluster::hello();
    let served = serve(cluster).await;
    let apply = request(systems::hello());
    served.controller.apply(&apply).await.unwrap();
    served.until_converged("hello").await;
    for watch in ["1", "true"] {
        let path = format!("/v1/components?watch={watch}");
        let all = served.http.request(reqwest::Method::GET, &path);
        let mut lines = rts_http::lines::Lines::of(served.http.accept(all).await.unwrap());
        let mut seen = Vec::new();
        while !seen.last().is_some_and(|l: &String| l.contains("BOOKMARK")) {
            seen.push(lines.next().await.unwrap().unwrap());
        }
        let ids = seen.iter().filter(|l| l.starts_with("id:")).count();
        let added = seen.iter().filter(|l| l.contains("\"ADDED\"")).count();
        assert_eq!((ids, added), (1, 3), "{seen:#?}");
        let id = &seen[seen.len() - 2];
        let version = id.strip_prefix("id: ").unwrap().parse::<u64>().unwrap();
        assert!(version <= served.cluster.core.view.revision());
        let from = version.to_string();
        let resumed = served
            .controller
            .watch::<Component>(Kind::Component, &from)
            .await;
        assert!(resumed.is_ok());
    }
}

#[tokio::test]
async fn if_none_match_makes_only_what_is_new() {
    let (cluster, _agent) = Cluster::hello();
    let served = serve(cluster).await;
    let put = |tag: &str| {
        let request = served
            .http
            .request(reqwest::Method::PUT, "/v1/systems/hello")
            .header("if-none-match", tag)
            .json(&request(systems::hello()));
        served.http.text(request)
    };
    assert_eq!(problem(put("\"7\"").await).status, 400);
    put("*").await.unwrap();
    let refused = problem(put("*").await);
    assert_eq!(
        (refused.status, refused.code.as_str()),
        (412, "precondition-failed")
    );
}

#[tokio::test]
async fn checks_are_listed_as_kubernetes_lists_them() {
    let (cluster, agent) = Cluster::hello();
    let served = serve(cluster).await;
    let page = async |path: &str| {
        let request = served.http.request(reqwest::Method::GET, path);
        served.http.text(request).await.unwrap()
    };
    let apply = request(systems::hello());
    served.controller.apply(&apply).await.unwrap();
    served.until_converged("hello").await;
    assert_eq!(page("/livez").await, "ok");
    assert_eq!(
        page("/livez?verbose").await,
        "[+]ping ok\nlivez check passed\n"
    );
    assert_eq!(
        page("/readyz?verbose").await,
        "[+]ping ok\n[+]store ok\n[+]reconcile ok\nreadyz check passed\n"
    );
    drop(agent);
}

#[tokio::test]
async fn a_watch_from_a_version_that_is_gone_is_410() {
    let (mut cluster, _agent) = Cluster::hello();
    cluster = cluster.restart().await;
    let served = serve(cluster).await;
    let gone = served.controller.watch::<Node>(Kind::Node, "1").await;
    let gone = problem(gone.map(|_| ()));
    assert_eq!((gone.status, gone.code.as_str()), (410, "expired"));
}

#[tokio::test]
async fn watches_end_with_the_program() {
    let (cluster, _agent) = Cluster::hello();
    let served = serve(cluster).await;
    let version = served.cluster.core.view.revision().to_string();
    let mut watch = served
        .controller
        .watch::<Node>(Kind::Node, &version)
        .await
        .unwrap();
    served.end.send_replace(true);
    let ended = tokio::time::timeout(Duration::from_secs(5), async {
        while watch.next().await.is_some() {}
    });
    ended.await.unwrap();
    tokio::time::timeout(Duration::from_secs(5), served.server)
        .await
        .unwrap()
        .unwrap();
}

#[tokio::test]
async fn agents_greet_and_beat_over_the_socket() {
    let (cluster, agent) = Cluster::hello();
    let served = serve(cluster).await;
    let client = SessionClient::new(served.http.clone(), "local");
    let beat = Heartbeat {
        inventory_revision: 1,
        delta: None,
        events: vec![rts_agent_api::session::AgentEvent {
            kind: "Warning".into(),
            reason: "ManagerDied".into(),
            object: "manager/x".into(),
            system: None,
            message: "signal 9".into(),
        }],
    };
    assert_eq!(problem(client.heartbeat("new", &beat).await).status, 404);
    let reply = client.greet(&greeting(&agent, "new")).await.unwrap();
    assert_eq!((reply.cluster_uid.as_str(), reply.epoch), ("cluster", 1));
    client.heartbeat("new", &beat).await.unwrap();
    assert_eq!(problem(client.heartbeat("s1", &beat).await).status, 409);
    let events = served.cluster.events();
    assert!(
        events
            .iter()
            .any(|e| e.spec.reason == "ManagerDied" && e.spec.kind == "Warning")
    );
    assert!(served.socket.exists());
}
