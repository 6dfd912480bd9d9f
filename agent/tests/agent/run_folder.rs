//! What an agent does when its run folder is taken from under it.

use rts_agent::StartError;
use rts_agent_api::AgentApi;
use rts_host::files;
use rts_host::home::{claim, is_claimed};

use crate::agent_process::{AgentProcess, serving, until};
use crate::setup::{Node, lives, start_beside};

#[tokio::test]
async fn no_second_agent_starts_while_run_is_gone_and_all_is_made_anew() {
    let node = Node::start().await;
    node.hello().await;
    let before = node.agent.inventory().await.unwrap();
    let run = node.home.path().join("run");
    std::fs::remove_dir_all(&run).unwrap();
    let second = start_beside(&node.config).await.err();
    assert!(
        matches!(second, Some(StartError::Running { .. })),
        "{second:?}"
    );

    std::fs::remove_dir_all(&run).unwrap();
    let lock = run.join("local/agent.lock");
    until("everything is there again", || {
        is_claimed(&run) && lock.exists() && run.join("local/agent.sock").exists()
    })
    .await;
    assert!(files::lock(&lock).unwrap().is_none(), "it is held again");
    // A controller may start.
    claim(node.home.path()).unwrap();
    let after = node.until(|i| i.managers.len() == 2).await;
    for (before, after) in before.managers.iter().zip(&after.managers) {
        assert_eq!(before.incarnation, after.incarnation);
    }
}

#[tokio::test]
async fn an_agent_whose_lock_was_taken_ends_and_leaves_its_managers_and_the_other_alone() {
    let mut agent = AgentProcess::start("off", &serving("")).await;
    agent.node.accept(1).await;
    assert_eq!(agent.start_manager("up", "main").await, "ok");
    let manager = agent.manager().await.pid;
    let lock = agent.node.run().join("agent.lock");
    std::fs::remove_file(&lock).unwrap();
    let held = files::lock(&lock).unwrap();
    assert!(held.is_some());
    let description = agent.node.run().join("agent.json");
    std::fs::write(&description, "another's").unwrap();
    let status = agent.ended().await;
    assert!(!status.success());
    assert!(lives(manager));
    assert_eq!(std::fs::read_to_string(description).unwrap(), "another's");
    let log = std::fs::read_to_string(agent.node.home.path().join("agent.log")).unwrap();
    assert!(log.contains("Taken(Running"), "{log}");
}
