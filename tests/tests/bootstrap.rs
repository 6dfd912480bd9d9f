//! An agent that is installed over SSH, on a real server: from a bare account to nothing left.

#![allow(
    clippy::unwrap_used,
    reason = "what cannot go on fails the test that called it"
)]

use std::fs::File;
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use rts_host::cgroup::{Cgroups, Choice};
use rts_test_sshd::{HOST, Server, Setup, for_test};
use rts_tests::{Stack, alive, kill, processes_of, program, root};
use serde_json::Value;

/// Longest wait for anything.
const PATIENCE: Duration = Duration::from_secs(60);

/// A machine that is reached by SSH, and programs for it.
struct Robot {
    server: Server,
    folder: tempfile::TempDir,
    /// Folder of rtsctl there.
    home: PathBuf,
}

impl Robot {
    /// Sessions have a home of their own.
    fn new() -> Option<Self> {
        let folder = tempfile::Builder::new()
            .prefix("rtsb")
            .tempdir_in("/tmp")
            .unwrap();
        let account = folder.path().join("a");
        std::fs::create_dir(&account).unwrap();
        let server = for_test(Setup::home(&account))?;
        let home = account.join(".local/state/rtsctl");
        Some(Self {
            server,
            folder,
            home,
        })
    }

    /// A folder with the programs, smaller than they are built, and `padding` bytes larger then.
    fn programs(&self, name: &str, padding: usize) -> PathBuf {
        let folder = self.folder.path().join(name);
        std::fs::create_dir(&folder).unwrap();
        for name in ["rts-agent", "rts-manager"] {
            let (from, to) = (program(name), folder.join(name));
            let stripped = Command::new("strip").arg("-o").arg(&to).arg(&from).status();
            if !stripped.is_ok_and(|status| status.success()) {
                std::fs::copy(&from, &to).unwrap();
            }
            let mut file = File::options().append(true).open(&to).unwrap();
            file.write_all(&vec![b'x'; padding]).unwrap();
        }
        folder
    }

    /// `rtsctl` in the home that is on the far side, which is on this machine after all.
    fn command(&self, words: &[&str]) -> Command {
        let mut command = Command::new(program("rtsctl"));
        command.args(words).current_dir(root()).stdin(Stdio::null());
        command.env("RTSCTL_HOME", &self.home).env("NO_COLOR", "1");
        command.env("RTSCTL_MODULE_PATH", rts_tests::programs());
        command
    }

    fn node(&self, verb: &str, words: &[&str]) -> Command {
        let mut command = self.command(&["node", verb, HOST, "--name", "arm", "--ssh-config"]);
        command.arg(self.server.config()).args(words);
        command
    }

    #[track_caller]
    fn bootstrap(&self, programs: &Path, words: &[&str]) -> Value {
        let mut command = self.node("bootstrap", &["-o", "json"]);
        let said = expect(0, command.arg("--programs").arg(programs).args(words));
        serde_json::from_slice(&said.stdout).unwrap()
    }

    /// The agent's process and its program.
    fn agent(&self) -> Option<(u32, PathBuf)> {
        let text = std::fs::read(self.home.join("run/arm/agent.json")).ok()?;
        let json: Value = serde_json::from_slice(&text).ok()?;
        let pid = u32::try_from(json["pid"].as_u64()?).ok()?;
        Some((pid, std::fs::read_link(format!("/proc/{pid}/exe")).ok()?))
    }

    fn managers(&self) -> Vec<u32> {
        let named = |pid: &u32| {
            std::fs::read_to_string(format!("/proc/{pid}/comm"))
                .is_ok_and(|c| c.trim() == "rts-manager")
        };
        processes_of(&self.home).into_iter().filter(named).collect()
    }
}

impl Drop for Robot {
    fn drop(&mut self) {
        self.server.kill();
        processes_of(&self.home).into_iter().for_each(kill);
    }
}

