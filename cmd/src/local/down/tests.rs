//! With processes that play daemons, managers and what those start.

use std::path::Path;
use std::time::{Duration, Instant};

use rts_host::cgroup::{Cgroups, Choice};
use rts_host::identity::Identity;
use rts_manager_api::files::{LOCK, MANAGER_JSON, ManagerFile};

use super::*;
use crate::local::lock::is_held;

fn home(folder: &Path) -> Home {
    Home::settle(Some(folder.to_owned())).unwrap()
}

#[test]
fn a_home_where_nothing_runs_has_nothing_to_stop() {
    let temp = tempfile::tempdir().unwrap();
    let stopped = stop(&home(temp.path())).unwrap();
    assert_eq!(stopped, Stopped::default());
    assert_eq!(stopped.words(), "nothing was running");
}

#[test]
fn what_was_stopped_is_said() {
    let stopped = Stopped {
        relays: vec!["arm".to_owned()],
        controller: true,
        agents: vec!["local".to_owned()],
        managers: vec!["hello.Printer0".to_owned(), "hello.main".to_owned()],
        killed: Vec::new(),
        left: Vec::new(),
    };
    insta::assert_snapshot!(stopped.words(), @"stopped the controller, 1 SSH relay, 1 agent and 2 managers (hello.Printer0, hello.main)");
}

/// A process of its own group, as a daemon is.
fn daemon(program: &str, args: &[&str]) -> std::process::Child {
    use std::os::unix::process::CommandExt;
    let mut command = std::process::Command::new(program);
    command.args(args).process_group(0).spawn().unwrap()
}

fn write_json(path: &Path, value: &impl serde::Serialize) {
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, serde_json::to_vec(value).unwrap()).unwrap();
}

#[test]
fn the_controller_of_the_run_folder_is_stopped_and_no_other_process_with_its_number() {
    let temp = tempfile::tempdir().unwrap();
    let home = home(temp.path());
    let mut child = daemon("sleep", &["60"]);
    let mut identity = Identity::of(child.id()).unwrap();
    identity.start_ticks += 1;
    write_json(&home.controller_json(), &identity);
    assert_eq!(stop(&home).unwrap(), Stopped::default());
    assert!(
        child.try_wait().unwrap().is_none(),
        "another one was killed"
    );
    identity.start_ticks -= 1;
    write_json(&home.controller_json(), &identity);
    assert!(stop(&home).unwrap().controller);
    assert!(!child.wait().unwrap().success());
}

#[test]
fn a_manager_that_does_not_listen_is_stopped_with_its_children() {
    let temp = tempfile::tempdir().unwrap();
    let home = home(temp.path());
    let folder = home.node_run("local").join("01234567");
    std::fs::create_dir_all(&folder).unwrap();
    let lock = folder.join(LOCK);
    // The child that inherits the lock plays the component's grandchild.
    let mut child = daemon("flock", &[lock.to_str().unwrap(), "sleep", "60"]);
    let identity = Identity::of(child.id()).unwrap();
    let file = ManagerFile {
        protocol_version: 1,
        system: Some(rts_manager_api::control::SystemId {
            name: "hello".to_owned(),
            uid: "u".to_owned(),
        }),
        name: "main".to_owned(),
        incarnation: "i".to_owned(),
        pid: identity.pid,
        start_ticks: identity.start_ticks,
        boot_id: identity.boot_id,
        started: String::new(),
        cgroup: None,
    };
    write_json(&folder.join(MANAGER_JSON), &file);
    let end = Instant::now() + Duration::from_secs(10);
    while !is_held(&lock).unwrap() {
        assert!(Instant::now() < end, "flock does not lock");
        std::thread::sleep(Duration::from_millis(1));
    }
    let live = live_managers(&home).unwrap();
    assert_eq!(
        live.iter().map(LiveManager::system).collect::<Vec<_>>(),
        [Some("hello")]
    );
    assert_eq!(stop(&home).unwrap().managers, ["hello.main"]);
    assert!(!is_held(&lock).unwrap());
    assert!(!child.wait().unwrap().success());
}

