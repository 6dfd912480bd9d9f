//! Managers that are copies of a zygote: they are what spawned ones are, and depend on nobody's life.

use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::Path;
use std::time::Duration;

use rts_agent_api::AgentApi;
use rts_host::cgroup::Cgroup;
use rts_plan::observed::Inventory;
use rustix::process::Signal;

use crate::agent_process::{AgentProcess, until};
use crate::setup::{batch, kill, lives, start_manager};

const NONE: [u32; 0] = [];

fn pids(inventory: &Inventory) -> Vec<u32> {
    let mut pids: Vec<u32> = inventory.managers.iter().map(|m| m.pid).collect();
    pids.sort_unstable();
    pids
}

/// Waits until there is one zygote, and so many that wait; gives them.
async fn warm(agent: &AgentProcess, idle: usize) -> (u32, Vec<u32>) {
    until("a zygote is there", || agent.named("rts-zygote").len() == 1).await;
    until("as many wait", || agent.named("rts-idle").len() == idle).await;
    (agent.named("rts-zygote")[0], agent.named("rts-idle"))
}

fn parent(pid: u32) -> u32 {
    stat(pid, 1)
}

fn group(pid: u32) -> u32 {
    stat(pid, 2)
}

/// A field of `/proc/PID/stat`, counted from the state.
fn stat(pid: u32, field: usize) -> u32 {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap();
    let mut fields = stat.rsplit_once(')').unwrap().1.split_whitespace();
    fields.nth(field).unwrap().parse().unwrap()
}

fn words(pid: u32) -> Vec<String> {
    let line = std::fs::read_to_string(format!("/proc/{pid}/cmdline")).unwrap();
    line.trim_end_matches('\0')
        .split('\0')
        .map(str::to_owned)
        .collect()
}

async fn start_many(agent: &AgentProcess, plan: &str, count: u32) -> Vec<(u32, String)> {
    let steps = (1..=count).map(|n| start_manager(n, &format!("m{n}")));
    agent.node.outcomes(&batch(plan, 1, steps.collect())).await
}

fn all_ok(outcomes: &[(u32, String)]) {
    assert!(outcomes.iter().all(|(_, o)| o == "ok"), "{outcomes:?}");
}

/// What a manager is to the machine, however it was made.
fn is_a_manager(agent: &AgentProcess, pid: u32) {
    assert_eq!((parent(pid), group(pid)), (agent.pid(), pid));
    let words = words(pid);
    assert_eq!(words[1], "--dir");
    let folder = Path::new(&words[2]);
    assert_eq!(folder.parent(), Some(agent.node.run().as_path()));
    assert_eq!(words[3], "--name");
    let link = |name: &str| std::fs::read_link(format!("/proc/{pid}/{name}")).unwrap();
    assert_eq!(link("cwd"), folder);
    assert_eq!(link("fd/0").to_str(), Some("/dev/null"));
    assert!(link("fd/1").starts_with(agent.node.home.path().join("logs")));
    assert_eq!(link("fd/1"), link("fd/2"));
    // Of the agent and the zygote it has nothing.
    let sockets = agent.node.managers();
    assert!(sockets.iter().any(|file| file.pid == pid));
}

#[tokio::test]
async fn copies_are_managers_and_depend_neither_on_the_zygote_nor_on_the_agent() {
    let mut agent = AgentProcess::warm("auto", 0).await;
    agent.node.accept(1).await;
    let (zygote, _) = warm(&agent, 0).await;
    all_ok(&start_many(&agent, "up", 4).await);
    let before = pids(&agent.node.agent.inventory().await.unwrap());
    assert_eq!(agent.named("rts-manager"), before);
    before.iter().for_each(|pid| is_a_manager(&agent, *pid));

    kill(zygote, Signal::KILL);
    until("another zygote is there", || {
        agent
            .named("rts-zygote")
            .first()
            .is_some_and(|now| *now != zygote)
    })
    .await;
    assert_eq!(pids(&agent.node.agent.inventory().await.unwrap()), before);
    agent.kill();
    until("nothing is kept ready", || {
        agent.named("rts-zygote").is_empty()
    })
    .await;
    assert_eq!(agent.named("rts-manager"), before);

    agent.start_again().await;
    let adopted = agent.node.agent.inventory().await.unwrap();
    assert_eq!(pids(&adopted), before);
    // Its end is learned of, and what is started in its place is a copy again.
    kill(before[0], Signal::KILL);
    let left = agent.node.until(|i| i.managers.len() == 3).await;
    assert_eq!(pids(&left), before[1..]);
    warm(&agent, 0).await;
    all_ok(&start_many(&agent, "again", 4).await);
    let again = pids(&agent.node.agent.inventory().await.unwrap());
    again
        .iter()
        .filter(|pid| !before.contains(pid))
        .for_each(|pid| is_a_manager(&agent, *pid));
    assert_eq!(again.len(), 4);
}

