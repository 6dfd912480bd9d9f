//! Changes by hand through the controller, and the export of what runs, over real Unix sockets.

use std::sync::Arc;

use crate::fleet::served::{Served, problem, request, serve, text};
use crate::fleet::{Cluster, FakeAgent, greeting, systems};
use axum::Router;
use axum::extract::State;
use axum::routing::post;
use rts_agent_api::messages::{Act, ActRequest, Acted};
use rts_http::problem::Problem;
use rts_http::server::{Json, ProblemResponse};
use rts_schemas::system::{DriftPolicy, SystemSpec};

type Answer = Result<Json<Acted>, ProblemResponse>;

/// Sets values by hand, and nothing else.
async fn act(State(agent): State<Arc<FakeAgent>>, Json(request): Json<ActRequest>) -> Answer {
    let Act::Configure {
        instance, values, ..
    } = &request.act
    else {
        return Err(Problem::conflict("wrong-state", "Filter0 is Active").into());
    };
    if !request.dry_run {
        for (name, value) in values {
            agent.set_by_hand(instance, name, value);
        }
    }
    Ok(Json(Acted {
        node: "local".into(),
        target: format!("component/{instance}"),
        changed: !request.dry_run,
        system: Some("hello".into()),
        policy: Some(DriftPolicy::Ignore),
        notes: Vec::new(),
    }))
}

struct World {
    served: Served,
    agent: Arc<FakeAgent>,
    _folder: tempfile::TempDir,
}

fn hello() -> SystemSpec {
    let mut spec = systems::hello();
    for component in &mut spec.components {
        component.policy.drift = DriftPolicy::Ignore;
        let gain = [("gain".to_owned(), "1".to_owned())];
        let sets = &mut component.configuration.sets;
        sets.insert("default".into(), gain.into());
    }
    spec
}

/// A controller whose agent listens on a socket.
async fn world() -> World {
    let (mut cluster, _) = Cluster::hello();
    let folder = tempfile::Builder::new()
        .prefix("ra")
        .tempdir_in("/tmp")
        .unwrap();
    let socket = folder.path().join("a.sock");
    let endpoint = socket.to_str().unwrap();
    let agent = cluster.fleet.also_at("local", endpoint);
    let listener = rts_http::server::bind(&socket).unwrap();
    let router = Router::new()
        .route("/v1/acts", post(act))
        .with_state(Arc::clone(&agent));
    tokio::spawn(rts_http::server::serve(
        listener,
        router,
        std::future::pending(),
    ));
    let mut greeting = greeting(&agent, "s2");
    greeting.endpoint = endpoint.to_owned();
    rts_controller::greet(&cluster.core, "local", greeting).unwrap();
    cluster.beats("local", "s2");
    let served = serve(cluster).await;
    served.controller.apply(&request(hello())).await.unwrap();
    served.until_converged("hello").await;
    agent.take_done();
    World {
        served,
        agent,
        _folder: folder,
    }
}

fn configure(value: &str, dry_run: bool) -> ActRequest {
    ActRequest {
        act: Act::Configure {
            instance: "Filter0".into(),
            set: None,
            values: [("gain".to_owned(), value.to_owned())].into(),
            active: None,
        },
        dry_run,
    }
}

#[tokio::test]
async fn an_act_reaches_the_agent_is_told_and_is_seen_at_once() {
    let World { served, agent, .. } = &world().await;
    let tried = served.controller.act("local", &configure("7", true)).await;
    assert!(!tried.unwrap().changed);
    assert!(served.cluster.told("ChangedByHand").is_empty());
    let acted = served.controller.act("local", &configure("7", false)).await;
    assert_eq!(acted.unwrap().policy, Some(DriftPolicy::Ignore));
    let events = served.cluster.events();
    let event = events.iter().find(|e| e.spec.reason == "ChangedByHand");
    let event = &event.unwrap().spec;
    assert_eq!(
        (
            event.kind.as_str(),
            event.system.as_str(),
            event.object.as_str()
        ),
        ("Normal", "hello", "component/Filter0")
    );
    let (what, _) = event.message.split_once(" by uid ").unwrap();
    assert_eq!(what, "configured (gain=7)");
    let ends = event
        .message
        .ends_with("; it is left so (see rtsctl.drift)");
    assert!(ends, "{}", event.message);
    let drifted = |s: Option<&rts_controller_api::objects::System>| {
        let conditions = &s.unwrap().status.conditions;
        conditions
            .iter()
            .any(|c| c.kind == "Drifted" && c.status == "True")
    };
    served.cluster.until("hello", drifted).await;
    assert_eq!(agent.take_done(), [""; 0]);
}