#[track_caller]
fn expect(code: i32, command: &mut Command) -> Output {
    let output = command.output().unwrap();
    assert_eq!(
        output.status.code(),
        Some(code),
        "{command:?} said {}",
        text(&output)
    );
    output
}

fn text(output: &Output) -> String {
    [&output.stdout, &output.stderr]
        .map(|bytes| String::from_utf8_lossy(bytes).into_owned())
        .concat()
}

#[track_caller]
fn until(what: &str, mut done: impl FnMut() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !done() {
        assert!(Instant::now() < end, "still not: {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let each = paths.flat_map(|path| {
        if path.is_dir() {
            files(&path, ending)
        } else {
            vec![path]
        }
    });
    each.filter(|path| path.to_string_lossy().ends_with(ending))
        .collect()
}

#[test]
fn a_process_is_installed_after_a_cut_upgraded_while_a_manager_runs_and_removed() {
    let Some(mut robot) = Robot::new() else {
        return;
    };
    let (old, new) = (robot.programs("old", 24 << 20), robot.programs("new", 0));

    let key = robot.server.host_key().unwrap();
    robot.server.know_nothing().unwrap();
    let unknown = text(&expect(8, &mut robot.node("bootstrap", &[])));
    assert!(
        unknown.contains("is not known: it shows ssh-ed25519 SHA256:"),
        "{unknown}"
    );
    assert!(unknown.contains("--accept-new"), "{unknown}");
    robot.server.know(&key).unwrap();

    let dry = robot.bootstrap(&old, &["--dry-run"]);
    assert_eq!(
        (
            dry["changed"].as_bool(),
            dry["changes"].as_array().unwrap().len()
        ),
        (Some(false), 4)
    );
    assert!(!robot.home.exists());

    // The server dies while a program is being sent.
    let mut cut: Child = robot
        .node("bootstrap", &["--programs"])
        .arg(&old)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    until("a program is being sent", || {
        assert_eq!(cut.try_wait().unwrap(), None, "it ended before it was cut");
        !files(&robot.home, ".part").is_empty()
    });
    robot.server.kill();
    let cut = cut.wait_with_output().unwrap();
    assert_eq!(cut.status.code(), Some(4), "{}", text(&cut));
    assert!(
        text(&cut).contains("was lost") && text(&cut).contains("run the same again"),
        "{}",
        text(&cut)
    );
    assert_eq!(
        (files(&robot.home, "/rts-agent"), robot.agent()),
        (Vec::new(), None)
    );
    robot.server.restart().unwrap();

    let first = robot.bootstrap(&old, &[]);
    assert_eq!(
        (first["keeper"].as_str(), first["changed"].as_bool()),
        (Some("process"), Some(true))
    );
    assert!(
        first["notes"][1].as_str().unwrap().starts_with("@reboot /"),
        "{first:#}"
    );
    until("halves are removed", || {
        files(&robot.home, ".part").is_empty()
    });
    let (agent, program) = robot.agent().unwrap();
    let again = robot.bootstrap(&old, &[]);
    assert_eq!(
        (again["changed"].as_bool(), robot.agent().unwrap().0),
        (Some(false), agent),
        "{again:#}"
    );

    let modules = [
        "libsine_source.so",
        "liblow_pass_filter.so",
        "libprinter.so",
    ];
    let modules = modules.map(|name| rts_tests::programs().join(name).display().to_string());
    let mut words: Vec<&str> = Vec::new();
    modules
        .iter()
        .for_each(|module| words.extend(["--module", module]));
    let modular = robot.bootstrap(&old, &words);
    assert_eq!(modular["changed"].as_bool(), Some(true));
    // A home joins the agent that lives there, by its name.
    let (resident, _) = robot.agent().unwrap();
    let stack = Stack::new();
    let (config, programs) = (robot.server.config(), old.display().to_string());
    let config = config.display().to_string();
    let mut words = vec!["node", "add", "--ssh", HOST, "--name", "arm"];
    words.extend(["--ssh-config", &config, "--programs", &programs]);
    let joined = stack.expect(0, &words);
    assert!(!joined.err.contains("healed"), "{joined:#?}");
    stack.expect(0, &["apply", "manifests/hello/system.xml"]);
    let managers = robot.managers();
    assert_eq!(robot.agent().unwrap().0, resident, "it kept its node");
    assert!(!managers.is_empty());

    let upgraded = robot.bootstrap(&new, &[]);
    assert_eq!(upgraded["changed"].as_bool(), Some(true));
    let (second, other) = robot.agent().unwrap();
    assert!(second != agent && other != program, "{upgraded:#}");
    assert!(program.exists(), "the home that has joined uses it, too");
    assert_eq!(robot.managers(), managers);
    let greeted = |nodes: &[Value]| nodes.iter().all(|node| node["status"]["state"] == "Ready");
    stack.until("nodes", "the new agent has greeted", greeted);
    let diff = stack.expect(0, &["diff", "manifests/hello/system.xml"]);
    assert_eq!(robot.managers(), managers, "{diff:#?}");

    // What dies is started again by the same verb.
    kill(second);
    until("the agent is dead", || !alive(second));
    robot.bootstrap(&new, &[]);
    assert_ne!(robot.agent().unwrap().0, second);

    let refused = text(&expect(7, &mut robot.node("unbootstrap", &[])));
    assert!(
        refused.contains("still run on") && refused.contains("--yes"),
        "{refused}"
    );
    // By the home that has joined it: what it knew of the node was of before.
    let mut words = vec!["node", "unbootstrap", HOST, "--name", "arm", "--yes"];
    words.extend(["--ssh-config", &config]);
    let said = stack.expect(0, &words);
    assert!(said.err.contains("rtsctl node remove arm"), "{said:#?}");
    until("its own process there has ended", || {
        processes_of(&robot.home).is_empty()
    });
    stack.expect(0, &["node", "remove", "arm", "--force"]);
    assert_eq!(
        Cgroups::of(&robot.home, Choice::Auto).folders(),
        Vec::<PathBuf>::new()
    );
    for gone in [
        "run/arm",
        "state/arm",
        "logs/arm",
        "services",
        "programs",
        "modules",
    ] {
        assert!(!robot.home.join(gone).exists(), "{gone} is still there");
    }
    let nothing = text(&expect(0, &mut robot.node("unbootstrap", &[])));
    assert!(nothing.contains("nothing to remove"), "{nothing}");
}

