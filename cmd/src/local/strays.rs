//! Processes of a home that its run folder no longer tells of: found in `/proc` by their program and arguments.

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use rts_host::process::Process;

use super::home::Home;

/// The programs of a stack, in the order in which they are stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Program {
    /// `rts-controller`.
    Controller,
    /// `rts-relay`.
    Relay,
    /// `rts-agent`.
    Agent,
    /// `rts-manager`.
    Manager,
    /// `rts-manager` that an agent keeps ready to become a manager.
    Spare,
}

impl Program {
    fn file_name(self) -> &'static str {
        match self {
            Program::Controller => "rts-controller",
            Program::Relay => "rts-relay",
            Program::Agent => "rts-agent",
            Program::Manager | Program::Spare => "rts-manager",
        }
    }
}

/// How often a process is asked for its arguments until it has some.
const LOOKS: u32 = 20;
/// Time between two of these looks.
const LOOK: std::time::Duration = std::time::Duration::from_millis(1);

/// A process of ours that works for a home.
#[derive(Debug)]
pub struct Stray {
    /// The process itself: its number cannot come to mean another one.
    pub process: Process,
    /// Name of its node or manager (`hello.main`), else of its program.
    pub name: String,
    /// System of a manager.
    pub system: Option<String>,
}

/// All processes of this user that run a program of ours for this home.
pub fn find(home: &Home, program: Program) -> Vec<Stray> {
    let Ok(processes) = std::fs::read_dir("/proc") else {
        return Vec::new();
    };
    let pids = processes.filter_map(|entry| entry.ok()?.file_name().to_str()?.parse().ok());
    let mut found: Vec<_> = pids.filter_map(|pid| look(pid, home, program)).collect();
    found.sort_by(|a, b| a.name.cmp(&b.name));
    found
}

fn look(pid: u32, home: &Home, program: Program) -> Option<Stray> {
    // Opened first: what is read while it lives is about this very process.
    let process = Process::open(pid)?;
    let folder = PathBuf::from(format!("/proc/{pid}"));
    let own = rustix::process::geteuid().as_raw();
    (std::fs::metadata(&folder).ok()?.uid() == own).then_some(())?;
    let exe = std::fs::read_link(folder.join("exe")).ok()?;
    (base_name(&exe) == Some(program.file_name())).then_some(())?;
    let arguments = arguments_of(&folder.join("cmdline"))?;
    let arguments = Arguments::of(&arguments);
    arguments.is_of(home, program).then_some(())?;
    (!process.ended(std::time::Duration::ZERO)).then_some(())?;
    Some(Stray {
        process,
        name: arguments.name(program),
        system: arguments.text("--system-name"),
    })
}

/// The arguments of a process. One that is just being started has its program before it has arguments: those are waited
/// for, a moment.
fn arguments_of(cmdline: &Path) -> Option<Vec<u8>> {
    for _ in 0..LOOKS {
        let arguments = std::fs::read(cmdline).ok()?;
        if !arguments.is_empty() {
            return Some(arguments);
        }
        std::thread::sleep(LOOK);
    }
    None
}

/// File name of a program; the kernel marks one that was replaced on disk.
fn base_name(exe: &Path) -> Option<&str> {
    let name = exe.file_name()?.to_str()?;
    Some(name.strip_suffix(" (deleted)").unwrap_or(name))
}

struct Arguments<'a>(Vec<&'a [u8]>);

impl<'a> Arguments<'a> {
    fn of(cmdline: &'a [u8]) -> Self {
        Self(cmdline.split(|byte| *byte == 0).collect())
    }

    /// The value of `--key value` or `--key=value`.
    fn value(&self, key: &str) -> Option<&'a OsStr> {
        let key = key.as_bytes();
        let at = self.0.iter().position(|argument| {
            argument
                .strip_prefix(key)
                .is_some_and(|rest| rest.is_empty() || rest[0] == b'=')
        })?;
        let bytes = match self.0[at].get(key.len() + 1..) {
            Some(value) => value,
            None => self.0.get(at + 1)?,
        };
        Some(OsStr::from_bytes(bytes))
    }

    fn text(&self, key: &str) -> Option<String> {
        let text = self.value(key)?.to_string_lossy().into_owned();
        (!text.is_empty()).then_some(text)
    }

    fn is_of(&self, home: &Home, program: Program) -> bool {
        match program {
            Program::Controller | Program::Relay | Program::Agent => self.names(home),
            Program::Spare => {
                let is_spare = |word: &&[u8]| [&b"--zygote"[..], b"--idle"].contains(word);
                self.0.get(1).is_some_and(is_spare) && self.names(home)
            }
            // `H/run/<node>/<id>`.
            Program::Manager => self.value("--dir").is_some_and(|folder| {
                let run = Path::new(folder).parent().and_then(Path::parent);
                let of = run
                    .filter(|run| run.ends_with("run"))
                    .and_then(Path::parent);
                of.is_some_and(|of| same(of, home.path()))
            }),
        }
    }

    fn names(&self, home: &Home) -> bool {
        self.value("--home")
            .is_some_and(|of| same(Path::new(of), home.path()))
    }

    fn name(&self, program: Program) -> String {
        let name = match program {
            Program::Controller => None,
            Program::Spare => Some("a process that was kept ready".to_owned()),
            Program::Relay | Program::Agent => self.text("--node"),
            Program::Manager => match (self.text("--system-name"), self.text("--name")) {
                (Some(system), Some(name)) => Some(format!("{system}.{name}")),
                (_, name) => name,
            },
        };
        name.unwrap_or_else(|| program.file_name().to_owned())
    }
}

