//! `rtsctl smoke`: what passes, what fails and how it is told, and that nothing is ever left of it.

mod ci;
mod corpus;
mod failing;
mod passing;
mod stopped;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use rts_host::cgroup::{Cgroups, Choice};
use rts_tests::{Stack, processes_of};
use serde_json::Value;

const HELLO: &str = "manifests/hello/system.xml";
const MISBEHAVING: &str = "manifests/misbehaving/misbehaving.rtsys.xml";

/// A smoke test that ended.
#[derive(Debug)]
struct Smoked {
    code: i32,
    out: String,
    err: String,
}

impl Smoked {
    /// Where its stack was.
    #[track_caller]
    fn home(&self) -> PathBuf {
        home(&self.err)
    }

    /// The document that `-o json` prints.
    #[track_caller]
    fn document(&self) -> Value {
        let read = serde_json::from_str(&self.out);
        read.unwrap_or_else(|e| panic!("{e}: {self:#?}"))
    }
}

/// The folder that its first message names.
#[track_caller]
fn home(text: &str) -> PathBuf {
    let named = text.split_once(" in /tmp/rts-smoke-");
    let named = named.and_then(|(_, rest)| rest.split_once(';'));
    let (id, _) = named.unwrap_or_else(|| panic!("no folder in {text}"));
    Path::new("/tmp").join(format!("rts-smoke-{id}"))
}

/// The command in the folder of the workspace. Its `RTSCTL_HOME` is one that must stay as it is: not there.
fn command(stack: &Stack, arguments: &[&str]) -> Command {
    let mut command = stack.command(&[&["smoke"], arguments].concat());
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn start(stack: &Stack, arguments: &[&str]) -> Child {
    command(stack, arguments).spawn().expect("rtsctl starts")
}

#[track_caller]
fn ended(child: Child) -> Smoked {
    let output = child.wait_with_output().expect("rtsctl ends");
    Smoked {
        code: output.status.code().unwrap_or(-1),
        out: String::from_utf8_lossy(&output.stdout).into_owned(),
        err: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

/// Runs it to its end, which must be with this code, and looks for what it has left.
#[track_caller]
fn smoke(stack: &Stack, code: i32, arguments: &[&str]) -> Smoked {
    let smoked = ended(start(stack, arguments));
    assert_eq!(smoked.code, code, "rtsctl smoke {arguments:?}: {smoked:#?}");
    leaves_nothing(&smoked.home());
    assert!(!stack.home().exists(), "the user's own home was used");
    smoked
}

/// Nothing is left of a stack.
#[track_caller]
fn leaves_nothing(home: &Path) {
    assert!(!home.exists(), "{} is still there", home.display());
    let left = processes_of(home);
    assert!(left.is_empty(), "processes are left: {left:?}");
    let groups = Cgroups::of(home, Choice::Auto).folders();
    assert!(groups.is_empty(), "control groups are left: {groups:?}");
}