/// An account of this machine that nobody ever logged in to, removed at the end.
struct Account(String);

impl Account {
    fn new(home: &Path) -> Option<Self> {
        let name = format!("rtsb{}", std::process::id());
        let mut command = Command::new("useradd");
        command
            .args(["-m", "-k", "/nonexistent", "-s", "/bin/sh", "-p", "*", "-d"])
            .arg(home)
            .arg(&name);
        let made = command.output().is_ok_and(|output| output.status.success());
        made.then_some(Self(name))
    }
}

impl Drop for Account {
    fn drop(&mut self) {
        let _ = Command::new("userdel").args(["-r", "-f", &self.0]).output();
    }
}

/// Plays `systemctl --user` for one unit.
const SYSTEMCTL: &str = r#"#!/bin/sh
[ "$1" = --user ] || exit 1
shift
unit=$HOME/.config/systemd/user/rtsctl-agent-arm.service
echo "$@" >>"$HOME/told"
stop() {
    [ -f "$HOME/pid" ] || return
    kill "$(cat "$HOME/pid")"
    while kill -0 "$(cat "$HOME/pid")" 2>/dev/null; do sleep 0.05; done
    rm "$HOME/pid"
}
case "$1" in
enable) [ -f "$unit" ] || exit 1 ;;
restart)
    stop
    setsid sh -c "exec $(sed -n 's/^ExecStart=//p' "$unit")" </dev/null >/dev/null 2>&1 &
    echo $! >"$HOME/pid"
    ;;
