//! Batches against fake managers.

use futures_util::StreamExt;
use rts_agent_api::AgentApi;
use rts_agent_api::messages::{Batch, BatchEvent, GateReport};
use rts_plan::observed::{ConnectorState, LifeCycleState};
use rts_plan::plan::Work;

use crate::setup::{
    Node, activate, batch, component, connect, connector, create, envelope, hello_batch, lives,
    load, manager, problem, start_manager, step,
};

#[tokio::test]
async fn a_system_comes_up_once_however_often_its_batch_is_sent() {
    let node = Node::start().await;
    node.hello().await;
    let up = node.agent.inventory().await.unwrap();
    let names: Vec<_> = up.managers.iter().map(|m| m.key.display_name()).collect();
    assert_eq!(names, ["hello.Printer0", "hello.main"]);
    for name in ["Sine0", "Filter0", "Printer0"] {
        assert_eq!(component(&up, name).state, LifeCycleState::Active);
    }
    let direct = &component(&up, "Sine0").connectors[0];
    let socket = &component(&up, "Filter0").connectors[0];
    assert_eq!(
        (direct.transport.as_str(), socket.transport.as_str()),
        ("direct", "uds")
    );
    assert_eq!(socket.state, ConnectorState::Connected);
    assert_eq!((socket.samples_sent, socket.samples_received), (9, 7));
    assert_eq!(
        socket.target_incarnation,
        component(&up, "Printer0").incarnation
    );

    // The same plan again: its results are told again. Another plan: everything is so already.
    let same = node.outcomes(&hello_batch("up", 1)).await;
    assert_eq!(same.len(), 13);
    let other = node.outcomes(&hello_batch("other", 1)).await;
    assert!(other.iter().all(|(_, o)| o == "ok"), "{other:?}");
    let again = node.agent.inventory().await.unwrap();
    assert_eq!(again.revision, up.revision, "{again:#?}");
    let different = hello_batch("up", 1);
    let different = batch("up", 1, different.steps[..2].to_vec());
    assert_eq!(
        problem(node.agent.run_batch(&different).await.map(|_| ())).code,
        "plan-differs"
    );
}

#[tokio::test]
async fn a_system_goes_down_and_its_processes_with_it() {
    let node = Node::with("grandchild", None).await;
    node.hello().await;
    let up = node.agent.inventory().await.unwrap();
    let stop = |id, index: usize| {
        let observed = &up.managers[index];
        let work = Work::StopManager {
            manager: observed.key.clone(),
            incarnation: observed.incarnation.clone(),
        };
        step(id, &[1], "manager", work)
    };
    let disconnect = Work::Disconnect {
        manager: manager("main"),
        instance: "Filter0".to_owned(),
        connector: "Filter0.out-Printer0.in".to_owned(),
    };
    let mut other_start = stop(4, 0);
    if let Work::StopManager { incarnation, .. } = &mut other_start.work {
        *incarnation = "another".to_owned();
    }
    let down = batch(
        "down",
        1,
        vec![step(1, &[], "connector", disconnect), other_start.clone()],
    );
    let outcomes = node.outcomes(&down).await;
    assert!(outcomes.iter().all(|(_, o)| o == "ok"), "{outcomes:?}");
    let half = node.agent.inventory().await.unwrap();
    assert_eq!(half.managers.len(), 2, "another start is left alone");
    assert!(component(&half, "Filter0").connectors.is_empty());

    let delete = Work::Delete {
        manager: manager("main"),
        instance: "Sine0".to_owned(),
    };
    let down = batch(
        "end",
        1,
        vec![
            step(1, &[], "component/Sine0", delete),
            stop(2, 0),
            stop(3, 1),
        ],
    );
    let outcomes = node.outcomes(&down).await;
    assert!(outcomes.iter().all(|(_, o)| o == "ok"), "{outcomes:?}");
    assert_eq!(node.managers(), [], "run folders are removed");
    for manager in &up.managers {
        assert!(!lives(manager.pid));
        assert!(!group_lives(manager.pid), "a grandchild is left");
    }
    // Once more: it is so already.
    let mut again = down.clone();
    again.plan_id = "again".to_owned();
    let outcomes = node.outcomes(&again).await;
    assert!(outcomes.iter().all(|(_, o)| o == "ok"), "{outcomes:?}");
}

