//! What many starts and stops of managers leave in an agent: nothing.

use std::time::Duration;

use rts_agent_api::AgentApi;
use tokio::time::{Instant, sleep};

use crate::agent_process::{AgentProcess, serving};

const CYCLES: usize = 50;
/// Time to let go of what the last cycle held.
const SETTLE: Duration = Duration::from_secs(10);
/// Threads for blocking work come and go; one for each cycle would be many more.
const POOL: usize = 10;

/// Open descriptors and threads.
fn held(agent: &AgentProcess) -> (usize, usize) {
    let count = |what: &str| {
        let entries = std::fs::read_dir(format!("/proc/{}/{what}", agent.pid()));
        entries.unwrap().count()
    };
    (count("fd"), count("task"))
}

/// Waits until the agent holds no more than before.
async fn settles(agent: &AgentProcess, before: (usize, usize)) {
    let end = Instant::now() + SETTLE;
    loop {
        // A look over HTTP is a connection too: it is the same one each time.
        let inventory = agent.node.agent.inventory().await.unwrap();
        assert_eq!(inventory.managers, []);
        let now = held(agent);
        if now.0 <= before.0 && now.1 <= before.1 + POOL {
            return;
        }
        assert!(Instant::now() < end, "before {before:?}, now {now:?}");
        sleep(Duration::from_millis(200)).await;
    }
}

async fn cycle(agent: &AgentProcess, n: usize) {
    let outcome = agent.start_manager(&format!("up{n}"), "main").await;
    assert_eq!(outcome, "ok");
    let manager = agent.manager().await;
    let outcome = agent.stop_manager(&format!("down{n}"), &manager).await;
    assert_eq!(outcome, "ok");
}

#[tokio::test]
async fn starts_and_stops_leave_no_descriptor_thread_or_control_group() {
    let agent = AgentProcess::start("auto", &serving("")).await;
    agent.node.accept(1).await;
    // What is made once is made.
    cycle(&agent, 0).await;
    sleep(Duration::from_millis(100)).await;
    let before = held(&agent);
    for n in 1..=CYCLES {
        cycle(&agent, n).await;
    }
    settles(&agent, before).await;
    assert!(agent.cgroups().is_empty());
}

/// Starts that fail one after the other.
async fn failing(script: &str, expected: &str, cycles: usize) {
    let agent = AgentProcess::start("auto", script).await;
    agent.node.accept(1).await;
    let fail = async |n: usize| {
        let outcome = agent.start_manager(&format!("up{n}"), "main").await;
        assert!(outcome.contains(expected), "{outcome}");
    };
    fail(0).await;
    sleep(Duration::from_millis(100)).await;
    let before = held(&agent);
    for n in 1..=cycles {
        fail(n).await;
    }
    settles(&agent, before).await;
    assert!(agent.cgroups().is_empty());
    assert_eq!(agent.node.managers(), []);
}

#[tokio::test]
async fn managers_that_exit_at_once_leave_nothing() {
    failing("exit 3", "exit status 3", CYCLES).await;
}

#[tokio::test]
async fn managers_that_never_say_hello_leave_nothing() {
    failing("sleep 1000", "was not ready within", 3).await;
}

#[tokio::test]
async fn a_manager_program_that_is_missing_leaves_nothing() {
    let agent = AgentProcess::start("auto", "exit 3").await;
    agent.node.accept(1).await;
    std::fs::remove_file(&agent.node.config.manager_program).unwrap();
    let fail = async |n: usize| {
        let outcome = agent.start_manager(&format!("up{n}"), "main").await;
        assert!(outcome.contains("No such file"), "{outcome}");
    };
    fail(0).await;
    sleep(Duration::from_millis(100)).await;
    let before = held(&agent);
    for n in 1..=CYCLES {
        fail(n).await;
    }
    settles(&agent, before).await;
    assert!(agent.cgroups().is_empty());
}