disable) [ "$2" = --now ] && stop ;;
esac
exit 0
"#;

#[test]
fn a_bare_account_gets_a_unit_of_its_own_and_is_bare_again() {
    let folder = tempfile::Builder::new()
        .prefix("rtsb")
        .tempdir_in("/tmp")
        .unwrap();
    std::fs::set_permissions(folder.path(), std::fs::Permissions::from_mode(0o755)).unwrap();
    let home = folder.path().join("pi");
    let account = match rustix::process::geteuid().is_root() {
        true => Account::new(&home),
        false => None,
    };
    let Some(account) = account else {
        eprintln!("SKIPPED: needs root and `useradd`");
        return;
    };
    let tools = folder.path().join("bin");
    std::fs::create_dir(&tools).unwrap();
    for (name, script) in [
        ("systemctl", SYSTEMCTL),
        ("loginctl", "#!/bin/sh\nexit 1\n"),
    ] {
        std::fs::write(tools.join(name), script).unwrap();
        std::fs::set_permissions(tools.join(name), std::fs::Permissions::from_mode(0o755)).unwrap();
    }
    // What tells that systemd runs, and that it has services of this account.
    let runtime = folder.path().join("r");
    std::fs::create_dir_all(runtime.join("systemd")).unwrap();
    let _private = std::os::unix::net::UnixListener::bind(runtime.join("systemd/private")).unwrap();
    let setup = Setup {
        user: Some(account.0.clone()),
        namespace: Some(
            "mount -t tmpfs tmpfs /run; mkdir -p /run/sshd /run/systemd/system".to_owned(),
        ),
        ..Setup::default()
    };
    let setup = setup
        .with("PATH", &format!("{}:/usr/bin:/bin", tools.display()))
        .with("XDG_RUNTIME_DIR", &runtime.display().to_string());
    let Some(server) = for_test(setup) else {
        return;
    };
    let home_there = home.join(".local/state/rtsctl");
    let robot = Robot {
        server,
        folder,
        home: home_there,
    };
    let programs = robot.programs("p", 0);

    let installed = robot.bootstrap(&programs, &["--alias", "robot.local"]);
    assert_eq!(
        (installed["keeper"].as_str(), installed["unit"].as_str()),
        (Some("user-unit"), Some("rtsctl-agent-arm.service"))
    );
    assert!(
        installed["notes"][0]
            .as_str()
            .unwrap()
            .contains("loginctl enable-linger"),
        "{installed:#}"
    );
    let (agent, _) = robot.agent().unwrap();
    let status = std::fs::read_to_string(format!("/proc/{agent}/status")).unwrap();
    let uid = status
        .lines()
        .find(|line| line.starts_with("Uid:"))
        .unwrap();
    assert!(!uid.contains("\t0\t"), "the agent is of the account: {uid}");
    let unit = std::fs::read_to_string(home.join(".config/systemd/user/rtsctl-agent-arm.service"))
        .unwrap();
    assert!(
        unit.contains("\nKillMode=process\n") && unit.contains(" --alias robot.local\n"),
        "{unit}"
    );

    // Only what is missing is still tried: services that outlive a login.
    let again = robot.bootstrap(&programs, &["--alias", "robot.local"]);
    assert_eq!(again["changes"].as_array().unwrap().len(), 1, "{again:#}");
    assert_eq!(robot.agent().unwrap().0, agent);

    expect(0, &mut robot.node("unbootstrap", &[]));
    assert!(!alive(agent));
    let told = std::fs::read_to_string(home.join("told")).unwrap();
    assert_eq!(
        told.lines().collect::<Vec<_>>(),
        [
            "daemon-reload",
            "enable rtsctl-agent-arm.service",
            "restart rtsctl-agent-arm.service",
            "disable --now rtsctl-agent-arm.service",
            "daemon-reload"
        ]
    );
    let left: Vec<_> = std::fs::read_dir(&home)
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    assert_eq!(left, ["told"], "only what this test put there is left");
}
