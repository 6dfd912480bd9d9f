//! Nodes that are reached by SSH alone, at a real server.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use rts_test_sshd::{HOST, Server, Setup, for_test};
use rts_tests::{Said, Stack, alive, kill_9, processes_of};
use serde_json::Value;

const HELLO: &str = "manifests/hello/system.xml";
/// Profiles of the corpus, and how many components they have.
const PROFILES: [(&str, usize); 3] = [
    ("Nobu19800__CrawlerSystem__Crawler.rtsys", 8),
    ("gbiggs__rtshell__sys.rtsys", 2),
    (
        "sugarsweetrobotics__vrep_mcl_test__MobileRobotSystem.xml",
        6,
    ),
];
/// Longest wait for what takes a moment.
const PATIENCE: Duration = Duration::from_secs(30);

/// A stack, and a machine that is reached by SSH.
struct Lab {
    stack: Stack,
    server: Server,
    far: tempfile::TempDir,
}

impl Lab {
    /// With one node over there, which has the programs already. None where there is no SSH server.
    fn new(arguments: &[&str]) -> Option<Self> {
        let lab = Self::bare(None)?;
        link_programs(&lab.home().join("programs"));
        lab.add(0, arguments);
        Some(lab)
    }

    /// Without a node; `namespace` is what the server's mounts are made by.
    fn bare(namespace: Option<&dyn Fn(&Path) -> String>) -> Option<Self> {
        let far = tempfile::Builder::new().prefix("rtsf").tempdir_in("/tmp");
        let far = far.expect("a folder in /tmp");
        let home = far.path().display().to_string();
        let setup = Setup {
            namespace: namespace.map(|namespace| namespace(far.path())),
            ..Setup::home(far.path()).with("XDG_STATE_HOME", &home)
        };
        let server = for_test(setup)?;
        let stack = Stack::new();
        Some(Self { stack, server, far })
    }

    /// Adds the machine as the node `arm`.
    #[track_caller]
    fn add(&self, code: i32, arguments: &[&str]) -> Said {
        let words = ["node", "add", "--ssh", HOST, "--name", "arm"];
        let config = self.server.config().display().to_string();
        let words = [&words[..], &["--ssh-config", &config], arguments].concat();
        self.stack.expect(code, &words)
    }

    /// Runs a command over there, past `rtsctl`.
    #[track_caller]
    fn run(&self, command: &str) {
        let mut ssh = Command::new("ssh");
        ssh.arg("-F")
            .arg(self.server.config())
            .args([HOST, command]);
        let status = ssh.stdin(Stdio::null()).status();
        assert!(status.is_ok_and(|status| status.success()), "{command}");
    }

    /// The home over there.
    fn home(&self) -> PathBuf {
        self.far.path().join("rtsctl")
    }

    fn log(&self) -> String {
        let log = self.stack.home().join("logs/arm/agent.log");
        std::fs::read_to_string(log).unwrap_or_default()
    }

    fn copied(&self) -> usize {
        self.log().matches("copied module").count() + self.log().matches("copied programs").count()
    }

    /// Incarnation and process of each component.
    fn components(&self) -> BTreeMap<String, (String, u64)> {
        let of = |c: Value| {
            let text = |v: &Value| v.as_str().unwrap_or_default().to_owned();
            let pid = c["status"]["pid"].as_u64().unwrap_or_default();
            assert_eq!(c["status"]["node"], "arm");
            assert_eq!(c["status"]["state"], "Active", "{c:#}");
            (
                text(&c["metadata"]["name"]),
                (text(&c["status"]["incarnation"]), pid),
            )
        };
        self.stack.get("components").into_iter().map(of).collect()
    }

    /// The process that a file of a run folder names.
    fn pid(&self, file: &Path) -> u32 {
        let text = std::fs::read(file).unwrap_or_default();
        let identity: Value = serde_json::from_slice(&text).unwrap_or_default();
        identity["pid"]
            .as_u64()
            .expect("a process")
            .try_into()
            .expect("a pid")
    }

    fn far_agent(&self) -> u32 {
        self.pid(&self.home().join("run/arm/stdio.json"))
    }

    fn relay(&self) -> u32 {
        self.pid(&self.stack.home().join("run/arm/relay.json"))
    }

    /// Nothing is left over there but what was copied.
    fn assert_gone(&self) {
        let managers = processes_of(&self.home().join("run/arm"));
        assert!(managers.is_empty(), "{managers:?}");
    }
}

impl Drop for Lab {
    fn drop(&mut self) {
        let _ = self.stack.rtsctl(&["down", "--yes"]);
        processes_of(&self.home()).into_iter().for_each(kill_9);
    }
}

