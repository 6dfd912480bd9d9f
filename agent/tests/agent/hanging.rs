//! Steps on a component that hangs, and the teardown of one, in paused time.

use std::time::Duration;

use rts_agent::{LocalAgent, Running};
use rts_agent_api::AgentApi;
use rts_agent_api::messages::{BatchEvent, NodeSpecEnvelope, StepOutcome};
use rts_plan::place::digest;
use rts_plan::plan::Work;
use rts_schemas::system::{OnHang, Policy};
use tokio::time::{Instant, sleep};

use crate::fake_machine::FakeNode;
use crate::in_process::{run, start_with};
use crate::setup::{batch, envelope, hello_spec, manager, start_manager, step};

/// The hello system, whose source is replaced after it has hung for a second.
fn impatient(generation: u64) -> NodeSpecEnvelope {
    let mut envelope = hello_spec(generation);
    envelope.spec.systems[0].components[0].spec.policy = Policy {
        on_hang: OnHang::Restart,
        liveness_timeout_ms: Some(1_000),
        restart_limit: Some(0),
        ..Policy::default()
    };
    envelope.digest = digest(&envelope.spec);
    envelope
}

/// A node on which the process of the source runs, and nothing heals.
async fn up(spec: NodeSpecEnvelope) -> (FakeNode, Running, LocalAgent) {
    let node = FakeNode::default();
    let running = start_with(&node, None).await;
    let agent = running.api();
    agent.put_node_spec(&spec).await.unwrap();
    run(&agent, &batch("up", 1, vec![start_manager(1, "main")])).await;
    (node, running, agent)
}

/// Carries out one step; how it failed, or `ok`, and how many tenths of a second it took.
async fn outcome(agent: &LocalAgent, generation: u64, target: &str, work: Work) -> (String, u128) {
    let begun = Instant::now();
    let plan = format!("{target} {generation} {}", work.kind());
    let events = run(
        agent,
        &batch(&plan, generation, vec![step(1, &[], target, work)]),
    )
    .await;
    let said = events.into_iter().find_map(|event| match event {
        BatchEvent::Finished { outcome, .. } => Some(match outcome {
            StepOutcome::Succeeded => "ok".to_owned(),
            StepOutcome::Failed { reason } | StepOutcome::Skipped { reason, .. } => reason,
        }),
        _ => None,
    });
    (said.unwrap(), begun.elapsed().as_millis() / 100)
}

fn reset() -> Work {
    Work::Reset {
        manager: manager("main"),
        instance: "Sine0".to_owned(),
    }
}

/// Why the process is to be replaced.
async fn expired(agent: &LocalAgent) -> Option<String> {
    agent.inventory().await.unwrap().managers[0].expired.clone()
}

async fn stop(agent: &LocalAgent, generation: u64) -> (String, u128) {
    let inventory = agent.inventory().await.unwrap();
    let work = Work::StopManager {
        manager: manager("main"),
        incarnation: inventory.managers[0].incarnation.clone(),
    };
    outcome(agent, generation, "manager/hello.main", work).await
}

#[tokio::test(start_paused = true)]
async fn a_step_on_what_hangs_fails_as_soon_as_that_is_known() {
    let (node, running, agent) = up(impatient(1)).await;
    node.machine.hang("on_reset");
    let (said, tenths) = outcome(&agent, 1, "component/Sine0", reset()).await;
    insta::assert_snapshot!(said, @"Reset component/Sine0: Sine0 has been in on_reset for longer than 1 s (rtsctl.livenessTimeout)");
    assert!((10..=15).contains(&tenths), "{tenths}");
    assert!(expired(&agent).await.is_some());
    // It hangs already.
    let deactivate = Work::Deactivate {
        manager: manager("main"),
        instance: "Sine0".to_owned(),
    };
    let (said, tenths) = outcome(&agent, 1, "component/Sine0", deactivate).await;
    assert!(said.contains("has been in on_reset for"), "{said}");
    assert!(tenths <= 5, "{tenths}");
    running.stop().await;
}

#[tokio::test(start_paused = true)]
async fn a_step_waits_as_long_as_the_policy_of_its_component_allows() {
    let mut patient = impatient(1);
    let policy = &mut patient.spec.systems[0].components[0].spec.policy;
    policy.liveness_timeout_ms = None;
    patient.digest = digest(&patient.spec);
    // The usual 5 s.
    let (node, running, agent) = up(patient).await;
    node.machine.hang("on_reset");
    let (said, tenths) = outcome(&agent, 1, "component/Sine0", reset()).await;
    assert!(said.contains("longer than 5 s"), "{said}");
    assert!((50..=55).contains(&tenths), "{tenths}");
    running.stop().await;
}

#[tokio::test(start_paused = true)]
async fn a_step_on_what_is_only_reported_keeps_its_own_limit() {
    let mut reported = impatient(1);
    reported.spec.systems[0].components[0].spec.policy.on_hang = OnHang::Report;
    reported.digest = digest(&reported.spec);
    let (node, running, agent) = up(reported).await;
    node.machine.hang("on_deactivated");
    let deactivate = Work::Deactivate {
        manager: manager("main"),
        instance: "Sine0".to_owned(),
    };
    let (said, tenths) = outcome(&agent, 1, "component/Sine0", deactivate).await;
    assert!(!said.contains("rtsctl.livenessTimeout"), "{said}");
    assert!(tenths >= 100, "{tenths}");
    running.stop().await;
}

#[tokio::test(start_paused = true)]
async fn what_leaves_keeps_its_policies_until_it_is_gone() {
    let (node, running, agent) = up(impatient(1)).await;
    node.machine.hang("on_execute");
    agent.put_node_spec(&envelope(2, Vec::new())).await.unwrap();
    sleep(Duration::from_millis(1_100)).await;
    let why = expired(&agent).await;
    insta::assert_snapshot!(why.unwrap_or_default(), @"Sine0 has been in on_execute for longer than 1 s (rtsctl.livenessTimeout)");
    // Another word of the same changes nothing.
    agent.put_node_spec(&envelope(3, Vec::new())).await.unwrap();
    assert!(expired(&agent).await.is_some());
    // It is asked for a second only, and its end is no death.
    let (said, tenths) = stop(&agent, 3).await;
    assert_eq!(said, "ok");
    assert!(tenths <= 10, "{tenths}");
    assert_eq!(agent.inventory().await.unwrap().held, []);
    running.stop().await;
}
