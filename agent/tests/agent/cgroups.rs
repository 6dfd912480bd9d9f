//! No survivor: whatever a manager started ends with it, also what ignores SIGTERM and what leaves its process group.

use rts_host::cgroup::{Cgroups, Choice};
use rustix::process::Signal;

use crate::agent_process::{AgentProcess, FAMILY, serving, until};
use crate::setup::{kill, lives};

const NOBODY: [u32; 0] = [];

/// False, and a word, where this machine permits no such control groups.
pub fn permitted(choice: &str) -> bool {
    let home = tempfile::tempdir().unwrap();
    let choice = Choice::parse(choice).unwrap();
    match Cgroups::of(home.path(), choice).create("probe") {
        Ok(probe) => {
            probe.remove().unwrap();
            true
        }
        Err(e) => {
            eprintln!("skipped: {e}");
            false
        }
    }
}

/// An agent whose only manager started a family; none where that is not permitted.
async fn with_family(choice: &'static str) -> Option<AgentProcess> {
    if choice != "off" && !permitted(choice) {
        return None;
    }
    let agent = AgentProcess::start(choice, &serving(FAMILY)).await;
    agent.node.accept(1).await;
    assert_eq!(agent.start_manager("up", "main").await, "ok");
    let cgroups = agent.cgroups().len();
    assert_eq!(cgroups, usize::from(choice != "off"));
    assert_eq!(survivors(&agent).len(), 2);
    Some(agent)
}

fn survivors(agent: &AgentProcess) -> Vec<u32> {
    let mut all = [agent.pids("children"), agent.pids("runaways")].concat();
    all.retain(|pid| lives(*pid));
    all
}

/// Nothing is left of the managers, and a new one can be started.
async fn nothing_is_left(agent: &AgentProcess) {
    until("nobody survives", || survivors(agent).is_empty()).await;
    until("no control group is left", || agent.cgroups().is_empty()).await;
    until("no folder is left", || agent.node.managers().is_empty()).await;
    assert_eq!(agent.start_manager("again", "main").await, "ok");
}

async fn a_stop_leaves_nobody(choice: &'static str) {
    let Some(agent) = with_family(choice).await else {
        return;
    };
    let manager = agent.manager().await;
    assert_eq!(agent.stop_manager("down", &manager).await, "ok");
    // Now, not in a while: a stop that was reported is over.
    assert!(!lives(manager.pid));
    assert_eq!(survivors(&agent), NOBODY);
    assert!(agent.cgroups().is_empty());
    nothing_is_left(&agent).await;
}

#[tokio::test]
async fn a_stop_leaves_nobody_in_version_2() {
    a_stop_leaves_nobody("v2").await;
}

#[tokio::test]
async fn a_stop_leaves_nobody_in_version_1() {
    a_stop_leaves_nobody("v1").await;
}

async fn a_death_leaves_nobody(choice: &'static str) {
    let Some(agent) = with_family(choice).await else {
        return;
    };
    let pid = agent.manager().await.pid;
    kill_one(pid);
    agent.node.until(|i| i.managers.is_empty()).await;
    // Its end is reported after that of all that it started.
    assert_eq!(survivors(&agent), NOBODY);
    nothing_is_left(&agent).await;
}

#[tokio::test]
async fn a_death_leaves_nobody_in_version_2() {
    a_death_leaves_nobody("v2").await;
}

#[tokio::test]
async fn a_death_leaves_nobody_in_version_1() {
    a_death_leaves_nobody("v1").await;
}

#[tokio::test]
async fn a_new_agent_buries_what_a_manager_left_while_there_was_none() {
    let Some(mut agent) = with_family("auto").await else {
        return;
    };
    let pid = agent.manager().await.pid;
    agent.kill();
    kill_one(pid);
    until("the manager is dead", || !lives(pid)).await;
    assert_eq!(survivors(&agent).len(), 2);
    agent.start_again().await;
    assert_eq!(survivors(&agent), NOBODY);
    nothing_is_left(&agent).await;
}

#[tokio::test]
async fn a_new_agent_buries_what_is_left_without_a_run_folder() {
    let Some(mut agent) = with_family("auto").await else {
        return;
    };
    let pid = agent.manager().await.pid;
    agent.kill();
    kill_one(pid);
    std::fs::remove_dir_all(agent.node.run()).unwrap();
    agent.start_again().await;
    nothing_is_left(&agent).await;
}

#[tokio::test]
async fn an_adopted_manager_is_ended_with_all_that_it_started() {
    let Some(mut agent) = with_family("auto").await else {
        return;
    };
    let before = agent.manager().await;
    agent.kill();
    agent.start_again().await;
    let adopted = agent.manager().await;
    assert_eq!(adopted.pid, before.pid);
    assert_eq!(survivors(&agent).len(), 2);
    assert_eq!(agent.stop_manager("down", &adopted).await, "ok");
    assert_eq!(survivors(&agent), NOBODY);
    nothing_is_left(&agent).await;
}

#[tokio::test]
async fn without_control_groups_the_process_group_ends_and_only_the_runaway_is_not_found() {
    let Some(agent) = with_family("off").await else {
        return;
    };
    kill_one(agent.manager().await.pid);
    agent.node.until(|i| i.managers.is_empty()).await;
    assert!(!lives(agent.pids("children")[0]));
    assert!(lives(agent.pids("runaways")[0]), "then say so in the guide");
}

#[tokio::test]
async fn a_start_that_fails_leaves_nobody() {
    if !permitted("auto") {
        return;
    }
    let agent = AgentProcess::start("auto", &format!("{FAMILY}\nexit 7")).await;
    agent.node.accept(1).await;
    let outcome = agent.start_manager("up", "main").await;
    assert!(outcome.contains("exit status 7"), "{outcome}");
    assert_eq!(agent.pids("runaways").len(), 1);
    assert_eq!(survivors(&agent), NOBODY);
    assert!(agent.cgroups().is_empty());
}

/// The manager alone, not its group.
fn kill_one(pid: u32) {
    let pid = rustix::process::Pid::from_raw(pid as i32).unwrap();
    rustix::process::kill_process(pid, Signal::KILL).unwrap();
}

#[tokio::test]
async fn a_stopped_manager_and_its_stopped_family_are_ended() {
    let Some(agent) = with_family("auto").await else {
        return;
    };
    let manager = agent.manager().await;
    kill(manager.pid, Signal::STOP);
    agent.node.until(|i| !i.managers[0].responsive).await;
    assert_eq!(agent.stop_manager("down", &manager).await, "ok");
    assert_eq!(survivors(&agent), NOBODY);
}