/// Puts the programs into their places as a copy would, which takes seconds for what is built for debugging.
fn link_programs(folder: &Path) {
    for name in ["rts-agent", "rts-manager"] {
        let program = rts_tests::program(name);
        let (digest, _) = rts_ssh::digest_of(&program).expect("it is read");
        let place = folder.join(digest);
        std::fs::create_dir_all(&place).expect("the folder is made");
        std::os::unix::fs::symlink(&program, place.join(name)).expect("the link is made");
    }
}

fn until(what: &str, done: impl Fn() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !done() {
        assert!(Instant::now() < end, "{what} within {PATIENCE:?}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn a_system_lives_on_a_node_that_is_reached_by_ssh() {
    let Some(lab) = Lab::bare(None) else {
        return;
    };
    lab.add(0, &["--alias", "robot1", "--keep", "1"]);
    let stack = &lab.stack;
    let said = stack.expect(0, &["apply", HELLO]);
    assert!(
        said.err
            .contains("between commands nothing there is healed"),
        "{said:#?}"
    );
    let before = lab.components();
    assert_eq!(before.len(), 3);
    let copied = lab.copied();
    assert!(copied > 1, "{}", lab.log());
    stack.expect(0, &["diff", HELLO]);
    stack.expect(0, &["apply", HELLO]);
    assert_eq!(lab.components(), before, "nothing was started again");
    let node = stack.named("nodes", "arm");
    assert_eq!(node["spec"]["transport"]["kind"], "ssh");
    assert_eq!(node["status"]["state"], "Ready");
    let log = stack.expect(0, &["logs", "Printer0", "--tail", "5"]);
    assert!(!log.out.is_empty(), "{log:#?}");
    stack.expect(0, &["conf", "Sine0", "set", "amplitude=2.5"]);

    // Left alone, the session is closed; what runs goes on, and the next command finds it as it was.
    let (agent, relay) = (lab.far_agent(), lab.relay());
    until("the relay and the agent over there end", || {
        !alive(agent) && !alive(relay)
    });
    assert!(
        before
            .values()
            .all(|(_, pid)| alive(u32::try_from(*pid).expect("a pid")))
    );
    assert_eq!(lab.components(), before);

    // Killed over there, and killed here: found again, and nothing is started or copied a second time.
    kill_9(lab.far_agent());
    assert_eq!(lab.components(), before);
    kill_9(lab.relay());
    assert_eq!(lab.components(), before);
    assert_eq!(lab.copied(), copied, "{}", lab.log());
    let run = std::fs::read_dir(stack.home().join("run/arm")).expect("a folder");
    let names = run.map(|entry| entry.expect("an entry").file_name());
    let of_sessions = names.filter(|name| name.to_string_lossy().starts_with(".ssh."));
    assert!(of_sessions.count() <= 1, "what the killed one left is gone");

    let refused = stack.expect(2, &["down"]);
    assert!(refused.err.contains("on node arm"), "{refused:#?}");
    stack.expect(0, &["teardown", "hello", "--yes"]);
    lab.assert_gone();

    // Samples do not come through the session: a system over two nodes is refused before anything is touched.
    stack.expect(0, &["up", "--node", "base"]);
    let said = stack.expect(
        3,
        &["apply", "-f", HELLO, "-f", "manifests/hello/nodes.yaml"],
    );
    assert!(said.err.contains("reached by ssh alone"), "{said:#?}");
    assert!(stack.get("systems").is_empty());
    // A name means one machine.
    let config = lab.server.config().display().to_string();
    let other = ["node", "add", "--ssh", "somebody@robot", "--name", "arm"];
    let said = stack.expect(2, &[&other[..], &["--ssh-config", &config]].concat());
    assert!(said.err.contains("rtsctl node remove arm"), "{said:#?}");
    let check = ["check", HELLO, "-f", "manifests/hello/nodes.yaml"];
    let said = stack.expect(1, &check);
    assert!(said.out.contains("error[no-transport]"), "{said:#?}");
    let said = stack.expect(0, &["node", "remove", "arm"]);
    for kind in ["programs", "modules"] {
        let left = lab.home().join(kind);
        assert!(!left.exists(), "{kind} that nobody needs: {said:#?}");
    }
    let nodes = stack.get("nodes");
    assert!(
        nodes.iter().all(|node| node["metadata"]["name"] != "arm"),
        "it is not shown any more: {said:#?} {nodes:#?}"
    );
    assert_eq!(lab.copied(), copied, "{}", lab.log());
}

#[test]
fn profiles_that_users_wrote_run_on_a_node_that_is_reached_by_ssh() {
    let Ok(corpus) = std::env::var("RTSCTL_CORPUS") else {
        println!("skipped: RTSCTL_CORPUS is not set");
        return;
    };
    let Some(lab) = Lab::new(&[]) else {
        return;
    };
    for (profile, components) in PROFILES {
        let file = format!("{corpus}/rts/{profile}");
        let said = lab.stack.expect(0, &["apply", &file, "--stand-ins"]);
        let told = format!("{components} of {components} are stand-ins");
        assert!(said.out.contains(&told), "{said:#?}");
        assert_eq!(lab.components().len(), components);
        let system = lab.stack.get("systems").remove(0);
        let name = system["metadata"]["name"].as_str().expect("a name");
        lab.stack.expect(0, &["teardown", name, "--yes"]);
        lab.assert_gone();
    }
}

#[test]
fn an_apply_goes_on_when_its_session_is_killed() {
    let Some(lab) = Lab::new(&[]) else {
        return;
    };
    // Slow enough to be in the middle when the first of its processes is there.
    let slow = lab.stack.home().join("slow.yaml");
    let text = "apiVersion: rtsctl.dev/v1\nkind: Deployment\nspec: { components: { \"*\": { standIn: { when: always, startupTime: 2s } } } }\n";
    std::fs::write(&slow, text).expect("it is written");
    let words = ["apply", "-f", HELLO, "-f", slow.to_str().expect("a path")];
    let mut apply = lab.stack.command(&words);
    let apply = apply
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    until("a manager starts", || {
        !processes_of(&lab.home().join("run/arm")).is_empty()
    });
    lab.server.kill_sessions();
    let said = apply.wait_with_output().expect("it ends");
    let err = String::from_utf8_lossy(&said.stderr);
    assert!(err.contains("was lost"), "{err}");
    assert_eq!(said.status.code(), Some(0), "it goes on by itself: {err}");
    let components = lab.components();
    assert_eq!(components.len(), 3);
    let managers: std::collections::BTreeSet<u64> =
        components.values().map(|(_, pid)| *pid).collect();
    assert_eq!(managers.len(), 2);
    lab.stack.expect(0, &["teardown", "hello", "--yes"]);
    lab.assert_gone();
}

#[test]
fn a_node_that_lets_nobody_in_is_told_with_its_exit_code() {
    let Some(server) = for_test(Setup {
        stranger: true,
        ..Setup::default()
    }) else {
        return;
    };
    let stack = Stack::new();
    let config = server.config().display().to_string();
    let add = ["node", "add", "--ssh", HOST, "--ssh-config", &config];
    let arm = [&add[..], &["--name", "arm"]].concat();
    let said = stack.expect(8, &arm);
    assert!(
        said.err.contains("let nobody in") && said.err.contains("help:"),
        "{said:#?}"
    );
    server.know_nothing().expect("the file is written");
    let said = stack.expect(8, &arm);
    assert!(said.err.contains("--accept-new"), "{said:#?}");
    let said = stack.expect(0, &["get", "nodes"]);
    assert!(!said.err.contains("arm"), "it was not added: {said:#?}");
    assert_eq!(stack.get("nodes").len(), 0);
    // The name of a node of this machine.
    stack.expect(0, &["up"]);
    let said = stack.expect(2, &[&add[..], &["--name", "local"]].concat());
    assert!(said.err.contains("agent of this machine"), "{said:#?}");
}

#[test]
fn a_disk_that_is_full_over_there_is_told_and_holds_up_no_teardown() {
    if !rustix::process::geteuid().is_root() {
        eprintln!("SKIPPED: needs root (mount)");
        return;
    }
    // Programs and modules lie beside the small disk once they are linked.
    let mounts = |far: &Path| {
        let far = far.display();
        format!("mkdir {far}/copies {far}/rtsctl; mount -t tmpfs -o size=1m tmpfs {far}/rtsctl")
    };
    let Some(lab) = Lab::bare(Some(&mounts)) else {
        return;
    };
    let (home, copies) = (lab.home(), lab.far.path().join("copies"));
    let home = home.display();
    let said = lab.add(5, &[]);
    assert!(said.err.contains("the disk of robot is full"), "{said:#?}");
    lab.run(&format!("mount -o remount,ro {home}"));
    let said = lab.add(8, &[]);
    assert!(said.err.contains("has no permission for"), "{said:#?}");
    assert!(lab.stack.get("nodes").is_empty(), "it was not added");

    let (programs, modules) = (copies.join("programs"), copies.join("modules"));
    link_programs(&programs);
    std::fs::create_dir(&modules).expect("the folder is made");
    let mut script = format!("set -e; mount -o remount,rw {home}; rm -rf {home}/*");
    for (kind, folder) in [("programs", programs), ("modules", modules)] {
        let folder = folder.display();
        script += &format!("; mkdir {home}/{kind}; mount --bind {folder} {home}/{kind}");
    }
    lab.run(&script);
    lab.add(0, &[]);
    lab.stack.expect(0, &["apply", HELLO]);
    lab.run(&format!("cat /dev/zero >{home}/filler 2>/dev/null; true"));
    // An agent starts there for a command, and takes things down.
    kill_9(lab.relay());
    let said = lab.stack.expect(0, &["teardown", "hello", "--yes"]);
    assert!(said.out.contains("is gone"), "{said:#?}");
    lab.assert_gone();
}