fn group_lives(group: u32) -> bool {
    let processes = std::fs::read_dir("/proc").unwrap().flatten();
    processes
        .filter_map(|p| std::fs::read_to_string(p.path().join("stat")).ok())
        .filter_map(|stat| stat.rsplit_once(") ").map(|(_, rest)| rest.to_owned()))
        .any(|rest| {
            let fields: Vec<_> = rest.split(' ').collect();
            fields[0] != "Z" && fields[2] == group.to_string()
        })
}

#[tokio::test]
async fn failures_say_why_and_skip_only_what_depends_on_them() {
    let node = Node::start().await;
    node.accept(1).await;
    let mut abroad = connector("Sine0", "main", "Filter0", "main");
    abroad.target.node = "arm".to_owned();
    let mut pinned = load(5, &[1], "main", "Filter");
    if let Work::LoadModule { module_digest, .. } = &mut pinned.work {
        *module_digest = Some("0".repeat(64));
    }
    let outcomes = node
        .outcomes(&batch(
            "p",
            1,
            vec![
                start_manager(1, "main"),
                load(2, &[1], "main", "Nothing"),
                create(3, &[2], "main", "Nothing0", "Nothing"),
                activate(4, &[], "gone", "Sine0"),
                pinned,
                connect(6, &[1], abroad),
                load(7, &[1], "main", "Sine"),
                create(8, &[7], "main", "../Sine0", "Sine"),
            ],
        ))
        .await;
    let text: String = outcomes
        .iter()
        .map(|(id, outcome)| format!("{id} {outcome}\n"))
        .collect::<String>()
        .replace(&node.home.path().display().to_string(), "HOME");
    insta::assert_snapshot!(text);
}

#[tokio::test]
async fn a_manager_that_ends_early_is_reported_with_its_last_words() {
    let node = Node::with("early", None).await;
    node.accept(1).await;
    let outcomes = node
        .outcomes(&batch("p", 1, vec![start_manager(1, "main")]))
        .await;
    let reason = &outcomes[0].1;
    assert!(reason.contains("exit status 3"), "{reason}");
    assert!(reason.contains("cannot find my library"), "{reason}");
    assert_eq!(
        std::fs::read_dir(node.run())
            .unwrap()
            .flatten()
            .filter(|e| e.path().is_dir())
            .count(),
        0
    );
}

#[tokio::test]
async fn two_starts_of_one_manager_give_one_process() {
    let node = Node::start().await;
    node.accept(1).await;
    let steps = vec![start_manager(1, "main"), start_manager(2, "main")];
    let outcomes = node.outcomes(&batch("p", 1, steps)).await;
    assert!(outcomes.iter().all(|(_, o)| o == "ok"), "{outcomes:?}");
    assert_eq!(node.managers().len(), 1);
}

#[tokio::test]
async fn the_wrong_generation_is_refused_and_a_newer_one_cancels_what_has_not_started() {
    let node = Node::start().await;
    let early = batch("early", 1, vec![start_manager(1, "main")]);
    assert_eq!(
        problem(node.agent.run_batch(&early).await.map(|_| ())).code,
        "stale-generation"
    );
    node.accept(1).await;
    let mut gated = batch("gated", 1, vec![start_manager(2, "main")]);
    gated.steps[0].needs = vec![1];
    gated.gates = vec![1];
    let mut events = node.agent.run_batch(&gated).await.unwrap();
    let accepted = events.next().await.unwrap().unwrap();
    assert!(matches!(accepted, BatchEvent::Accepted { .. }));
    drop(events);
    node.agent
        .put_node_spec(&envelope(2, Vec::new()))
        .await
        .unwrap();
    // The stream was dropped; the batch was not. Its results are still there.
    let outcomes = node.outcomes(&gated).await;
    assert!(outcomes[0].1.starts_with("skipped None"), "{outcomes:?}");
    assert_eq!(node.managers(), []);
    let mut nonsense = batch("n", 2, vec![start_manager(2, "main")]);
    nonsense.steps[0].needs = vec![7];
    let refused = problem(node.agent.run_batch(&nonsense).await.map(|_| ()));
    assert_eq!(
        (refused.status, refused.code.as_str()),
        (422, "invalid-batch")
    );
}

