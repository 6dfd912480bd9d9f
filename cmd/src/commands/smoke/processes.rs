//! All processes of a stack, also those that its components started and that have left their parents: told by the
//! environment that they inherit, or by the run folder that they work in.

use std::collections::{BTreeMap, BTreeSet};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rts_host::process::Process;
use rts_manager_api::files::{MANAGER_JSON, ManagerFile};
use rustix::process::Signal;

/// Longest wait for a process to end by itself, or once it was killed.
const PATIENCE: Duration = Duration::from_secs(5);
/// Time between two looks.
const PAUSE: Duration = Duration::from_millis(20);
/// Folder of shared memory.
const SHARED: &str = "/dev/shm/";

/// What was seen of the processes of a home.
#[derive(Debug, Clone, Default)]
pub struct Family {
    home: PathBuf,
    /// Run folder → manager.
    managers: BTreeMap<PathBuf, String>,
    /// Shared memory that somebody had.
    shared: BTreeSet<PathBuf>,
}

/// A process that lives.
struct Member {
    process: Process,
    folder: PathBuf,
}

impl Family {
    /// Nothing was seen yet.
    pub fn of(home: &Path) -> Self {
        Self {
            home: home.to_owned(),
            ..Self::default()
        }
    }

    /// Remembers what lives now and what it has.
    pub fn look(&mut self) {
        for node in entries(&self.home.join("run")) {
            for folder in entries(&node) {
                if let Some(name) = manager_of(&folder) {
                    self.managers.insert(folder, name);
                }
            }
        }
        for member in self.members() {
            let maps = std::fs::read_to_string(member.folder.join("maps")).unwrap_or_default();
            let mapped = maps.lines().filter_map(|line| line.split_once(SHARED));
            let mapped = mapped.map(|(_, name)| Path::new(SHARED).join(name));
            self.shared.extend(mapped);
        }
    }

    /// Waits until all have ended. Who has not is killed, and named.
    pub fn end(&self) -> Vec<String> {
        let end = Instant::now() + PATIENCE;
        let mut members = self.members();
        while !members.is_empty() && Instant::now() < end {
            std::thread::sleep(PAUSE);
            members = self.members();
        }
        let left = members.iter().map(|member| self.text(member)).collect();
        for member in &members {
            member.process.signal(Signal::KILL);
        }
        for member in &members {
            member.process.ended(PATIENCE);
        }
        left
    }

    /// Shared memory that is still there.
    pub fn shared(&self) -> Vec<String> {
        let left = self.shared.iter().filter(|path| path.exists());
        left.map(|path| path.display().to_string()).collect()
    }

    fn members(&self) -> Vec<Member> {
        let found = entries(Path::new("/proc")).into_iter();
        let mut found: Vec<_> = found.filter_map(|folder| self.member(folder)).collect();
        found.sort_by_key(|member| member.process.pid());
        found
    }

    fn member(&self, folder: PathBuf) -> Option<Member> {
        let pid: u32 = folder.file_name()?.to_str()?.parse().ok()?;
        if pid == std::process::id() {
            return None;
        }
        // Opened first: what is read while it lives is about this very process.
        let process = Process::open(pid)?;
        let own = rustix::process::geteuid().as_raw();
        (std::fs::metadata(&folder).ok()?.uid() == own).then_some(())?;
        (self.inherited(&folder) || self.works_here(&folder)).then_some(())?;
        (!process.ended(Duration::ZERO)).then_some(Member { process, folder })
    }

    fn inherited(&self, folder: &Path) -> bool {
        let environment = std::fs::read(folder.join("environ")).unwrap_or_default();
        let wanted = [b"RTSCTL_HOME=", self.home.as_os_str().as_bytes()].concat();
        environment
            .split(|byte| *byte == 0)
            .any(|one| one == wanted)
    }

    fn works_here(&self, folder: &Path) -> bool {
        std::fs::read_link(folder.join("cwd"))
            .is_ok_and(|cwd| cwd.starts_with(self.home.join("run")))
    }

    /// `process sleep (pid 4711) of manager hello.main`.
    fn text(&self, member: &Member) -> String {
        let name = std::fs::read_to_string(member.folder.join("comm")).unwrap_or_default();
        let cwd = std::fs::read_link(member.folder.join("cwd")).unwrap_or_default();
        let cwd = cwd.to_string_lossy();
        // The kernel marks a folder that was removed.
        let cwd = Path::new(cwd.strip_suffix(" (deleted)").unwrap_or(&cwd));
        let of = self.managers.get(cwd);
        let of = of.map_or_else(String::new, |name| format!(" of manager {name}"));
        format!("process {} (pid {}){of}", name.trim(), member.process.pid())
    }
}

/// Name of the manager that has this run folder.
fn manager_of(folder: &Path) -> Option<String> {
    let bytes = std::fs::read(folder.join(MANAGER_JSON)).ok()?;
    let file: ManagerFile = serde_json::from_slice(&bytes).ok()?;
    Some(match file.system {
        Some(system) => format!("{}.{}", system.name, file.name),
        None => file.name,
    })
}

/// What lies in a folder; nothing when it is not there.
fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::{Child, Command, Stdio};

    /// A process that waits for its end of input.
    fn waiting(command: &mut Command) -> Child {
        let command = command.args(["-c", "read line"]).stdin(Stdio::piped());
        command.spawn().unwrap()
    }

    #[test]
    fn who_inherited_the_home_or_works_in_its_run_folder_is_found_named_and_ended() {
        let temp = tempfile::tempdir().unwrap();
        let home = temp.path().canonicalize().unwrap();
        let folder = home.join("run/local/01234567");
        std::fs::create_dir_all(&folder).unwrap();
        let file = serde_json::json!({"protocolVersion": 1, "system": {"name": "hello", "uid": "u"}, "name": "main",
            "incarnation": "i", "pid": 1, "startTicks": 1, "bootId": "b", "started": ""});
        std::fs::write(folder.join(MANAGER_JSON), file.to_string()).unwrap();
        let mut inherited = waiting(Command::new("sh").env("RTSCTL_HOME", &home));
        let mut works = waiting(Command::new("sh").current_dir(&folder));
        let mut other = waiting(Command::new("sh").env("RTSCTL_HOME", home.join("x")));
        let mut family = Family::of(&home);
        family.look();
        std::fs::remove_dir_all(&folder).unwrap();
        let mut expected = [
            format!("process sh (pid {})", inherited.id()),
            format!("process sh (pid {}) of manager hello.main", works.id()),
        ];
        let mut left = family.end();
        left.sort();
        expected.sort();
        assert_eq!(left, expected);
        for child in [&mut inherited, &mut works] {
            assert!(!child.wait().unwrap().success());
        }
        assert!(other.try_wait().unwrap().is_none());
        drop(other.stdin.take());
        other.wait().unwrap();
        assert_eq!(Family::of(&home).end(), Vec::<String>::new());
    }

    #[test]
    fn shared_memory_that_was_there_before_and_still_is_is_left() {
        let temp = tempfile::NamedTempFile::new().unwrap();
        let gone = temp.path().with_extension("gone");
        let family = Family {
            shared: BTreeSet::from([temp.path().to_owned(), gone]),
            ..Family::default()
        };
        assert_eq!(family.shared(), [temp.path().display().to_string()]);
    }
}
