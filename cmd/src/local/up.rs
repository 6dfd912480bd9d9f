//! Starts the local controller and the agents of its nodes where they do not run yet.

pub(super) mod agents;

use std::ffi::OsString;
use std::fs::{File, OpenOptions};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use futures_util::future::{join, join_all};
use serde::Deserialize;
use tokio::io::{AsyncBufReadExt, AsyncReadExt, BufReader};
use tokio::process::Command;

use super::home::Home;
use super::lock::{HomeLock, is_held, make_folders};
use super::nodes::{NodeSetup, Nodes};
use super::relays;
use super::restore::stop_agent;
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

/// What is asked of the stack besides that it runs.
#[derive(Debug, Clone, Default)]
pub struct Wish {
    /// Folders with modules, for agents that are started; none for those of the variable.
    pub module_path: Option<OsString>,
    /// Nodes that the home is to have besides those that it has.
    pub nodes: Vec<NodeSetup>,
}

/// What [`ensure`] started.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Started {
    /// The controller.
    pub controller: bool,
    /// Agents, by node.
    pub agents: Vec<String>,
}

impl Started {
    /// True when all ran already.
    pub fn nothing(&self) -> bool {
        *self == Self::default()
    }

    fn words(&self) -> String {
        let agents = match self.agents.as_slice() {
            [] => None,
            [node] if node == LOCAL_NODE => Some("agent".to_owned()),
            [node] => Some(format!("agent (node {node})")),
            nodes => Some(format!("{} agents ({})", nodes.len(), nodes.join(", "))),
        };
        let article = |agents: String| match self.agents.len() {
            1 if agents == "agent" => "a local agent".to_owned(),
            1 => format!("an {agents}"),
            _ => agents,
        };
        match (self.controller, agents) {
            (true, None) => "a local controller".to_owned(),
            (true, Some(agents)) => format!("a local controller and {agents}"),
            (false, agents) => agents.map(article).unwrap_or_default(),
        }
    }
}

/// Makes sure that the local controller answers and that the nodes of the home are Ready. Says what it started.
pub async fn ensure(session: &Session, wish: Wish) -> Result<Started, CliError> {
    let home = &session.home;
    home.check_length(LOCAL_NODE)?;
    let lock = HomeLock::take(home)?;
    let before = Nodes::of(home)?;
    let nodes = Nodes::with(home, &wish.nodes)?;
    for node in nodes.all() {
        home.check_length(&node.name)?;
        make_folders(home, &node.name)?;
    }
    let mut started = Started {
        controller: !answers_or_dies(session).await?,
        agents: Vec::new(),
    };
    let agents = agents::to_start(home, &nodes, &before).await?;
    // Beside each other: an agent greets again until the controller is there.
    let module_path = module_path(wish.module_path);
    let begun = agents
        .iter()
        .map(|node| agents::start_agent(home, node, module_path.as_ref()));
    let controller = async {
        match started.controller {
            true => start_controller(home, nodes.first()).await,
            false => Ok(()),
        }
    };
    let (controller, begun) = join(controller, join_all(begun)).await;
    for (node, begun) in agents.iter().zip(&begun) {
        if begun.is_ok() {
            started.agents.push(node.name.clone());
        }
    }
    let failed = controller.and_then(|()| begun.into_iter().collect::<Result<(), _>>());
    if let Err(e) = failed {
        // Without a controller they would do what they were told last.
        for node in started.agents.iter().filter(|_| started.controller) {
            stop_agent(home, node)?;
        }
        return Err(e.into());
    }
    if !wish.nodes.is_empty() {
        nodes.save(home)?;
    }
    let wanted = wish.nodes.as_slice();
    let reached = relays::wake_all(session, &nodes, wanted, module_path.as_ref()).await?;
    if !started.nothing() || reached.woken {
        agents::wait_for(session, &reached.nodes, &started.agents, wanted).await?;
    }
    drop(lock);
    if !started.nothing() {
        let (what, home) = (started.words(), home.path().display());
        session
            .out
            .say(&format!("rtsctl: started {what} in {home}"));
    }
    Ok(started)
}

async fn start_controller(home: &Home, local_node: &str) -> Result<(), LocalError> {
    let mut command = Command::new(beside("rts-controller")?);
    command.arg("--home").arg(home.path());
    command.arg("--local-node").arg(local_node);
    start("rts-controller", command, &home.controller_log()).await
}

/// The folders with modules, as an agent can use them; none to leave it to the agent.
pub(super) fn module_path(said: Option<OsString>) -> Option<OsString> {
    let path = said.or_else(|| std::env::var_os("RTSCTL_MODULE_PATH"));
    let path = path.filter(|path| !path.is_empty());
    path.map(|path| absolute_entries(&path))
}

/// The daemon works in `/`: relative folders are those of the one who starts it.
fn absolute_entries(path: &OsString) -> OsString {
    let entries = std::env::split_paths(path)
        .filter(|entry| !entry.as_os_str().is_empty())
        .map(|entry| std::path::absolute(&entry).unwrap_or(entry));
    std::env::join_paths(entries).unwrap_or_else(|_| path.clone())
}

/// The program of this name in the folder of this one.
pub(super) fn beside(name: &str) -> Result<PathBuf, LocalError> {
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

pub(super) fn open_log(path: &Path) -> Result<File, LocalError> {
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
    // Asked before the home was locked: it may have been stopped since, but not while it holds its lock.
    if session.answered.swap(false, Ordering::Relaxed) && is_held(&home.controller_lock())? {
        return Ok(true);
    }
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

/// The error for a controller that lives but does not answer.
pub fn hangs(home: &Home) -> LocalError {
    LocalError::NotReady {
        program: "rts-controller",
        reason: "it runs but does not answer; `rtsctl down` stops it".to_owned(),
        log: home.controller_log(),
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
    fn what_was_started_is_said() {
        let words = |controller, agents: &[&str]| {
            let agents = agents.iter().map(|node| (*node).to_owned()).collect();
            Started { controller, agents }.words()
        };
        assert_eq!(words(true, &["local"]), "a local controller and agent");
        assert_eq!(words(true, &[]), "a local controller");
        assert_eq!(words(false, &["local"]), "a local agent");
        assert_eq!(words(false, &["arm"]), "an agent (node arm)");
        let both = ["arm", "base"];
        assert_eq!(
            words(true, &both),
            "a local controller and 2 agents (arm, base)"
        );
        assert_eq!(words(false, &both), "2 agents (arm, base)");
        assert_eq!(
            words(true, &["arm"]),
            "a local controller and agent (node arm)"
        );
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
            local: Default::default(),
            answered: Default::default(),
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
        assert!(!agents::lives(&home, LOCAL_NODE).await.unwrap());
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
        let (lives, _taken) = tokio::join!(agents::lives(&home, LOCAL_NODE), taken);
        assert!(lives.unwrap());
        agent.kill().await.unwrap();
    }
}