#[tokio::test]
async fn refusals_and_unknown_nodes_are_told_as_they_are() {
    let World { served, .. } = &world().await;
    let reset = ActRequest {
        act: Act::Reset {
            instance: "Filter0".into(),
        },
        dry_run: false,
    };
    let refused = problem(served.controller.act("local", &reset).await);
    assert_eq!(
        (refused.status, refused.code.as_str()),
        (409, "wrong-state")
    );
    let nowhere = problem(served.controller.act("nowhere", &reset).await);
    assert_eq!(nowhere.status, 404);
    assert!(served.cluster.told("ChangedByHand").is_empty());
}

#[tokio::test]
async fn what_could_not_be_stored_is_not_set_and_long_values_are_shown_cut() {
    let World { served, agent, .. } = &world().await;
    let long = "x".repeat(1024 * 1024 + 1);
    for dry_run in [true, false] {
        let refused = problem(
            served
                .controller
                .act("local", &configure(&long, dry_run))
                .await,
        );
        assert_eq!((refused.status, refused.code.as_str()), (422, "too-long"));
        assert_eq!(refused.errors[0].pointer, "/act/values/gain");
    }
    let gain = |agent: &FakeAgent| {
        let inventory = agent.inventory_now();
        let mut all = inventory.managers.iter().flat_map(|m| &m.components);
        let filter = all.find(|c| c.instance == "Filter0").unwrap();
        filter.configuration.sets["default"]["gain"].clone()
    };
    assert_eq!(gain(agent), "1");
    let acted = served
        .controller
        .act("local", &configure(&long[1..], false))
        .await;
    assert!(acted.unwrap().changed);
    let drifted = |s: Option<&rts_controller_api::objects::System>| {
        s.is_some_and(|s| !s.status.drift.is_empty())
    };
    let hello = served.cluster.until("hello", drifted).await.unwrap();
    assert!(hello.status.drift[0].len() < 400);
    for event in served.cluster.events() {
        assert!(event.spec.message.len() < 400, "{}", event.spec.message);
    }
}

#[tokio::test]
async fn what_is_exported_is_what_runs_and_its_apply_touches_nothing() {
    let World { served, agent, .. } = &world().await;
    let untouched = served.controller.export("hello").await.unwrap();
    assert_eq!((untouched.spec, untouched.notes), (hello(), Vec::new()));

    agent.set_by_hand("Filter0", "gain", "7");
    agent.disconnect_by_hand("Sine0", "Sine0.out-Filter0.in");
    agent.connect_by_hand(&systems::connector("Sine0.out", "Printer0.in"));
    let exported = served.controller.export("hello").await.unwrap();
    let sets = &exported.spec.components[1].configuration.sets;
    assert_eq!(sets["default"]["gain"], "7");
    let names: Vec<_> = exported
        .spec
        .connectors
        .iter()
        .map(|connector| connector.name.as_str())
        .collect();
    assert_eq!(names, ["Filter0.out-Printer0.in", "Sine0.out-Printer0.in"]);
    assert_eq!(exported.notes, [""; 0]);
    let applied = served.controller.apply(&request(exported.spec)).await;
    let applied = applied.unwrap();
    // It is stored, and said so; nothing that runs changes.
    assert!(
        applied.changed && applied.plan.steps.is_empty(),
        "{applied:#?}"
    );
    insta::assert_snapshot!("apply_of_an_export", rts_plan::render(&applied.plan));
    served.until_converged("hello").await;
    assert_eq!(agent.take_done(), [""; 0]);
}

#[tokio::test]
async fn an_export_says_what_it_could_not_see() {
    let World { served, agent, .. } = &world().await;
    agent.fail("StartManager manager/hello.Printer0", 1_000);
    agent.kill("hello.Printer0");
    agent.deactivate_by_hand("Filter0");
    let exported = served.controller.export("hello").await.unwrap();
    assert_eq!(exported.spec, hello());
    insta::assert_snapshot!("export_notes", exported.notes.join("\n"));
    agent.silence(true);
    let exported = served.controller.export("hello").await.unwrap();
    assert_eq!(exported.notes.len(), 3);
    insta::assert_snapshot!("export_of_an_unknown_node", exported.notes.join("\n"));
}

#[tokio::test]
async fn only_what_lives_is_exported() {
    let World { served, agent, .. } = &world().await;
    let nobody = problem(served.controller.export("nobody").await);
    assert_eq!(nobody.status, 404);
    agent.silence(true);
    served.controller.delete("hello").await.unwrap();
    let going = problem(served.controller.export("hello").await);
    insta::assert_snapshot!("export_of_what_goes", text(&going));
}
