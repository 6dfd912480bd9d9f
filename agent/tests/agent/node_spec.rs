//! The NodeSpec over HTTP, and what the agent says of itself.

use std::os::unix::fs::PermissionsExt;

use reqwest::Method;
use rts_agent_api::AgentApi;
use rts_agent_api::messages::LedgerFence;
use rts_http::client::{Client, ClientError};

use crate::setup::{Node, PATIENCE, envelope, hello_spec, problem, start_beside};

#[tokio::test]
async fn a_node_spec_is_durable_and_its_refusals_have_codes() {
    let mut node = Node::start().await;
    let first = hello_spec(5);
    assert!(node.agent.put_node_spec(&first).await.unwrap().changed);
    assert!(!node.agent.put_node_spec(&first).await.unwrap().changed);
    node.stop().await;
    node.start_again().await;
    assert!(!node.agent.put_node_spec(&first).await.unwrap().changed);

    let put = |change: fn(&mut rts_agent_api::messages::NodeSpecEnvelope)| {
        let mut offered = envelope(5, Vec::new());
        change(&mut offered);
        let agent = &node.agent;
        async move {
            let problem = problem(agent.put_node_spec(&offered).await);
            (problem.status, problem.code)
        }
    };
    let code = |status: u16, code: &str| (status, code.to_owned());
    assert_eq!(put(|_| {}).await, code(409, "digest-mismatch"));
    assert_eq!(
        put(|e| e.generation = 4).await,
        code(409, "stale-generation")
    );
    assert_eq!(put(|e| e.epoch = 0).await, code(409, "stale-epoch"));
    assert_eq!(
        put(|e| e.cluster_uid = "other".to_owned()).await,
        code(409, "foreign-cluster")
    );
    assert_eq!(
        put(|e| e.digest = "0".repeat(64)).await,
        code(422, "digest-mismatch")
    );
}

#[tokio::test]
async fn the_ledger_can_be_read_and_taken_over_by_whoever_names_it() {
    let node = Node::start().await;
    assert_eq!(problem(node.agent.node_spec().await).status, 404);
    node.hello().await;
    let held = node.agent.node_spec().await.unwrap();
    assert_eq!(held, hello_spec(1));
    let before = node.agent.inventory().await.unwrap();

    let mut offered = hello_spec(3);
    offered.cluster_uid = "other".to_owned();
    offered.epoch = 7;
    let meant = LedgerFence {
        cluster_uid: held.cluster_uid,
        epoch: held.epoch,
        generation: held.generation,
        digest: held.digest,
    };
    offered.take_over = Some(LedgerFence {
        generation: 2,
        ..meant.clone()
    });
    let refused = problem(node.agent.put_node_spec(&offered).await);
    assert_eq!(
        (refused.status, refused.code.as_str()),
        (409, "foreign-cluster")
    );
    assert!(
        refused.detail.contains("rtsctl controller adopt local"),
        "{}",
        refused.detail
    );
    assert_eq!(node.agent.node_spec().await.unwrap(), hello_spec(1));
    offered.take_over = Some(meant);
    assert!(node.agent.put_node_spec(&offered).await.unwrap().changed);

    offered.take_over = None;
    assert_eq!(node.agent.node_spec().await.unwrap(), offered);
    // Nothing was touched, and the one before has no say any more.
    let after = node.agent.inventory().await.unwrap();
    assert_eq!(after.revision, before.revision);
    let late = problem(node.agent.put_node_spec(&hello_spec(9)).await);
    assert_eq!(late.code, "foreign-cluster");
}

#[tokio::test]
async fn one_agent_serves_a_node_and_leaves_nothing_behind() {
    let mut node = Node::start().await;
    let socket = node.run().join("agent.sock");
    let mode = |path: &std::path::Path| std::fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&socket) & 0o777, 0o600);
    assert_eq!(mode(&node.run()) & 0o777, 0o700);
    let info = node.agent.node().await.unwrap();
    assert_eq!(
        (info.node.as_str(), info.pid),
        ("local", std::process::id())
    );
    let described = rts_host::identity::Identity::read(&node.run().join("agent.json")).unwrap();
    assert!(described.is_now() && described.pid == info.pid);

    let error = start_beside(&node.config).await.err().unwrap();
    assert!(error.to_string().contains("runs already"), "{error}");
    // The one that runs is not disturbed by the attempt.
    assert_eq!(node.agent.node().await.unwrap().session, info.session);

    node.stop().await;
    assert!(!socket.exists() && !node.run().join("agent.json").exists());
    assert!(matches!(
        node.agent.node().await,
        Err(ClientError::Unreachable { .. })
    ));
}

#[tokio::test]
async fn a_home_that_is_too_long_for_sockets_is_refused() {
    let node = Node::start().await;
    let mut config = node.config.clone();
    config.home = node.home.path().join("x".repeat(90));
    let error = start_beside(&config).await.err().unwrap();
    assert!(error.to_string().contains("RTSCTL_HOME"), "{error}");
}

#[tokio::test]
async fn the_service_describes_itself_and_answers_nonsense_with_problems() {
    let node = Node::start().await;
    let http = Client::unix(node.run().join("agent.sock"), PATIENCE).unwrap();
    for path in ["/livez", "/readyz?verbose"] {
        let text = http.text(http.request(Method::GET, path)).await.unwrap();
        assert!(text.starts_with("ok"), "{text}");
    }
    let description: serde_json::Value = http.get("/openapi.json").await.unwrap();
    for path in [
        "/v1/node",
        "/v1/inventory",
        "/v1/node-spec",
        "/v1/batches",
        "/v1/batches/{plan}/gates",
        "/v1/modules/resolve",
        "/v1/components/{instance}/log",
        "/v1/managers/{manager}/modules/{type}",
    ] {
        assert!(!description["paths"][path].is_null(), "{path}");
    }
    let answer = http.get::<serde_json::Value>("/v2/nothing").await;
    assert_eq!(problem(answer).status, 404);
    let wrong = http
        .send::<_, serde_json::Value>(Method::PUT, "/v1/node-spec", &serde_json::json!({"a": 1}))
        .await;
    assert_eq!(problem(wrong).status, 422);
}

#[tokio::test]
async fn modules_are_resolved() {
    let node = Node::start().await;
    let types = ["Sine".to_owned(), "Nothing".to_owned()];
    let found = node.agent.resolve_modules(&types).await.unwrap();
    let module = found[0].module.as_ref().unwrap();
    assert!(
        module.path.ends_with("/modules/libsine.so"),
        "{}",
        module.path
    );
    assert_eq!(module.digest.len(), 64);
    assert_eq!(found[1].module, None);
    assert!(found[1].searched[0].ends_with("libnothing.so"));
}
