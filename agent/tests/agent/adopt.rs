//! What an agent finds when it starts, and later: managers of the agent before it, and what is left of dead ones.

use std::path::PathBuf;
use std::time::Duration;

use rts_agent_api::AgentApi;
use rts_manager_api::files::{LOCK, MANAGER_JSON, ManagerFile};
use rts_plan::observed::Inventory;

use crate::setup::{Node, batch, hello_spec, kill, lives, problem, start_manager};

/// The run folder of the only manager.
fn only_folder(node: &Node) -> PathBuf {
    let entries = std::fs::read_dir(node.run()).unwrap().flatten();
    let mut folders = entries.filter(|e| e.path().join(MANAGER_JSON).exists());
    let folder = folders.next().unwrap().path();
    assert!(folders.next().is_none());
    folder
}

fn pids(inventory: &Inventory) -> Vec<u32> {
    inventory.managers.iter().map(|m| m.pid).collect()
}

async fn start_main(node: &Node, plan: &str) -> Vec<(u32, String)> {
    node.outcomes(&batch(plan, 1, vec![start_manager(1, "main")]))
        .await
}

#[tokio::test]
async fn a_manager_whose_lock_file_was_deleted_is_adopted_and_not_killed() {
    let mut node = Node::start().await;
    node.hello().await;
    let before = node.agent.inventory().await.unwrap();
    node.stop().await;
    for entry in std::fs::read_dir(node.run()).unwrap().flatten() {
        let _ = std::fs::remove_file(entry.path().join(LOCK));
    }
    node.start_again().await;
    let after = node.agent.inventory().await.unwrap();
    assert_eq!(pids(&after), pids(&before));
    assert!(pids(&after).into_iter().all(lives));
    let outcomes = start_main(&node, "again").await;
    assert_eq!(outcomes, [(1, "ok".to_owned())]);
    assert_eq!(pids(&node.agent.inventory().await.unwrap()), pids(&before));
}

#[tokio::test]
async fn a_manager_that_was_not_seen_before_is_adopted_by_its_start_or_by_the_slow_tick() {
    let mut node = Node::start().await;
    node.accept(1).await;
    start_main(&node, "up").await;
    let (folder, hidden) = (only_folder(&node), node.home.path().join("hidden"));
    let pid = node.managers()[0].pid;
    for by_tick in [false, true] {
        node.stop().await;
        std::fs::rename(&folder, &hidden).unwrap();
        node.start_again().await;
        assert_eq!(node.agent.inventory().await.unwrap().managers, []);
        std::fs::rename(&hidden, &folder).unwrap();
        if !by_tick {
            let outcomes = start_main(&node, "again").await;
            assert_eq!(outcomes, [(1, "ok".to_owned())]);
        }
        let up = node
            .until(|i| i.managers.iter().any(|m| m.responsive))
            .await;
        assert_eq!(pids(&up), [pid]);
    }
}

#[tokio::test]
async fn a_child_that_holds_the_lock_of_a_dead_manager_is_killed_with_its_group() {
    let mut node = Node::start().await;
    node.accept(1).await;
    start_main(&node, "up").await;
    let folder = only_folder(&node);
    let mut file = node.managers().remove(0);
    kill(file.pid, rustix::process::Signal::KILL);
    node.until(|i| i.managers.is_empty()).await;
    node.stop().await;

    // `flock` forks a child that keeps its lock, and dies alone.
    std::fs::create_dir(&folder).unwrap();
    let mut leader = std::process::Command::new("flock");
    std::os::unix::process::CommandExt::process_group(&mut leader, 0);
    let mut leader = leader
        .arg(folder.join(LOCK))
        .args(["sh", "-c", "echo $$ > child; exec sleep 1000"])
        .current_dir(&folder)
        .spawn()
        .unwrap();
    let child = loop {
        let text = std::fs::read_to_string(folder.join("child")).unwrap_or_default();
        if let Ok(pid) = text.trim().parse::<u32>() {
            break pid;
        }
        tokio::time::sleep(Duration::from_millis(5)).await;
    };
    file.pid = leader.id();
    file.start_ticks = rts_host::identity::start_ticks(file.pid).unwrap();
    describe(&folder, &file);
    leader.kill().unwrap();
    leader.wait().unwrap();
    assert!(lives(child));

    node.start_again().await;
    assert!(!folder.exists());
    let end = tokio::time::Instant::now() + crate::setup::PATIENCE;
    while lives(child) {
        assert!(tokio::time::Instant::now() < end);
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    let outcomes = start_main(&node, "again").await;
    assert_eq!(outcomes, [(1, "ok".to_owned())]);
}

#[tokio::test]
async fn run_folders_of_another_boot_are_removed_and_their_numbers_mean_nobody() {
    let mut node = Node::start().await;
    node.accept(1).await;
    start_main(&node, "up").await;
    let folder = only_folder(&node);
    let mut file = node.managers().remove(0);
    kill(file.pid, rustix::process::Signal::KILL);
    node.until(|i| i.managers.is_empty()).await;
    node.stop().await;

    // Since the machine was booted, somebody else has the number, and even the same start time.
    let mut other = std::process::Command::new("sleep");
    std::os::unix::process::CommandExt::process_group(&mut other, 0);
    let mut other = other.arg("1000").spawn().unwrap();
    file.pid = other.id();
    file.start_ticks = rts_host::identity::start_ticks(file.pid).unwrap();
    file.boot_id = "0c4a1d3e-0000-4000-8000-00000000dead".to_owned();
    std::fs::create_dir(&folder).unwrap();
    describe(&folder, &file);
    std::fs::write(folder.join(LOCK), "").unwrap();

    node.start_again().await;
    assert!(!folder.exists());
    assert_eq!(node.agent.inventory().await.unwrap().managers, []);
    let outcomes = start_main(&node, "again").await;
    assert_eq!(outcomes, [(1, "ok".to_owned())]);
    assert!(other.try_wait().unwrap().is_none(), "it was signalled");
    other.kill().unwrap();
    other.wait().unwrap();
}

fn describe(folder: &std::path::Path, file: &ManagerFile) {
    let text = serde_json::to_vec(file).unwrap();
    std::fs::write(folder.join(MANAGER_JSON), text).unwrap();
}

#[tokio::test]
async fn without_a_ledger_only_who_knows_the_running_systems_is_obeyed() {
    let mut node = Node::start().await;
    node.hello().await;
    node.stop().await;
    for name in ["node-spec.json", "node-spec.2.json"] {
        std::fs::remove_file(node.home.path().join("state/local").join(name)).unwrap();
    }
    node.start_again().await;
    let refused = problem(
        node.agent
            .put_node_spec(&crate::setup::envelope(9, Vec::new()))
            .await,
    );
    assert_eq!(
        (refused.status, refused.code.as_str()),
        (409, "foreign-cluster")
    );
    assert!(refused.detail.contains("hello"), "{}", refused.detail);
    assert!(node.agent.put_node_spec(&hello_spec(9)).await.is_ok());
}

#[tokio::test]
async fn a_deleted_socket_comes_back() {
    let node = Node::start().await;
    std::fs::remove_file(node.run().join("agent.sock")).unwrap();
    std::fs::remove_file(node.run().join("agent.json")).unwrap();
    let end = tokio::time::Instant::now() + crate::setup::PATIENCE;
    while node.agent.node().await.is_err() || !node.run().join("agent.json").exists() {
        assert!(tokio::time::Instant::now() < end);
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}
