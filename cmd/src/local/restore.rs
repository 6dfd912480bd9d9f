//! What a restore does to the local stack: ends one program alone, and lets the controller's program write the store.

use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;

use rts_host::identity::Identity;
use rts_host::process::Process;
use rustix::process::Signal;
use serde::Deserialize;
use tokio::process::Command;

use super::LocalError;
use super::home::Home;
use super::lock::is_held;

/// Time for the controller to end by itself; it gives open requests 3 s.
const GRACE: Duration = Duration::from_secs(8);
/// Longest wait for a killed process to be gone.
const KILLED: Duration = Duration::from_secs(5);
/// Longest time that writing a store may take.
const PATIENCE: Duration = Duration::from_secs(60);

/// What is to be done with a backup.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Say what is in it.
    Check,
    /// Restore it; newer ledgers win.
    Restore,
    /// Restore it; it wins.
    TakeOver,
}

/// What the controller's program says of it.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Report {
    /// When the backup was made.
    pub created: jiff::Timestamp,
    /// Epoch of the backup, or of the restored store.
    pub epoch: u64,
    /// Its systems.
    pub systems: Vec<String>,
    /// Where the old store is.
    #[serde(default)]
    pub kept: Option<PathBuf>,
}

/// The program's one line.
#[derive(Deserialize)]
#[serde(untagged)]
enum Line {
    Done(Report),
    Failed { error: String },
}

/// Runs `rts-controller restore`. The inner error is its word.
pub async fn call(
    home: &Home,
    file: &Path,
    mode: Mode,
) -> Result<Result<Report, String>, LocalError> {
    let own = std::env::current_exe().map_err(LocalError::file("find", "/proc/self/exe"))?;
    let program = own.with_file_name("rts-controller");
    let mut command = Command::new(&program);
    command.arg("restore").arg("--home").arg(home.path());
    match mode {
        Mode::Check => drop(command.arg("--check")),
        Mode::Restore => {}
        Mode::TakeOver => drop(command.arg("--take-over")),
    }
    command.arg("--").arg(file);
    command.stdin(Stdio::null()).kill_on_drop(true);
    let output = match tokio::time::timeout(PATIENCE, command.output()).await {
        Ok(output) => output.map_err(|source| LocalError::Spawn { program, source })?,
        Err(_) => return Ok(Err(format!("it took longer than {} s", PATIENCE.as_secs()))),
    };
    Ok(said(&output.stdout, &output.stderr))
}

fn said(stdout: &[u8], stderr: &[u8]) -> Result<Report, String> {
    match serde_json::from_slice(stdout) {
        Ok(Line::Done(report)) => Ok(report),
        Ok(Line::Failed { error }) => Err(error),
        Err(_) => Err(String::from_utf8_lossy(stderr).trim().to_owned()),
    }
}

/// Ends the controller alone. False when none ran.
pub fn stop_controller(home: &Home) -> Result<bool, LocalError> {
    stop_one(
        "controller",
        &home.controller_json(),
        &home.controller_lock(),
    )
}

/// Ends the agent of a node alone; its managers go on. False when none ran.
pub fn stop_agent(home: &Home, node: &str) -> Result<bool, LocalError> {
    let what = format!("agent of node {node}");
    stop_one(&what, &home.agent_json(node), &home.agent_lock(node))
}

fn stop_one(what: &str, json: &Path, lock: &Path) -> Result<bool, LocalError> {
    let left = |what: String| LocalError::Left { left: vec![what] };
    let identity = Identity::read(json);
    let process = identity.and_then(|identity| Process::identified(&identity));
    let Some(process) = process else {
        return match is_held(lock)? {
            false => Ok(false),
            true => Err(left(format!(
                "the {what} holds {}, and nothing says which process it is",
                lock.display()
            ))),
        };
    };
    process.signal(Signal::TERM);
    if !process.ended(GRACE) {
        process.signal(Signal::KILL);
        if !process.ended(KILLED) {
            return Err(left(format!("the {what} (pid {})", process.pid())));
        }
    }
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_programs_line_is_read() {
        let line =
            br#"{"created":"2026-01-01T00:00:00Z","clusterUid":"c","epoch":2,"systems":["a"]}"#;
        let report = said(line, b"").unwrap();
        assert_eq!((report.epoch, report.kept), (2, None));
        assert_eq!(said(br#"{"error":"no disk"}"#, b"").unwrap_err(), "no disk");
        assert_eq!(said(b"", b"it broke\n").unwrap_err(), "it broke");
    }

    #[test]
    fn a_home_without_a_controller_has_none_to_stop() {
        let temp = tempfile::tempdir().unwrap();
        let home = Home::settle(Some(temp.path().to_owned())).unwrap();
        assert!(!stop_controller(&home).unwrap());
    }
}
