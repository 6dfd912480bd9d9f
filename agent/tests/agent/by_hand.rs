//! What people do at a manager, and logs.

use std::collections::BTreeMap;

use rts_agent_api::AgentApi;
use rts_agent_api::messages::{CreateByHand, ModuleRequest};

use rts_schemas::system::ExecutionKind;

use crate::setup::{Node, problem};

fn wish(type_name: &str, instance: Option<&str>) -> CreateByHand {
    CreateByHand {
        type_name: type_name.to_owned(),
        instance: instance.map(str::to_owned),
        parameters: BTreeMap::from([("gain".to_owned(), "2".to_owned())]),
        rate: None,
    }
}

#[tokio::test]
async fn a_manager_is_started_by_its_first_module_and_its_components_are_numbered() {
    let node = Node::start().await;
    let request = ModuleRequest {
        type_name: "Sine".to_owned(),
    };
    let factory = node.agent.load_module("bench", &request).await.unwrap();
    assert_eq!(factory.ports, ["out:out:IDL:RTC/TimedDouble:1.0"]);
    let factories = node.agent.factories("bench").await.unwrap();
    assert_eq!(factories, [factory]);

    for number in 0..3 {
        let made = node
            .agent
            .create("bench", &wish("Sine", None))
            .await
            .unwrap();
        assert_eq!(made.instance, format!("Sine{number}"));
        assert_eq!(
            (made.node.as_str(), made.manager.as_str()),
            ("local", "bench")
        );
    }
    node.agent.delete_component("bench", "Sine1").await.unwrap();
    let made = node
        .agent
        .create("bench", &wish("Sine", None))
        .await
        .unwrap();
    assert_eq!(made.instance, "Sine1");
    let inventory = node.agent.inventory().await.unwrap();
    let component = &inventory.managers[0].components[1];
    assert_eq!(
        (component.instance.as_str(), &component.system),
        ("Sine1", &None)
    );
    assert_eq!(component.configuration.sets["default"]["gain"], "2");
    let kind = component.execution_kind;
    assert_eq!(kind, ExecutionKind::EventDriven, "as its module wants it");

    node.agent.unload_module("bench", "Sine").await.unwrap();
    let gone = node.agent.unload_module("bench", "Sine").await;
    assert_eq!(problem(gone).status, 404);
}

#[tokio::test]
async fn what_a_system_owns_or_wants_is_not_touched_by_hand() {
    let node = Node::start().await;
    node.hello().await;
    let taken = problem(
        node.agent
            .create("bench", &wish("Sine", Some("Sine0")))
            .await,
    );
    assert_eq!((taken.status, taken.code.as_str()), (409, "name-taken"));
    // A short name does not mean the manager of a system.
    let short = problem(node.agent.delete_component("main", "Sine0").await);
    assert_eq!(short.status, 404);
    let made = node.agent.create("main", &wish("Sine", Some("Own0"))).await;
    assert_eq!(made.unwrap().manager, "main");
    let owned = problem(node.agent.delete_component("hello.main", "Sine0").await);
    assert_eq!(
        (owned.status, owned.code.as_str()),
        (409, "owned-by-system")
    );
    assert!(
        owned.detail.contains("rtsctl teardown hello"),
        "{}",
        owned.detail
    );
    assert_eq!(node.agent.factories("hello.main").await.unwrap().len(), 2);
    let made = node
        .agent
        .create("bench", &wish("Sine", None))
        .await
        .unwrap();
    assert_eq!(made.instance, "Sine1");
}

#[tokio::test]
async fn names_that_mean_nothing_are_refused() {
    let node = Node::start().await;
    let status = |answer: Result<_, _>| problem(answer).status;
    let agent = &node.agent;
    assert_eq!(
        status(agent.create("bench", &wish("Nothing", None)).await),
        404
    );
    assert_eq!(
        status(agent.create("no.main", &wish("Sine", None)).await),
        404
    );
    assert_eq!(status(agent.create("../x", &wish("Sine", None)).await), 404);
    assert_eq!(status(agent.create("-", &wish("Sine", None)).await), 422);
    assert_eq!(
        status(agent.create("bench", &wish("Sine", Some("a/b"))).await),
        422
    );
    assert_eq!(problem(agent.factories("bench").await).status, 404);
    assert_eq!(node.managers(), []);
}

#[tokio::test]
async fn logs_are_given_from_their_end_and_only_of_components() {
    let node = Node::start().await;
    node.accept(1).await;
    assert_eq!(
        node.agent.log("Printer0", 5).await.unwrap(),
        "",
        "wanted, not yet there"
    );
    node.hello().await;
    assert_eq!(
        node.agent.log("Printer0", 5).await.unwrap(),
        "created Printer0\n"
    );
    let log = node.home.path().join("logs/local/components/Printer0.log");
    std::fs::write(&log, "one\ntwo\nthree\n").unwrap();
    assert_eq!(node.agent.log("Printer0", 2).await.unwrap(), "two\nthree\n");
    for name in ["Nothing0", "../state/node-spec", "..", "a/b"] {
        assert_eq!(problem(node.agent.log(name, 5).await).status, 404, "{name}");
    }
}

#[tokio::test]
async fn a_manager_that_was_started_for_a_component_that_cannot_be_made_is_stopped_again() {
    let node = Node::start().await;
    let refused = node.agent.create("bench", &wish("Crash", None)).await;
    assert_eq!(problem(refused).status, 503);
    let mut bad = wish("Sine", None);
    bad.parameters
        .insert("refuse".to_owned(), "please".to_owned());
    let refused = node.agent.create("bench", &bad).await;
    assert_eq!(problem(refused).code, "manager-invalid");
    assert_eq!(node.managers(), []);
    // One that was there before stays.
    node.agent
        .create("bench", &wish("Sine", None))
        .await
        .unwrap();
    assert!(node.agent.create("bench", &bad).await.is_err());
    assert_eq!(node.managers().len(), 1);
}

#[tokio::test]
async fn odd_names_have_logs_and_a_new_life_is_marked() {
    let node = Node::start().await;
    let name = "カメラ 100%";
    for _ in 0..2 {
        node.agent
            .create("bench", &wish("Sine", Some(name)))
            .await
            .unwrap();
        node.agent.delete_component("bench", name).await.unwrap();
    }
    let log = node.agent.log(name, 9).await.unwrap();
    let lines: Vec<_> = log.lines().collect();
    assert_eq!(lines.len(), 3, "{log}");
    let mark = format!("--- a new incarnation of {name} begins here ---");
    assert!(lines[1].ends_with(&mark), "{log}");
}