#[test]
fn a_lock_whose_holder_is_not_known_is_reported_and_nothing_is_guessed() {
    let temp = tempfile::tempdir().unwrap();
    let home = home(temp.path());
    std::fs::create_dir_all(home.run()).unwrap();
    let file = std::fs::File::create(home.controller_lock()).unwrap();
    rustix::fs::flock(&file, rustix::fs::FlockOperation::LockExclusive).unwrap();
    let stopped = stop(&home).unwrap();
    assert_eq!(stopped.left.len(), 1);
    assert!(
        stopped.left[0].contains("controller.lock"),
        "{:?}",
        stopped.left
    );
}

/// What a child of a manager writes about itself to the file that is its first argument.
const CHILD: &str = "trap '' TERM; echo $$ > \"$0\"; exec sleep 1000";

/// The child that wrote its number there, once it sleeps.
fn pid_in(file: &Path) -> u32 {
    let end = Instant::now() + Duration::from_secs(10);
    let sleeps = |pid: &u32| {
        let name = std::fs::read_to_string(format!("/proc/{pid}/comm"));
        name.is_ok_and(|name| name.trim() == "sleep")
    };
    loop {
        let text = std::fs::read_to_string(file).unwrap_or_default();
        if let Some(pid) = text.trim().parse().ok().filter(sleeps) {
            return pid;
        }
        assert!(Instant::now() < end, "nothing sleeps of {}", file.display());
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn lives(pid: u32) -> bool {
    use rts_host::process::Process;
    Process::open(pid).is_some_and(|process| !process.ended(Duration::ZERO))
}

#[test]
fn what_a_dead_manager_started_is_killed_by_its_control_group_without_a_run_folder() {
    let temp = tempfile::tempdir().unwrap();
    let home = home(&temp.path().join("home"));
    let cgroups = Cgroups::of(home.path(), Choice::Auto);
    let cgroup = match cgroups.create("local.01234567") {
        Ok(cgroup) => cgroup,
        Err(e) => return eprintln!("skipped: {e}"),
    };
    let pid_file = temp.path().join("pid");
    // A session of its own, as of a grandchild that ran away.
    let script = format!(
        "read go; exec setsid sh -c '{}' \"$0\"",
        CHILD.replace('\'', "'\\''")
    );
    let mut child = std::process::Command::new("/bin/sh")
        .args(["-c", &script])
        .arg(&pid_file)
        .stdin(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    cgroup.join(child.id()).unwrap();
    drop(child.stdin.take());
    let pid = pid_in(&pid_file);
    let stopped = stop(&home).unwrap();
    assert!(!lives(pid));
    child.wait().unwrap();
    assert_eq!(stopped.left, Vec::<String>::new());
    assert_eq!(stopped.words(), "stopped what dead managers had started");
    let force = stopped.force().unwrap();
    assert!(
        force.contains(&format!("sleep (pid {pid}) of manager local.01234567")),
        "{force}"
    );
    assert!(!cgroup.path().exists());
    assert!(!cgroup.path().parent().unwrap().exists());
    assert_eq!(stop(&home).unwrap(), Stopped::default());
}

#[test]
fn what_a_dead_manager_left_in_its_process_group_is_killed_but_not_a_group_of_another_boot() {
    let temp = tempfile::tempdir().unwrap();
    let home = home(temp.path());
    let folder = home.node_run("local").join("01234567");
    let pid_file = temp.path().join("pid");
    let mut leader = daemon(
        "sh",
        &[
            "-c",
            &format!("sh -c '{}' \"$0\" & wait", CHILD.replace('\'', "'\\''")),
            pid_file.to_str().unwrap(),
        ],
    );
    let identity = Identity::of(leader.id()).unwrap();
    let pid = pid_in(&pid_file);
    leader.kill().unwrap();
    leader.wait().unwrap();
    let mut file = ManagerFile {
        protocol_version: 1,
        system: None,
        name: "bench".to_owned(),
        incarnation: "i".to_owned(),
        pid: identity.pid,
        start_ticks: identity.start_ticks,
        boot_id: "of the day before".to_owned(),
        started: String::new(),
        cgroup: None,
    };
    write_json(&folder.join(MANAGER_JSON), &file);
    assert_eq!(stop(&home).unwrap(), Stopped::default());
    assert!(lives(pid));
    file.boot_id = identity.boot_id;
    write_json(&folder.join(MANAGER_JSON), &file);
    let stopped = stop(&home).unwrap();
    assert!(!lives(pid));
    assert_eq!(stopped.killed, ["what manager bench had started"]);
}
