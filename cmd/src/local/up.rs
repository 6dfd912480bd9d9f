//! Starts the local controller and agent where they do not run yet.

use std::ffi::OsString;
use std::fs::{File, OpenOptions};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

use rts_controller_api::objects::{Kind, Node};
use serde::Deserialize;
use tokio::io::{AsyncBufReadExt, AsyncReadExt, BufReader};
use tokio::process::Command;

use super::home::Home;
use super::lock::{HomeLock, is_held, make_folders};
use super::strays::{self, Program};
use super::{LOCAL_NODE, LocalError};
use crate::error::CliError;
use crate::session::Session;

/// Longest wait for a daemon's line of readiness, and for one that is already starting.
const READY: Duration = Duration::from_secs(10);
/// Longest wait for the node to be Ready at the controller.
const NODE_READY: Duration = Duration::from_secs(10);
/// Longest line of readiness in bytes.
const MAX_LINE: u64 = 64 * 1024;
/// Time between two looks.
const PAUSE: Duration = Duration::from_millis(20);

/// What [`ensure`] found or did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Started {
    /// Both ran already.
    Nothing,
    /// The agent had died.
    Agent,
    /// The controller had died.
    Controller,
    /// Nothing ran.
    Both,
}

impl Started {
    fn of(controller: bool, agent: bool) -> Self {
        match (controller, agent) {
            (false, false) => Started::Nothing,
            (false, true) => Started::Agent,
            (true, false) => Started::Controller,
            (true, true) => Started::Both,
        }
    }

    fn words(self) -> &'static str {
        match self {
            Started::Nothing => "nothing",
            Started::Agent => "a local agent",
            Started::Controller => "a local controller",
            Started::Both => "a local controller and agent",
        }
    }
}

/// Makes sure that the local controller answers and that its node is Ready. Says what it started.
pub async fn ensure(session: &Session, module_path: Option<OsString>) -> Result<Started, CliError> {
    let home = &session.home;
    home.check_length()?;
    let lock = HomeLock::take(home)?;
    make_folders(home, LOCAL_NODE)?;
    let controller = !answers_or_dies(session).await?;
    if controller {
        start_controller(home).await?;
    }
    let agent = !agent_lives(home).await?;
    if agent {
        start_agent(home, module_path).await?;
    }
    if controller || agent {
        wait_for_node(session).await?;
    }
    drop(lock);
    let started = Started::of(controller, agent);
    if started != Started::Nothing {
        let (what, home) = (started.words(), home.path().display());
        session
            .out
            .say(&format!("rtsctl: started {what} in {home}"));
    }
    Ok(started)
}

async fn start_controller(home: &Home) -> Result<(), LocalError> {
    let mut command = Command::new(beside("rts-controller")?);
    command.arg("--home").arg(home.path());
    start("rts-controller", command, &home.controller_log()).await
}

async fn start_agent(home: &Home, module_path: Option<OsString>) -> Result<(), LocalError> {
    let mut command = Command::new(beside("rts-agent")?);
    command.arg("--home").arg(home.path());
    command.arg("--node").arg(LOCAL_NODE);
    command.arg("--controller").arg(home.controller_socket());
    // What a component starts can be told to be of this home, wherever it goes.
    command.env("RTSCTL_HOME", home.path());
    let module_path = module_path.or_else(|| std::env::var_os("RTSCTL_MODULE_PATH"));
    if let Some(path) = module_path.filter(|p| !p.is_empty()) {
        command.env("RTSCTL_MODULE_PATH", absolute_entries(&path));
    }
    start("rts-agent", command, &home.agent_log(LOCAL_NODE)).await
}

/// The daemon works in `/`: relative folders are those of the one who starts it.
fn absolute_entries(path: &OsString) -> OsString {
    let entries = std::env::split_paths(path)
        .filter(|entry| !entry.as_os_str().is_empty())
        .map(|entry| std::path::absolute(&entry).unwrap_or(entry));
    std::env::join_paths(entries).unwrap_or_else(|_| path.clone())
}

/// The program of this name in the folder of this one.
fn beside(name: &str) -> Result<PathBuf, LocalError> {
    let own = std::env::current_exe().map_err(LocalError::file("find", "/proc/self/exe"))?;
    Ok(own.with_file_name(name))
}

