//! End-to-end tests: real processes in a folder of their own, driven by the real `rtsctl`.
//!
//! The tests are in `tests/`; this library is their harness. Programs and modules are those beside the test in the
//! target folder.

pub mod chaos;
mod daemons;
mod processes;
mod profile;
pub mod soak;
mod witness;

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use rts_host::cgroup::{Cgroups, Choice};
use serde_json::Value;

pub use daemons::{kill_9, signal};
pub use processes::{alive, kill, processes_of};
pub use profile::Profile;
pub use witness::{Seen, Witness};

/// A local stack with its own `RTSCTL_HOME`, taken down at the end.
pub struct Stack {
    folder: tempfile::TempDir,
    modules: Option<PathBuf>,
}

/// What a command said.
#[derive(Debug)]
pub struct Said {
    /// Exit code; -1 when a signal ended it.
    pub code: i32,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl Default for Stack {
    fn default() -> Self {
        Self::new()
    }
}

impl Stack {
    /// An empty home; nothing is started yet.
    pub fn new() -> Self {
        let folder = tempfile::Builder::new()
            .prefix("rts")
            .tempdir_in("/tmp")
            .expect("a folder in /tmp");
        Self {
            folder,
            modules: None,
        }
    }

    /// A home whose agent looks for modules in `modules` first, then beside the programs.
    pub fn with_modules(modules: &Path) -> Self {
        let mut stack = Self::new();
        stack.modules = Some(modules.to_owned());
        stack
    }

    /// The `RTSCTL_HOME`.
    pub fn home(&self) -> PathBuf {
        self.folder.path().join("h")
    }

    /// A file in the stack's folder.
    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
        let file = self.folder.path().join(name);
        std::fs::write(&file, text).expect("a file in the test's folder");
        file
    }

    /// `rtsctl` with these arguments, in the folder of the workspace.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(program("rtsctl"));
        command
            .args(arguments)
            .current_dir(root())
            .stdin(Stdio::null());
        command
            .env("RTSCTL_HOME", self.home())
            .env("NO_COLOR", "1")
            .env("TERM", "dumb");
        if let Some(modules) = &self.modules {
            let paths =
                std::env::join_paths([modules.clone(), programs()]).expect("paths without colons");
            command.env("RTSCTL_MODULE_PATH", paths);
        }
        command
    }

    /// Runs `rtsctl` to its end.
    pub fn rtsctl(&self, arguments: &[&str]) -> Said {
        let output = self.command(arguments).output().expect("rtsctl starts");
        Said::of(&output, self)
    }

    /// Runs `rtsctl`, which must end with `code`.
    #[track_caller]
    pub fn expect(&self, code: i32, arguments: &[&str]) -> Said {
        let said = self.rtsctl(arguments);
        assert_eq!(said.code, code, "rtsctl {arguments:?} said {said:#?}");
        said
    }

    /// `rtsctl get KIND -o json`, parsed.
    #[track_caller]
    pub fn get(&self, kind: &str) -> Vec<Value> {
        let said = self.expect(0, &["get", kind, "-o", "json"]);
        let list: Value = serde_json::from_str(&said.out).expect("JSON on stdout");
        assert_eq!(list["apiVersion"], "rtsctl.dev/v1");
        assert_eq!(list["kind"], "List");
        list["items"].as_array().expect("items").clone()
    }

    /// The object of that name.
    #[track_caller]
    pub fn named(&self, kind: &str, name: &str) -> Value {
        let items = self.get(kind);
        let found = items.iter().find(|item| item["metadata"]["name"] == name);
        found
            .unwrap_or_else(|| panic!("no {name} among {items:#?}"))
            .clone()
    }

    /// Asks until `done` is content with the objects of a kind, at most 10 s.
    #[track_caller]
    pub fn until(&self, kind: &str, what: &str, done: impl Fn(&[Value]) -> bool) -> Vec<Value> {
        let deadline = Instant::now() + Duration::from_secs(10);
        loop {
            let items = self.get(kind);
            if done(&items) {
                return items;
            }
            assert!(
                Instant::now() < deadline,
                "after 10 s still not: {what}; {kind} are {items:#?}"
            );
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Takes the stack down and makes sure that nothing is left of it.
    #[track_caller]
    pub fn leaves_nothing(&self) {
        self.expect(0, &["down", "--purge", "--yes"]);
        assert!(
            !self.home().exists(),
            "{} is still there",
            self.home().display()
        );
        let left = processes_of(&self.home());
        assert!(left.is_empty(), "processes are left: {left:?}");
        let groups = Cgroups::of(&self.home(), Choice::Auto).folders();
        assert!(groups.is_empty(), "cgroups are left: {groups:?}");
    }
}

impl Drop for Stack {
    fn drop(&mut self) {
        if self.home().exists() {
            let _ = self.rtsctl(&["down", "--purge", "--yes"]);
        }
        for pid in processes_of(&self.home()) {
            kill(pid);
        }
    }
}

impl Said {
    fn of(output: &Output, stack: &Stack) -> Self {
        let home = stack.home().display().to_string();
        let folder = stack.folder.path().display().to_string();
        let programs = programs().display().to_string();
        let tidy = |bytes: &[u8]| {
            let text = String::from_utf8_lossy(bytes);
            text.replace(&home, "$HOME")
                .replace(&folder, "$FOLDER")
                .replace(&programs, "$TARGET")
        };
        Self {
            code: output.status.code().unwrap_or(-1),
            out: tidy(&output.stdout),
            err: tidy(&output.stderr),
        }
    }
}

/// The folder of the workspace.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("the crate lies in the workspace")
        .to_owned()
}

/// The folder of the built programs and modules: that of this program, and the one above it for a test.
pub fn programs() -> PathBuf {
    let own = std::env::current_exe().expect("the program's own path");
    let folder = own.parent().expect("a folder");
    match folder.ends_with("deps") {
        true => folder.parent().expect("a target folder").to_owned(),
        false => folder.to_owned(),
    }
}

/// A built program.
///
/// # Panics
/// When it is not built; the message names the command.
pub fn program(name: &str) -> PathBuf {
    let path = programs().join(name);
    assert!(
        path.is_file(),
        "{} is missing: run `cargo build --workspace` first",
        path.display()
    );
    path
}
