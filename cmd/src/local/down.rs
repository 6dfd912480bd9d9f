//! Stops the local stack from its run folder alone, with every daemon dead if need be.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rts_host::identity::Identity;
use rts_host::process::{Process, signal_group};
use rts_manager_api::client::Client;
use rts_manager_api::control::RequestBody;
use rts_manager_api::files::{CONTROL_SOCKET, LOCK, MANAGER_JSON, ManagerFile};
use rustix::process::Signal;

use super::home::Home;
use super::lock::is_held;
use super::strays::{self, Program, Stray};
use super::{LocalError, plural};

/// Time for each gentle step before a harder one.
const GRACE: Duration = Duration::from_secs(5);
/// Longest wait for a killed process to be gone.
const KILLED: Duration = Duration::from_secs(5);
/// How long a manager may take from its folder's making to its lock.
const STARTING: Duration = Duration::from_secs(1);
/// Most looks at the run folder; more than fit into [`STARTING`].
const MAX_ROUNDS: u32 = 100;
/// Time between two looks at the run folder.
const PAUSE: Duration = Duration::from_millis(50);

/// What was stopped.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Stopped {
    /// The controller.
    pub controller: bool,
    /// Agents, by node.
    pub agents: Vec<String>,
    /// Managers, by display name.
    pub managers: Vec<String>,
    /// What would not stop, and why.
    pub left: Vec<String>,
}

impl Stopped {
    /// `stopped the controller, 1 agent and 2 managers`.
    pub fn words(&self) -> String {
        let mut parts = Vec::new();
        if self.controller {
            parts.push("the controller".to_owned());
        }
        if !self.agents.is_empty() {
            parts.push(plural("agent", self.agents.len()));
        }
        if !self.managers.is_empty() {
            let (count, names) = (self.managers.len(), self.managers.join(", "));
            parts.push(format!("{} ({names})", plural("manager", count)));
        }
        match parts.split_last() {
            None => "nothing was running".to_owned(),
            Some((last, [])) => format!("stopped {last}"),
            Some((last, rest)) => format!("stopped {} and {last}", rest.join(", ")),
        }
    }
}

/// A manager that holds its lock.
#[derive(Debug, Clone)]
pub struct LiveManager {
    folder: PathBuf,
    file: Option<ManagerFile>,
}

impl LiveManager {
    /// `hello.main`, or its folder when it did not say who it is.
    pub fn display_name(&self) -> String {
        match &self.file {
            Some(file) => match &file.system {
                Some(system) => format!("{}.{}", system.name, file.name),
                None => file.name.clone(),
            },
            None => self.folder.display().to_string(),
        }
    }

    /// System that it belongs to.
    pub fn system(&self) -> Option<&str> {
        Some(self.file.as_ref()?.system.as_ref()?.name.as_str())
    }
}

/// Managers that live now, over all nodes.
pub fn live_managers(home: &Home) -> Result<Vec<LiveManager>, LocalError> {
    let mut found = Vec::new();
    for node in folders(&home.run())? {
        for folder in folders(&node)? {
            if is_held(&folder.join(LOCK))? {
                let bytes = std::fs::read(folder.join(MANAGER_JSON)).ok();
                let file = bytes.and_then(|b| serde_json::from_slice(&b).ok());
                found.push(LiveManager { folder, file });
            }
        }
    }
    Ok(found)
}