#[tokio::test]
async fn a_zygote_that_is_killed_or_stopped_while_it_is_needed_costs_no_manager() {
    for signal in [Signal::KILL, Signal::STOP] {
        let agent = AgentProcess::warm("auto", 0).await;
        agent.node.accept(1).await;
        let (zygote, _) = warm(&agent, 0).await;
        let starts = start_many(&agent, "up", 10);
        let strike = async {
            until("one is there", || !agent.node.managers().is_empty()).await;
            // It alone: a copy that was just born is still in its process group.
            let zygote = rustix::process::Pid::from_raw(zygote.cast_signed()).unwrap();
            rustix::process::kill_process(zygote, signal).unwrap();
        };
        let (outcomes, ()) = tokio::join!(starts, strike);
        all_ok(&outcomes);
        let started = pids(&agent.node.agent.inventory().await.unwrap());
        // Those that were spawned have the name of the link to the program.
        let mut all = [agent.named("rts-manager"), agent.named("manager")].concat();
        all.sort_unstable();
        assert_eq!(all, started);
        assert_eq!(started.len(), 10);
    }
}

#[tokio::test]
async fn those_that_wait_are_used_replaced_and_end_with_the_agent() {
    let mut agent = AgentProcess::warm("off", 2).await;
    agent.node.accept(1).await;
    let (_, idle) = warm(&agent, 2).await;
    assert_eq!(agent.node.agent.inventory().await.unwrap().managers, []);
    all_ok(&start_many(&agent, "up", 1).await);
    let used = pids(&agent.node.agent.inventory().await.unwrap());
    assert!(idle.contains(&used[0]));
    is_a_manager(&agent, used[0]);

    let (_, idle) = warm(&agent, 2).await;
    kill(idle[0], Signal::KILL);
    until("it is replaced", || {
        let now = agent.named("rts-idle");
        now.len() == 2 && !now.contains(&idle[0])
    })
    .await;
    assert!(
        !Path::new(&format!("/proc/{}", idle[0])).exists(),
        "it is reaped"
    );

    // Those that have just ended are not taken.
    let (_, idle) = warm(&agent, 2).await;
    idle.iter().for_each(|pid| kill(*pid, Signal::TERM));
    until("they have ended", || !idle.iter().any(|pid| lives(*pid))).await;
    all_ok(&start_many(&agent, "more", 3).await);
    let started = pids(&agent.node.agent.inventory().await.unwrap());
    assert_eq!(started.len(), 3);
    assert!(!started.iter().any(|pid| idle.contains(pid)));

    warm(&agent, 2).await;
    let managers = agent.named("rts-manager");
    agent.kill();
    until("those that wait are gone", || {
        agent.named("rts-idle").is_empty() && agent.named("rts-zygote").is_empty()
    })
    .await;
    assert_eq!(agent.named("rts-manager"), managers);
}

/// Names of the control groups of version 2 of this home, and who is in each.
fn groups(agent: &AgentProcess) -> Vec<(String, Vec<u32>)> {
    let members = |group: &Cgroup| {
        let mut pids: Vec<u32> = group.processes().iter().map(|p| p.pid() as u32).collect();
        pids.sort_unstable();
        pids
    };
    let all = agent.cgroups();
    all.iter()
        .map(|g| (g.name().to_owned(), members(g)))
        .collect()
}

