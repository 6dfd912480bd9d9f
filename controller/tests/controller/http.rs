//! The API over a real Unix socket, on a fleet in memory.

use std::time::Duration;

use crate::fleet::served::{problem, request, serve};
use crate::fleet::{Cluster, greeting, systems};
use rts_agent_api::session::{Heartbeat, SessionApi, SessionClient};
use rts_controller_api::objects::{Component, Kind, Node, Phase, System};
use rts_controller_api::watch::{Watch, WatchType};

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
async fn a_node_that_lives_or_runs_something_is_not_forgotten() {
    let (cluster, _agent) = Cluster::hello();
    let served = serve(cluster).await;
    let controller = &served.controller;
    assert_eq!(problem(controller.forget_node("other").await).status, 404);
    let lives = problem(controller.forget_node("local").await);
    assert_eq!((lives.status, lives.code.as_str()), (409, "node-lives"));
    controller.apply(&request(systems::hello())).await.unwrap();
    let runs = problem(controller.forget_node("local").await);
    assert_eq!((runs.status, runs.code.as_str()), (409, "systems-run"));
    served.until_converged("hello").await;
    controller.delete("hello").await.unwrap();
    served.cluster.until("hello", |s| s.is_none()).await;
    let lives = problem(controller.forget_node("local").await);
    assert_eq!(lives.code, "node-lives");
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