/// Stops everything: first who could start things anew, then the managers, all at once.
pub fn stop(home: &Home) -> Result<Stopped, LocalError> {
    let mut stopped = Stopped::default();
    let controller = stop_daemon(
        "the controller",
        &home.controller_json(),
        &home.controller_lock(),
    )?;
    stopped.controller = controller.note(&mut stopped.left);
    stopped.controller |= !stop_strays(home, Program::Controller, &mut stopped.left).is_empty();
    for node in folders(&home.run())? {
        let name = name_of(&node);
        let (json, lock) = (node.join("agent.json"), node.join("agent.lock"));
        let outcome = stop_daemon(&format!("the agent of node {name}"), &json, &lock)?;
        if outcome.note(&mut stopped.left) {
            stopped.agents.push(name);
        }
    }
    let agents = stop_strays(home, Program::Agent, &mut stopped.left);
    stopped.agents.extend(agents);
    stop_managers(home, &mut stopped)?;
    let managers = stop_strays(home, Program::Manager, &mut stopped.left);
    stopped.managers.extend(managers);
    stopped.managers.sort();
    Ok(stopped)
}

/// Systems with managers that live now, whether the run folder tells of them or not.
pub fn systems(home: &Home) -> Result<BTreeSet<String>, LocalError> {
    let known = live_managers(home)?;
    let known = known.iter().filter_map(LiveManager::system);
    let mut systems: BTreeSet<_> = known.map(str::to_owned).collect();
    let strays = strays::find(home, Program::Manager);
    systems.extend(strays.into_iter().filter_map(|stray| stray.system));
    Ok(systems)
}

/// Stops what the run folder no longer tells of, all at once; gives the names of what was stopped.
fn stop_strays(home: &Home, program: Program, left: &mut Vec<String>) -> Vec<String> {
    let strays = strays::find(home, program);
    let signal = |stray: &Stray, signal| {
        // A daemon's group is its own; what it started is stopped by itself.
        if program == Program::Manager {
            stray.process.signal_group(signal);
        } else {
            stray.process.signal(signal);
        }
    };
    for (kind, grace) in [(Signal::TERM, GRACE), (Signal::KILL, KILLED)] {
        let lives = |stray: &&Stray| !stray.process.ended(Duration::ZERO);
        strays
            .iter()
            .filter(lives)
            .for_each(|stray| signal(stray, kind));
        let end = Instant::now() + grace;
        for stray in &strays {
            stray
                .process
                .ended(end.saturating_duration_since(Instant::now()));
        }
    }
    let mut stopped = Vec::new();
    for stray in strays {
        let (name, pid) = (stray.name, stray.process.pid());
        if stray.process.ended(Duration::ZERO) {
            stopped.push(name);
        } else {
            left.push(format!("{name} (pid {pid}) does not die"));
        }
    }
    stopped
}

/// Goes round until no manager is alive and none is just being started.
fn stop_managers(home: &Home, stopped: &mut Stopped) -> Result<(), LocalError> {
    let end = Instant::now() + STARTING;
    for _ in 0..MAX_ROUNDS {
        let live = live_managers(home)?;
        if !live.is_empty() {
            let outcomes = std::thread::scope(|scope| {
                let threads: Vec<_> = live
                    .iter()
                    .map(|manager| scope.spawn(|| stop_manager(manager)))
                    .collect();
                let joined = threads.into_iter().map(std::thread::ScopedJoinHandle::join);
                joined.collect::<Vec<_>>()
            });
            for (manager, outcome) in live.iter().zip(outcomes) {
                let name = manager.display_name();
                match outcome {
                    Ok(Outcome::Left(reason)) => stopped.left.push(reason),
                    Ok(_) => stopped.managers.push(name),
                    Err(_) => stopped
                        .left
                        .push(format!("manager {name}: stopping it failed")),
                }
            }
            if !stopped.left.is_empty() {
                return Ok(());
            }
        } else if Instant::now() >= end || !any_starting(home)? {
            stopped.managers.sort();
            return Ok(());
        }
        std::thread::sleep(PAUSE);
    }
    stopped
        .left
        .push("managers are started again and again".to_owned());
    Ok(())
}

/// A manager's folder without its file: its process may be about to take the lock.
fn any_starting(home: &Home) -> Result<bool, LocalError> {
    for node in folders(&home.run())? {
        for folder in folders(&node)? {
            if !folder.join(MANAGER_JSON).exists() {
                return Ok(true);
            }
        }
    }
    Ok(false)
}