#[tokio::test]
async fn one_that_waits_has_a_group_of_its_own_which_it_keeps_and_nothing_is_left_of() {
    if !crate::cgroups::permitted("v2") {
        return;
    }
    let mut agent = AgentProcess::warm("v2", 2).await;
    agent.node.accept(1).await;
    let (_, idle) = warm(&agent, 2).await;
    let own = groups(&agent);
    let mut alone: Vec<u32> = own.iter().flat_map(|(_, pids)| pids.clone()).collect();
    alone.sort_unstable();
    assert_eq!((own.len(), &alone), (2, &idle), "each has one of its own");
    all_ok(&start_many(&agent, "up", 1).await);
    let used = agent.manager().await;
    assert!(idle.contains(&used.pid));
    is_a_manager(&agent, used.pid);
    let (name, _) = own.iter().find(|(_, pids)| pids == &[used.pid]).unwrap();
    let file = &agent.node.managers()[0];
    assert_eq!(file.cgroup.as_ref(), Some(name));

    // The next agent finds it there, and leaves it alone when it buries what the one before kept ready.
    warm(&agent, 2).await;
    agent.kill();
    until("those that waited have ended", || {
        agent.named("rts-idle").is_empty()
    })
    .await;
    assert_eq!(groups(&agent).len(), 3, "two of them are empty");
    agent.start_again().await;
    warm(&agent, 2).await;
    until("what nobody owns is gone", || groups(&agent).len() == 3).await;
    assert!(groups(&agent).contains(&(name.clone(), vec![used.pid])));

    let adopted = agent.manager().await;
    assert_eq!(adopted.pid, used.pid);
    assert_eq!(agent.stop_manager("down", &adopted).await, "ok");
    assert!(!lives(used.pid));
    assert!(groups(&agent).iter().all(|(left, _)| left != name));
    // One that ends while it waits takes its group with it.
    let (_, idle) = warm(&agent, 2).await;
    let before = groups(&agent);
    kill(idle[0], Signal::KILL);
    until("another one waits in another group", || {
        let now = groups(&agent);
        now.len() == 2 && now != before && now.iter().all(|(_, pids)| pids.len() == 1)
    })
    .await;
    let pid = rustix::process::Pid::from_raw(agent.pid() as i32).unwrap();
    rustix::process::kill_process(pid, Signal::TERM).unwrap();
    assert!(agent.ended().await.success());
    until("an orderly end leaves no group", || {
        groups(&agent).is_empty()
    })
    .await;
}

#[tokio::test]
async fn with_an_idle_pool_of_0_none_waits() {
    let agent = AgentProcess::warm("off", 0).await;
    agent.node.accept(1).await;
    warm(&agent, 0).await;
    all_ok(&start_many(&agent, "up", 1).await);
    tokio::time::sleep(Duration::from_millis(200)).await;
    assert_eq!(agent.named("rts-idle"), NONE);
}

#[tokio::test]
async fn a_program_that_was_exchanged_has_a_new_zygote() {
    let test = std::env::current_exe().unwrap();
    let program = test.ancestors().nth(2).unwrap().join("rts-manager");
    let copy = |to: &Path| assert!(std::fs::copy(&program, to).unwrap() > 0);
    let agent = AgentProcess::warm_with("off", 1, |home| copy(&home.join("manager"))).await;
    agent.node.accept(1).await;
    let (zygote, idle) = warm(&agent, 1).await;
    let (path, new) = (
        agent.node.home.path().join("manager"),
        agent.node.home.path().join("new"),
    );
    copy(&new);
    std::fs::rename(&new, &path).unwrap();
    all_ok(&start_many(&agent, "up", 2).await);
    let inode = path.metadata().unwrap().ino();
    for pid in pids(&agent.node.agent.inventory().await.unwrap()) {
        let program = std::fs::metadata(format!("/proc/{pid}/exe")).unwrap();
        assert_eq!(program.ino(), inode);
    }
    until("the old ones are gone", || {
        !lives(zygote) && !lives(idle[0])
    })
    .await;
    let (zygote, idle) = warm(&agent, 1).await;
    for pid in [zygote, idle[0]] {
        let program = std::fs::metadata(format!("/proc/{pid}/exe")).unwrap();
        assert_eq!(program.ino(), inode);
    }
}

#[tokio::test]
async fn a_program_that_is_no_zygote_is_spawned_and_asked_less_and_less_often() {
    let script = format!(
        "if [ \"$1\" = --zygote ]; then echo x >> \"$RTS_TEST_HOME/asked\"; exit 2; fi\n{}",
        crate::agent_process::serving("")
    );
    let agent = AgentProcess::warm_with("off", 2, |home| {
        let program = home.join("manager");
        std::fs::write(&program, format!("#!/bin/sh\n{script}\n")).unwrap();
        let mode = std::fs::Permissions::from_mode(0o700);
        std::fs::set_permissions(&program, mode).unwrap();
    })
    .await;
    agent.node.accept(1).await;
    all_ok(&start_many(&agent, "up", 2).await);
    tokio::time::sleep(Duration::from_secs(2)).await;
    let asked = std::fs::read_to_string(agent.node.home.path().join("asked")).unwrap();
    // At once, and after 0.25 s, 0.5 s, 1 s.
    let asked = asked.lines().count();
    assert!((1..=4).contains(&asked), "{asked}");
    assert_eq!(
        agent.node.agent.inventory().await.unwrap().managers.len(),
        2
    );
}
