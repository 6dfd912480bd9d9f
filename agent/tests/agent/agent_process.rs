//! An agent in a process of its own: it can be killed, and it reads its own environment. It is this very test program,
//! started again.

use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

use rts_agent::Config;
use rts_agent_api::AgentApi;
use rts_host::cgroup::{Cgroup, Cgroups, Choice};
use rts_plan::observed::ManagerObserved;
use rts_plan::plan::Work;
use rustix::process::{Pid, Signal, kill_process};
use tokio::time::{Instant, sleep};

use crate::setup::{Node, PATIENCE, batch, lives, start_manager, step};

/// Not a test of its own: the agent.
#[test]
#[ignore = "started by other tests as an agent"]
fn process() {
    let home = PathBuf::from(std::env::var_os("RTS_TEST_HOME").expect("is started by a test"));
    rts_agent::run(config(&home)).unwrap();
}

fn config(home: &Path) -> Config {
    Config {
        home: home.to_owned(),
        node: "local".to_owned(),
        aliases: Vec::new(),
        module_path: vec![home.to_owned()],
        manager_program: home.join("manager"),
        controller_socket: None,
        heal_after: home
            .join("heals")
            .exists()
            .then_some(Duration::from_millis(100)),
        idle_managers: std::fs::read_to_string(home.join("idle"))
            .ok()
            .map(|idle| idle.trim().parse().unwrap()),
    }
}

/// What a manager does before it serves: it starts a child that ignores SIGTERM, and one that leaves its process group
/// too. Not before it is where it belongs: a real manager starts nothing before it was spoken to.
pub const FAMILY: &str = r#"
[ "$RTSCTL_CGROUP" = off ] || until grep -q /rtsctl- /proc/$$/cgroup; do sleep 0.01; done
sh -c 'trap "" TERM; echo $$ >> "$0/children"; exec sleep 1000' "$RTS_TEST_HOME" &
setsid sh -c 'trap "" TERM; echo $$ >> "$0/runaways"; exec sleep 1000' "$RTS_TEST_HOME" &
until [ -s "$RTS_TEST_HOME/children" ] && [ -s "$RTS_TEST_HOME/runaways" ]; do sleep 0.01; done
"#;

/// A manager program that runs `before` and then serves.
pub fn serving(before: &str) -> String {
    let test = std::env::current_exe().unwrap();
    format!(
        "{before}\nexport RTS_FAKE_BEHAVIOUR= RTS_FAKE_ARGS=\"$*\"\nexec '{}' --exact fake_manager::process --ignored --nocapture --test-threads=1\n",
        test.display()
    )
}

/// An agent in its home.
pub struct AgentProcess {
    pub node: Node,
    choice: &'static str,
    child: Child,
}

impl AgentProcess {
    /// Starts it. Its managers are this shell script; `choice` is for `RTSCTL_CGROUP`.
    pub async fn start(choice: &'static str, script: &str) -> Self {
        let home = tempfile::Builder::new()
            .prefix("rts")
            .tempdir_in("/tmp")
            .unwrap();
        let config = config(home.path());
        std::fs::write(&config.manager_program, format!("#!/bin/sh\n{script}\n")).unwrap();
        let mode = std::fs::Permissions::from_mode(0o700);
        std::fs::set_permissions(&config.manager_program, mode).unwrap();
        let child = spawn(home.path(), choice);
        let this = Self {
            node: Node::of_process(home, config),
            choice,
            child,
        };
        this.serves().await;
        this
    }

    /// Starts it with the real manager program, a zygote, and so many managers that are ready.
    pub async fn warm(choice: &'static str, idle: u8) -> Self {
        let test = std::env::current_exe().unwrap();
        let program = test.ancestors().nth(2).unwrap().join("rts-manager");
        assert!(program.exists(), "build it: cargo build --workspace --bins");
        Self::warm_with(choice, idle, |home| {
            std::os::unix::fs::symlink(&program, home.join("manager")).unwrap();
        })
        .await
    }

    /// The same with the manager program that is put into the home.
    pub async fn warm_with(choice: &'static str, idle: u8, put: impl FnOnce(&Path)) -> Self {
        let home = tempfile::Builder::new()
            .prefix("rts")
            .tempdir_in("/tmp")
            .unwrap();
        std::fs::write(home.path().join("idle"), idle.to_string()).unwrap();
        put(home.path());
        let config = config(home.path());
        let child = spawn(home.path(), choice);
        let this = Self {
            node: Node::of_process(home, config),
            choice,
            child,
        };
        this.serves().await;
        this
    }