/// Starts a daemon in a process group of its own and waits for its line of readiness.
async fn start(name: &'static str, mut command: Command, log: &Path) -> Result<(), LocalError> {
    let program = PathBuf::from(command.as_std().get_program());
    let mut child = command
        .current_dir("/")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(open_log(log)?)
        .process_group(0)
        .spawn()
        .map_err(|source| LocalError::Spawn { program, source })?;
    let not_ready = |reason: String| LocalError::NotReady {
        program: name,
        reason,
        log: log.to_owned(),
    };
    let stdout = child
        .stdout
        .take()
        .ok_or_else(|| not_ready("it has no stdout".to_owned()))?;
    let mut line = String::new();
    let mut reader = BufReader::new(stdout.take(MAX_LINE));
    let outcome = match tokio::time::timeout(READY, reader.read_line(&mut line)).await {
        Ok(Ok(0)) => Err(match tokio::time::timeout(PAUSE * 10, child.wait()).await {
            Ok(Ok(status)) => format!("it ended with {status}"),
            _ => "it closed its stdout".to_owned(),
        }),
        Ok(Ok(_)) => readiness(&line),
        Ok(Err(e)) => Err(e.to_string()),
        Err(_) => Err(format!("it said nothing within {} s", READY.as_secs())),
    };
    if outcome.is_err() {
        // A daemon that is half up would hold its lock and serve nobody.
        let _ = child.start_kill();
        let _ = tokio::time::timeout(READY, child.wait()).await;
    }
    outcome.map_err(not_ready)
}

/// The one line that a daemon prints.
#[derive(Deserialize)]
struct Readiness {
    ready: bool,
    #[serde(default)]
    error: Option<String>,
}

fn readiness(line: &str) -> Result<(), String> {
    match serde_json::from_str::<Readiness>(line) {
        Ok(Readiness { ready: true, .. }) => Ok(()),
        Ok(Readiness { error, .. }) => Err(error.unwrap_or_else(|| "it gave no reason".to_owned())),
        Err(_) => Err(format!("it said {line:?} instead of whether it is ready")),
    }
}

fn open_log(path: &Path) -> Result<File, LocalError> {
    OpenOptions::new()
        .create(true)
        .append(true)
        .mode(0o600)
        .open(path)
        .map_err(LocalError::file("open the log", path))
}

/// True when the controller answers, which it may only be about to; false when none lives. One that has lost the files
/// of its run folder makes them anew within moments.
async fn answers_or_dies(session: &Session) -> Result<bool, CliError> {
    let home = &session.home;
    let end = Instant::now() + READY;
    loop {
        if session.local_answers().await? {
            return Ok(true);
        }
        let lock = home.controller_lock();
        if !is_held(&lock)? && strays::find(home, Program::Controller).is_empty() {
            return Ok(false);
        }
        if Instant::now() >= end {
            return Err(hangs(home).into());
        }
        tokio::time::sleep(PAUSE).await;
    }
}

/// True when the agent holds its lock, which it may only be about to; false when none lives.
async fn agent_lives(home: &Home) -> Result<bool, LocalError> {
    let lock = home.agent_lock(LOCAL_NODE);
    let end = Instant::now() + READY;
    while !is_held(&lock)? {
        let strays = strays::find(home, Program::Agent);
        if !strays.iter().any(|agent| agent.name == LOCAL_NODE) {
            return Ok(false);
        }
        if Instant::now() >= end {
            return Err(LocalError::NotReady {
                program: "rts-agent",
                reason: format!(
                    "it runs but does not hold {}; `rtsctl down` stops it",
                    lock.display()
                ),
                log: home.agent_log(LOCAL_NODE),
            });
        }
        tokio::time::sleep(PAUSE).await;
    }
    Ok(true)
}

/// The error for a controller that lives but does not answer.
pub fn hangs(home: &Home) -> LocalError {
    LocalError::NotReady {
        program: "rts-controller",
        reason: "it runs but does not answer; `rtsctl down` stops it".to_owned(),
        log: home.controller_log(),
    }
}

