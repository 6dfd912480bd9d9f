//! What to do when a peer is lost, and managers of other versions of the protocol, which may not know it.

use std::collections::BTreeMap;
use std::path::PathBuf;

use rts_agent_api::AgentApi;
use rts_plan::observed::Inventory;
use rts_plan::plan::Work;
use rts_schemas::system::{Configuration, OnDisconnect, SharedExecutionContext};

use crate::setup::{Node, batch, component, create, hello_batch, manager, start_manager, step};

fn on_disconnect(id: u32, values: &[(&str, &str)]) -> rts_plan::plan::Step {
    let values = values.iter();
    let set: BTreeMap<_, _> = values
        .map(|(name, value)| ((*name).to_owned(), (*value).to_owned()))
        .collect();
    let sets = match set.is_empty() {
        true => BTreeMap::new(),
        false => BTreeMap::from([("default".to_owned(), set)]),
    };
    let work = Work::Configure {
        manager: manager("main"),
        instance: "Sine0".to_owned(),
        configuration: Configuration { active: None, sets },
        rate: None,
        on_disconnect: Some(OnDisconnect::Stop),
        order: None,
    };
    step(id, &[], "component/Sine0", work)
}

#[tokio::test]
async fn what_to_do_when_a_peer_is_lost_is_passed_on_and_reported() {
    let node = Node::start().await;
    node.accept(1).await;
    let mut up = hello_batch("up", 1);
    for step in &mut up.steps {
        if let Work::Create {
            instance,
            on_disconnect,
            ..
        } = &mut step.work
            && instance == "Filter0"
        {
            *on_disconnect = OnDisconnect::Deactivate;
        }
    }
    let outcomes = node.outcomes(&up).await;
    assert!(outcomes.iter().all(|(_, o)| o == "ok"), "{outcomes:?}");
    let change = batch("change", 1, vec![on_disconnect(1, &[])]);
    assert_eq!(node.outcomes(&change).await, [(1, "ok".to_owned())]);
    let up = node.agent.inventory().await.unwrap();
    let found = ["Sine0", "Filter0", "Printer0"].map(|name| component(&up, name).on_disconnect);
    let wanted = [
        OnDisconnect::Stop,
        OnDisconnect::Deactivate,
        OnDisconnect::Keep,
    ];
    assert_eq!(found, wanted);
}

#[tokio::test]
async fn a_manager_of_the_version_before_is_told_only_what_it_knows() {
    let node = Node::with("old", None).await;
    node.hello().await;
    let values = on_disconnect(1, &[("gain", "2")]);
    let alone = on_disconnect(2, &[]);
    let outcomes = node
        .outcomes(&batch("change", 1, vec![values, alone]))
        .await;
    assert_eq!(outcomes[0], (1, "ok".to_owned()));
    insta::assert_snapshot!(outcomes[1].1, @"failed: Configure component/Sine0: manager hello.main speaks protocol version 1, which does not know rtsctl.onDisconnect: Sine0 keeps on when a peer is lost, instead of stop, until its process is replaced when the system is torn down or restarted");
    let up = node.agent.inventory().await.unwrap();
    let sine = component(&up, "Sine0");
    assert_eq!(sine.on_disconnect, OnDisconnect::Keep);
    assert_eq!(sine.configuration.sets["default"]["gain"], "2");
}

#[tokio::test]
async fn a_manager_of_the_version_before_shares_no_execution_context() {
    let node = Node::with("old", None).await;
    node.hello().await;
    let mut alone = create(1, &[], "main", "Alone0", "SineSource");
    let mut shares = create(2, &[1], "main", "Shares0", "SineSource");
    for (step, name) in [(&mut alone, None), (&mut shares, Some("control"))] {
        if let Work::Create {
            execution_context, ..
        } = &mut step.work
        {
            *execution_context = name.map(|name: &str| SharedExecutionContext {
                name: name.to_owned(),
                order: 0,
                shared_state: None,
            });
        }
    }
    let outcomes = node.outcomes(&batch("more", 1, vec![alone, shares])).await;
    assert_eq!(outcomes[0], (1, "ok".to_owned()));
    insta::assert_snapshot!(outcomes[1].1, @"failed: Create component/Shares0: manager hello.main speaks protocol version 1, which does not know shared execution contexts: stop it, so that a new process takes its place, then Shares0 can be made");
}

#[tokio::test]
async fn a_manager_of_a_later_version_is_not_spoken_to_and_the_error_names_who_is_to_be_upgraded() {
    let node = Node::with("future", None).await;
    node.accept(1).await;
    let outcomes = node
        .outcomes(&batch("up", 1, vec![start_manager(1, "main")]))
        .await;
    insta::assert_snapshot!(outcomes[0].1, @"failed: StartManager manager/hello.main: manager hello.main speaks version 9 of the manager protocol, this agent 1 to 2: upgrade the agent");
    node.until(|i| i.managers.is_empty()).await;
}

/// The recorded manager of version 1 as a manager program.
fn previous_manager() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let program = test.parent().unwrap().parent().unwrap();
    let program = program.join("examples/previous_manager");
    assert!(
        program.exists(),
        "build it first (cargo build -p rts-manager --examples)"
    );
    program
}

#[tokio::test]
async fn a_manager_from_before_an_upgrade_is_adopted_and_serves_on() {
    let mut node = Node::start().await;
    node.stop().await;
    node.config.manager_program = previous_manager();
    node.start_again().await;
    node.accept(1).await;
    let mut up = hello_batch("up", 1);
    // What was recorded has no connectors.
    up.steps.retain(|s| !matches!(s.work, Work::Connect { .. }));
    for step in &mut up.steps {
        if matches!(step.work, Work::Activate { .. }) {
            step.needs = vec![6, 7, 8];
        }
    }
    let outcomes = node.outcomes(&up).await;
    assert!(outcomes.iter().all(|(_, o)| o == "ok"), "{outcomes:?}");
    let before = node.agent.inventory().await.unwrap();
    assert_eq!(
        component(&before, "Sine0").on_disconnect,
        OnDisconnect::Keep
    );

    node.stop().await;
    node.start_again().await;
    let after = node.agent.inventory().await.unwrap();
    let incarnations = |i: &Inventory| {
        let components = i.managers.iter().flat_map(|m| &m.components);
        components
            .map(|c| c.incarnation.clone())
            .collect::<Vec<_>>()
    };
    assert!(after.managers.iter().all(|m| m.responsive));
    assert_eq!(incarnations(&after).len(), 3);
    assert_eq!(incarnations(&after), incarnations(&before));
    let change = batch("change", 1, vec![on_disconnect(1, &[])]);
    let outcome = &node.outcomes(&change).await[0].1;
    assert!(outcome.contains("speaks protocol version 1"), "{outcome}");
    let looked = node.agent.stream_samples("Sine0", "out").await;
    let why = looked.map(drop).unwrap_err().to_string();
    assert!(why.contains("is of an older version"), "{why}");
}