/// The same folder, perhaps by way of a link.
fn same(a: &Path, b: &Path) -> bool {
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    a == b || (real(a).is_some() && real(a) == real(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::{Child, Command};

    fn home(path: &str) -> Home {
        Home::settle(Some(PathBuf::from(path))).unwrap()
    }

    fn is_of(cmdline: &[u8], program: Program) -> bool {
        Arguments::of(cmdline).is_of(&home("/tmp/h"), program)
    }

    #[test]
    fn only_processes_of_this_home_are_meant() {
        use Program::{Agent, Controller, Manager};
        assert!(is_of(b"/x/rts-controller\0--home\0/tmp/h\0", Controller));
        assert!(is_of(b"rts-agent\0--node\0local\0--home=/tmp/h\0", Agent));
        assert!(!is_of(b"rts-agent\0--home\0/tmp/h2\0", Agent));
        assert!(!is_of(b"rts-agent\0--home\0", Agent));
        assert!(!is_of(b"rts-agent\0--homely\0/tmp/h\0", Agent));
        assert!(is_of(
            b"rts-manager\0--dir\0/tmp/h/run/local/01234567\0",
            Manager
        ));
        assert!(!is_of(
            b"rts-manager\0--dir\0/tmp/h2/run/local/01234567\0",
            Manager
        ));
        assert!(!is_of(
            b"rts-manager\0--dir\0/tmp/h/x/local/01234567\0",
            Manager
        ));
    }

    #[test]
    fn what_is_kept_ready_is_no_manager() {
        use Program::{Manager, Spare};
        for what in ["--zygote", "--idle"] {
            let line = format!("m\0{what}\0--home\0/tmp/h\0\0\0");
            assert!(is_of(line.as_bytes(), Spare) && !is_of(line.as_bytes(), Manager));
            let other = format!("m\0{what}\0--home\0/tmp/h2\0");
            assert!(!is_of(other.as_bytes(), Spare));
        }
        assert!(!is_of(b"m\0--dir\0/tmp/h/run/local/01234567\0\0", Spare));
        assert!(is_of(b"m\0--dir\0/tmp/h/run/local/01234567\0\0", Manager));
    }

    #[test]
    fn a_manager_is_named_as_people_know_it() {
        let name = |cmdline: &[u8]| Arguments::of(cmdline).name(Program::Manager);
        assert_eq!(
            name(b"m\0--name\0main\0--system-name\0hello\0"),
            "hello.main"
        );
        assert_eq!(name(b"m\0--name\0bench\0"), "bench");
    }

    /// `sleep` under the name of a program of ours.
    fn disguised(folder: &Path, program: Program, arguments: &[&str]) -> Child {
        let path = folder.join(program.file_name());
        std::fs::copy("/bin/sh", &path).unwrap();
        Command::new(path)
            .args(["-c", "read line"])
            .args(arguments)
            .stdin(std::process::Stdio::piped())
            .spawn()
            .unwrap()
    }

    #[test]
    fn a_process_is_found_by_program_and_home() {
        let temp = tempfile::tempdir().unwrap();
        let own = home(temp.path().join("h").to_str().unwrap());
        let home_text = own.path().to_str().unwrap().to_owned();
        let arguments = ["--home", &home_text, "--node", "local"];
        let mut child = disguised(temp.path(), Program::Agent, &arguments);
        let found = find(&own, Program::Agent);
        let names: Vec<_> = found.iter().map(|stray| stray.name.as_str()).collect();
        assert_eq!(names, ["local"]);
        assert_eq!(found[0].process.pid(), i32::try_from(child.id()).unwrap());
        assert!(find(&own, Program::Controller).is_empty());
        assert!(find(&home("/tmp/another"), Program::Agent).is_empty());
        drop(child.stdin.take());
        child.wait().unwrap();
        assert!(find(&own, Program::Agent).is_empty());
    }
}