/// Waits until the controller has met the agent.
async fn wait_for_node(session: &Session) -> Result<(), CliError> {
    let controller = session.local(READY)?;
    let end = Instant::now() + NODE_READY;
    loop {
        let reason = match controller.list::<Node>(Kind::Node).await {
            Ok(list) => match list.items.iter().find(|n| n.metadata.name == LOCAL_NODE) {
                Some(node) if node.status.state == "Ready" => return Ok(()),
                Some(Node { status, .. }) if status.ledger.is_some() => {
                    // It is up, and waits for a word of the user.
                    let why = status.message.as_deref().unwrap_or(&status.state);
                    session.out.warn(why);
                    return Ok(());
                }
                Some(Node { status, .. }) => {
                    let why = status.message.as_deref().unwrap_or_default();
                    format!("node {LOCAL_NODE} is {} {why}", status.state)
                }
                None => format!("node {LOCAL_NODE} has not reported to the controller"),
            },
            Err(e) => e.to_string(),
        };
        if Instant::now() >= end {
            return Err(LocalError::NotReady {
                program: "rts-agent",
                reason,
                log: session.home.agent_log(LOCAL_NODE),
            }
            .into());
        }
        tokio::time::sleep(PAUSE).await;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_readiness_is_read() {
        assert_eq!(readiness("{\"ready\":true}\n"), Ok(()));
        let refused = readiness("{\"ready\":false,\"error\":\"no disk\"}\n");
        assert_eq!(refused, Err("no disk".to_owned()));
        assert!(readiness("hello\n").unwrap_err().contains("hello"));
    }

    #[tokio::test]
    async fn a_daemon_that_dies_is_reported_with_its_status_and_log() {
        let temp = tempfile::tempdir().unwrap();
        let log = temp.path().join("x.log");
        let mut command = Command::new("sh");
        command.args(["-c", "echo broken >&2; exit 3"]);
        let error = start("sh", command, &log).await.unwrap_err();
        assert!(error.to_string().contains("exit status: 3"), "{error}");
        assert_eq!(std::fs::read_to_string(&log).unwrap(), "broken\n");
        assert!(error.help().unwrap().ends_with("x.log"));
    }

    #[tokio::test]
    async fn a_program_that_is_not_there_is_named() {
        let temp = tempfile::tempdir().unwrap();
        let program = temp.path().join("rts-nothing");
        let log = temp.path().join("x.log");
        let error = start("rts-nothing", Command::new(&program), &log)
            .await
            .unwrap_err();
        assert!(error.to_string().contains("rts-nothing"), "{error}");
        assert_eq!(error.exit().code(), 4);
    }

    #[test]
    fn module_folders_are_made_absolute() {
        let cwd = std::env::current_dir().unwrap();
        let got = absolute_entries(&OsString::from("/a::b"));
        let want = format!("/a:{}", cwd.join("b").display());
        assert_eq!(got, OsString::from(want));
    }
    /// A session with a home where nothing runs.
    fn session(home: &Path) -> Session {
        let globals = crate::cli::Globals {
            home: Some(home.to_owned()),
            controller: None,
            color: crate::cli::Color::Never,
            verbose: 0,
            quiet: true,
        };
        Session {
            home: Home::settle(Some(home.to_owned())).unwrap(),
            controller: None,
            out: crate::output::Output::new(&globals),
        }
    }

    #[tokio::test]
    async fn a_controller_that_answers_lives_though_its_lock_was_removed() {
        use tokio::io::AsyncWriteExt;
        let temp = tempfile::tempdir().unwrap();
        let session = session(temp.path());
        make_folders(&session.home, LOCAL_NODE).unwrap();
        assert!(!answers_or_dies(&session).await.unwrap());
        let socket = session.home.controller_socket();
        let listener = tokio::net::UnixListener::bind(socket).unwrap();
        let server = tokio::spawn(async move {
            loop {
                let (mut stream, _) = listener.accept().await.unwrap();
                let mut request = [0; 4096];
                let _ = stream.read(&mut request).await;
                let answer = "HTTP/1.1 200 OK\r\ncontent-length: 2\r\nconnection: close\r\n\r\nok";
                let _ = stream.write_all(answer.as_bytes()).await;
            }
        });
        assert!(!session.home.controller_lock().exists());
        assert!(answers_or_dies(&session).await.unwrap());
        server.abort();
    }

    #[tokio::test]
    async fn an_agent_that_lives_without_its_lock_is_waited_for() {
        let temp = tempfile::tempdir().unwrap();
        let home = Home::settle(Some(temp.path().to_owned())).unwrap();
        make_folders(&home, LOCAL_NODE).unwrap();
        assert!(!agent_lives(&home).await.unwrap());
        // A shell plays the agent.
        let program = temp.path().join("rts-agent");
        std::fs::copy("/bin/bash", &program).unwrap();
        let mut agent = Command::new(&program)
            .args(["-c", "read", "x", "--node", LOCAL_NODE, "--home"])
            .arg(home.path())
            .stdin(Stdio::piped())
            .spawn()
            .unwrap();
        let lock = home.agent_lock(LOCAL_NODE);
        std::fs::create_dir_all(lock.parent().unwrap()).unwrap();
        let taken = async {
            tokio::time::sleep(PAUSE * 5).await;
            rts_host::files::lock(&lock).unwrap().unwrap()
        };
        let (lives, _taken) = tokio::join!(agent_lives(&home), taken);
        assert!(lives.unwrap());
        agent.kill().await.unwrap();
    }
}