/// How the end of one process went.
enum Outcome {
    Absent,
    Stopped,
    Left(String),
}

impl Outcome {
    /// True when it was stopped; what is left goes to the list.
    fn note(self, left: &mut Vec<String>) -> bool {
        match self {
            Outcome::Absent => false,
            Outcome::Stopped => true,
            Outcome::Left(reason) => {
                left.push(reason);
                false
            }
        }
    }
}

fn stop_daemon(what: &str, json: &Path, lock: &Path) -> Result<Outcome, LocalError> {
    let Some(process) = Identity::read(json).and_then(|identity| Process::identified(&identity))
    else {
        return Ok(if is_held(lock)? {
            Outcome::Left(format!(
                "{what} holds {} but {} does not say which process it is",
                lock.display(),
                json.display()
            ))
        } else {
            Outcome::Absent
        });
    };
    process.signal(Signal::TERM);
    if !process.ended(GRACE) {
        process.signal(Signal::KILL);
        if !process.ended(KILLED) {
            let pid = process.pid();
            return Ok(Outcome::Left(format!("{what} (pid {pid}) does not die")));
        }
    }
    Ok(Outcome::Stopped)
}

/// Asks, then SIGTERM, then SIGKILL; the last two to the whole process group.
fn stop_manager(manager: &LiveManager) -> Outcome {
    let name = manager.display_name();
    let client = Client::connect(&manager.folder.join(CONTROL_SOCKET), GRACE).ok();
    let process = match (&manager.file, &client) {
        (Some(file), _) => Process::identified(&Identity {
            pid: file.pid,
            start_ticks: file.start_ticks,
            boot_id: file.boot_id.clone(),
            version: String::new(),
        }),
        (None, Some(client)) => Process::open(client.hello().pid),
        (None, None) => None,
    };
    let Some(process) = process else {
        return match is_held(&manager.folder.join(LOCK)) {
            // It ended by itself in the meantime.
            Ok(false) => Outcome::Stopped,
            _ => Outcome::Left(format!(
                "manager {name} holds {} but its process is not known",
                manager.folder.join(LOCK).display()
            )),
        };
    };
    let asked = client.is_some_and(|mut c| c.call(RequestBody::Shutdown, GRACE).is_ok());
    let gone = (asked && process.ended(GRACE))
        || {
            process.signal_group(Signal::TERM);
            process.ended(GRACE)
        }
        || {
            process.signal_group(Signal::KILL);
            process.ended(KILLED)
        };
    let pid = process.pid();
    if !gone {
        return Outcome::Left(format!("manager {name} (pid {pid}) does not die"));
    }
    if let Ok(leader) = u32::try_from(pid) {
        let _ = signal_group(leader, Signal::KILL);
    }
    // Its folder without its file would look like a manager that is about to start.
    let _ = std::fs::remove_dir_all(&manager.folder);
    Outcome::Stopped
}

/// The folders in a folder, sorted; none when it is not there. Links are not followed.
fn folders(path: &Path) -> Result<Vec<PathBuf>, LocalError> {
    let entries = match std::fs::read_dir(path) {
        Ok(entries) => entries,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(e) => return Err(LocalError::file("read", path)(e)),
    };
    let mut found: Vec<_> = entries
        .filter_map(Result::ok)
        .filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()))
        .map(|entry| entry.path())
        .collect();
    found.sort();
    Ok(found)
}

fn name_of(path: &Path) -> String {
    path.file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

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
            controller: true,
            agents: vec!["local".to_owned()],
            managers: vec!["hello.Printer0".to_owned(), "hello.main".to_owned()],
            left: Vec::new(),
        };
        insta::assert_snapshot!(stopped.words(), @"stopped the controller, 1 agent and 2 managers (hello.Printer0, hello.main)");
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
}