#[tokio::test]
async fn gates_are_opened_over_http() {
    let node = Node::start().await;
    node.accept(1).await;
    let mut gated = batch("gated", 1, vec![start_manager(2, "main")]);
    gated.steps[0].needs = vec![1];
    gated.gates = vec![1];
    let mut events = node.agent.run_batch(&gated).await.unwrap();
    events.next().await.unwrap().unwrap();
    let report = GateReport {
        started: vec![],
        succeeded: vec![1],
        failed: vec![],
    };
    node.agent.release("gated", &report).await.unwrap();
    let started = events.next().await.unwrap().unwrap();
    assert_eq!(started, BatchEvent::Started { step: 2 });
    let rest: Vec<_> = events.map(Result::unwrap).collect().await;
    assert_eq!(rest.last(), Some(&BatchEvent::End));
    assert_eq!(node.managers().len(), 1);
    let nobody = node.agent.release("nobody", &report).await;
    assert_eq!(problem(nobody).status, 404);
}

#[tokio::test]
async fn the_batch_of_another_cluster_or_epoch_is_refused_and_a_new_epoch_cancels() {
    let node = Node::start().await;
    node.accept(7).await;
    for change in [
        (|b: &mut Batch| b.epoch = 2) as fn(&mut Batch),
        |b| b.epoch = 0,
        |b| b.cluster_uid = "other".to_owned(),
    ] {
        let mut other = batch("other", 7, vec![start_manager(1, "main")]);
        change(&mut other);
        let refused = problem(node.agent.run_batch(&other).await.map(|_| ()));
        assert_eq!(refused.code, "stale-generation");
    }
    let mut gated = batch("gated", 7, vec![start_manager(2, "main")]);
    gated.steps[0].needs = vec![1];
    gated.gates = vec![1];
    // A restored store: a higher epoch, and a lower generation.
    let mut restored = crate::setup::hello_spec(3);
    restored.epoch = 2;
    let (outcomes, put) = tokio::join!(node.outcomes(&gated), async {
        let told = GateReport {
            started: vec![1],
            succeeded: Vec::new(),
            failed: Vec::new(),
        };
        while node.agent.release("gated", &told).await.is_err() {
            tokio::task::yield_now().await;
        }
        node.agent.put_node_spec(&restored).await
    });
    put.unwrap();
    assert!(outcomes[0].1.contains("was replaced"), "{outcomes:?}");
    assert_eq!(node.managers(), []);
}

#[tokio::test]
async fn a_batch_that_comes_twice_runs_once_and_one_that_comes_late_not_at_all() {
    let node = Node::start().await;
    node.accept(1).await;
    let up = hello_batch("up", 1);
    let (one, other) = tokio::join!(node.outcomes(&up), node.outcomes(&up));
    assert!(one.iter().all(|(_, o)| o == "ok"), "{one:?}");
    assert_eq!(one, other);
    let counts = |i: &rts_plan::observed::Inventory| -> Vec<String> {
        i.managers.iter().map(|m| m.incarnation.clone()).collect()
    };
    let before = node.agent.inventory().await.unwrap();
    assert_eq!(node.outcomes(&up).await, one);
    assert_eq!(
        counts(&node.agent.inventory().await.unwrap()),
        counts(&before)
    );

    // Sent before the newer spec, and overtaken by it.
    let late = batch("late", 1, vec![start_manager(1, "late")]);
    node.accept(2).await;
    let refused = problem(node.agent.run_batch(&late).await.map(|_| ()));
    assert_eq!(refused.code, "stale-generation");
    // What was done under the older spec can still be read, and is not done again.
    assert_eq!(node.outcomes(&up).await, one);
    assert_eq!(
        counts(&node.agent.inventory().await.unwrap()),
        counts(&before)
    );
}