    /// Processes of this home with this name that live.
    pub fn named(&self, name: &str) -> Vec<u32> {
        let home = self.node.home.path().as_os_str().as_encoded_bytes();
        let is_ours = |pid: &u32| {
            let read =
                |file: &str| std::fs::read(format!("/proc/{pid}/{file}")).unwrap_or_default();
            let line = read("cmdline");
            lives(*pid)
                && read("comm").trim_ascii_end() == name.as_bytes()
                && line.windows(home.len()).any(|part| part == home)
        };
        let processes = std::fs::read_dir("/proc").unwrap().flatten();
        let mut found: Vec<u32> = processes
            .filter_map(|entry| entry.file_name().to_str()?.parse().ok())
            .filter(is_ours)
            .collect();
        found.sort_unstable();
        found
    }

    /// Starts it again after it was killed.
    pub async fn start_again(&mut self) {
        self.child = spawn(self.node.home.path(), self.choice);
        self.serves().await;
    }

    async fn serves(&self) {
        let end = Instant::now() + PATIENCE;
        while self.node.agent.node().await.is_err() {
            assert!(Instant::now() < end, "the agent does not serve");
            sleep(Duration::from_millis(5)).await;
        }
    }

    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    pub fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Waits until it has ended by itself.
    pub async fn ended(&mut self) -> ExitStatus {
        let end = Instant::now() + PATIENCE;
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status;
            }
            assert!(Instant::now() < end, "the agent goes on");
            sleep(Duration::from_millis(5)).await;
        }
    }

    /// Starts a manager; gives how that went.
    pub async fn start_manager(&self, plan: &str, name: &str) -> String {
        let batch = batch(plan, 1, vec![start_manager(1, name)]);
        self.node.outcomes(&batch).await.remove(0).1
    }

    /// Stops a manager; gives how that went.
    pub async fn stop_manager(&self, plan: &str, observed: &ManagerObserved) -> String {
        let work = Work::StopManager {
            manager: observed.key.clone(),
            incarnation: observed.incarnation.clone(),
        };
        // For whatever it was told last.
        let held = self.node.agent.node_spec().await;
        let generation = held.map_or(1, |held| held.generation);
        let batch = batch(plan, generation, vec![step(1, &[], "manager", work)]);
        self.node.outcomes(&batch).await.remove(0).1
    }

    /// The only manager.
    pub async fn manager(&self) -> ManagerObserved {
        let inventory = self.node.agent.inventory().await.unwrap();
        assert_eq!(inventory.managers.len(), 1);
        inventory.managers[0].clone()
    }

    /// Numbers in a file of the home.
    pub fn pids(&self, file: &str) -> Vec<u32> {
        let text = std::fs::read_to_string(self.node.home.path().join(file)).unwrap_or_default();
        text.lines().filter_map(|pid| pid.parse().ok()).collect()
    }

    /// Control groups of its home.
    pub fn cgroups(&self) -> Vec<Cgroup> {
        Cgroups::of(self.node.home.path(), Choice::Auto).find()
    }
}

impl Drop for AgentProcess {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        for pid in [self.pids("children"), self.pids("runaways")].concat() {
            if lives(pid) {
                let _ = kill_process(Pid::from_raw(pid as i32).unwrap(), Signal::KILL);
            }
        }
    }
}

fn spawn(home: &Path, choice: &str) -> Child {
    let log = std::fs::File::options()
        .append(true)
        .create(true)
        .open(home.join("agent.log"))
        .unwrap();
    Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "agent_process::process", "--ignored"])
        .args(["--nocapture", "--test-threads=1"])
        .env("RTS_TEST_HOME", home)
        .env(rts_host::cgroup::VARIABLE, choice)
        .stdin(Stdio::null())
        .stdout(log.try_clone().unwrap())
        .stderr(log)
        .spawn()
        .unwrap()
}

/// Waits until something is so.
pub async fn until(what: &str, done: impl Fn() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !done() {
        assert!(Instant::now() < end, "not in time: {what}");
        sleep(Duration::from_millis(5)).await;
    }
}
