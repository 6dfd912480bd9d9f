//! One node is reached, and held awake: its relay is started if need be, and started again should it be killed.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

use rts_host::files;
use rts_host::identity::Identity;
use rts_relay::State;
use serde::Deserialize;
use tokio::io::{AsyncBufReadExt, AsyncReadExt, BufReader};
use tokio::net::UnixStream;
use tokio::process::Command;

use super::standing::{Standing, note};
use crate::exit::Exit;
use crate::local::LocalError;
use crate::local::home::{Home, make_private};
use crate::local::lock::make_folders;
use crate::local::nodes::NodeSetup;
use crate::local::up::open_log;
use crate::output::Output;

/// Longest wait for a relay: it logs in, and the first time copies programs.
const READY: Duration = Duration::from_secs(300);
/// Longest wait for the first word of a relay that runs: it says at once how its session is.
const ANSWER: Duration = Duration::from_secs(5);
/// Time for a lost session to come back before it is told that it is waited for.
const SOON: Duration = Duration::from_secs(1);
/// Relays that may be killed as they start, before it is given up.
const STARTS: u32 = 3;
/// Relays that may end in a row soon after the node was reached, before no other one is started.
const DEATHS: u32 = 6;
/// Pause before the third relay in a row; each is twice the one before.
const FIRST_PAUSE: Duration = Duration::from_millis(200);
/// Longest of these pauses.
const LONGEST_PAUSE: Duration = Duration::from_secs(5);
/// A relay that has lived for so long was well.
const STEADY: Duration = Duration::from_secs(30);
/// Longest line of a relay in bytes.
const MAX_LINE: u64 = 64 * 1024;
/// Time between two looks.
const PAUSE: Duration = Duration::from_millis(20);

/// Whom to reach, and for whom.
#[derive(Clone)]
pub(super) struct Waker {
    /// The home of the stack.
    pub home: Home,
    /// Where it is told what happens to the session.
    pub out: Output,
    /// The node.
    pub node: NodeSetup,
    /// The relay's program.
    pub program: PathBuf,
    /// Folders with modules, for a relay that is started.
    pub module_path: Option<OsString>,
    /// Longest wait for a session that is being opened again.
    pub patience: Duration,
}

/// A node that is reached.
pub(super) struct Woken {
    /// Its relay had to be started.
    pub started: bool,
    /// An agent lives there on its own.
    pub resident: bool,
}

/// A relay that this process is connected to.
struct Attached {
    /// It had to be started.
    started: bool,
    /// How its session is: there, or not made again in time.
    standing: Standing,
    /// What it says next.
    states: States,
}

impl Waker {
    /// Reaches the node and holds its relay awake until this process ends, also if its session is not made again in time, which is
    /// an error.
    pub async fn wake(self) -> Result<Woken, LocalError> {
        let Attached {
            started,
            standing,
            states,
        } = self.attach().await?;
        let outcome = match &standing {
            Standing::Up { resident } => Ok(Woken {
                started,
                resident: *resident,
            }),
            Standing::Lost { reason, .. } | Standing::GivenUp { reason, .. } => {
                Err(self.late(reason))
            }
        };
        note(&self.node.name, standing);
        tokio::spawn(self.hold(states));
        outcome
    }

    /// Connects to the relay, which is started if need be. A session that was lost is waited for a while.
    async fn attach(&self) -> Result<Attached, LocalError> {
        let (home, name) = (&self.home, &self.node.name);
        let socket = home.relay_socket(name);
        let (mut started, mut starts) = (false, 0);
        let mut end = Instant::now() + self.patience;
        loop {
            if let Some((standing, states)) = self.connect(&socket).await? {
                return Ok(Attached {
                    started,
                    standing,
                    states,
                });
            }
            // One process at a time starts it.
            make_folders(home, name)?;
            let run = home.node_run(name);
            make_private(&run)?;
            let lock = run.join("relay.start");
            match files::lock(&lock).map_err(LocalError::file("lock", &lock))? {
                Some(_lock) if !socket.exists() || !answers(&socket).await => {
                    if starts == STARTS {
                        let reason = format!("its relay ended {STARTS} times as it started");
                        return Err(self.failed(reason));
                    }
                    tokio::time::sleep(pause(starts)).await;
                    starts += 1;
                    self.start().await?;
                    (started, end) = (true, Instant::now() + self.patience);
                }
                _ if Instant::now() >= end => {
                    let seconds = self.patience.as_secs();
                    let reason = format!("its relay has been starting for {seconds} s");
                    return Err(self.failed(reason));
                }
                _ => tokio::time::sleep(PAUSE).await,
            }
        }
    }

    /// Connects to a relay that runs, and waits a while until it reaches the node. None when no relay runs.
    async fn connect(&self, socket: &Path) -> Result<Option<(Standing, States)>, LocalError> {
        let Ok(stream) = UnixStream::connect(socket).await else {
            return Ok(None);
        };
        let mut states = States::of(stream);
        let Ok(mut state) = tokio::time::timeout(ANSWER, states.next()).await else {
            return Err(self.hangs());
        };
        let end = tokio::time::Instant::now() + self.patience;
        let mut told = false;
        loop {
            match state {
                Some(State::Up { resident }) => {
                    return Ok(Some((Standing::Up { resident }, states)));
                }
                Some(State::Lost { reason }) => {
                    // It may be back in a moment.
                    let next = tokio::time::timeout(SOON, states.next()).await;
                    if let Ok(next) = next {
                        state = next;
                        continue;
                    }
                    if !told {
                        told = true;
                        self.out.say(&format!(
                            "rtsctl: node {} is being reached again ({reason})",
                            self.node.name
                        ));
                    }
                    match tokio::time::timeout_at(end, states.next()).await {
                        Ok(next) => state = next,
                        Err(_) => {
                            let log = self.log();
                            return Ok(Some((Standing::Lost { reason, log }, states)));
                        }
                    }
                }
                Some(State::Failed { reason, help, exit }) => {
                    return Err(LocalError::Relay {
                        node: self.node.name.clone(),
                        reason,
                        help,
                        exit: Exit::of_code(exit),
                        log: self.log(),
                    });
                }
                // It was just ending.
                None => return Ok(None),
            }
        }
    }

    /// Tells what happens to the session, for as long as the node can be reached.
    async fn hold(self, mut states: States) {
        let name = &self.node.name;
        let mut lives = Lives::default();
        loop {
            match states.next().await {
                Some(State::Up { resident }) => self.is_back(resident),
                Some(State::Lost { reason }) => {
                    self.is_lost(&reason);
                }
                Some(State::Failed { reason, help, exit }) => {
                    let exit = Exit::of_code(exit);
                    return self.give_up(reason, help, exit);
                }
                // It was killed: one that ends in order says why.
                None => {
                    self.is_lost("its relay on this machine has ended");
                    let Some(pause) = lives.ended() else {
                        let reason = "its relay on this machine ends again and again";
                        return self.give_up(reason.to_owned(), None, Exit::Unreachable);
                    };
                    tokio::time::sleep(pause).await;
                    match self.attach().await {
                        Ok(attached) => {
                            states = attached.states;
                            lives.begun();
                            if let Standing::Up { resident } = attached.standing {
                                self.is_back(resident);
                            }
                        }
                        Err(e) => {
                            let reason = e.to_string();
                            let said =
                                reason.strip_prefix(&format!("node {name} is not reached: "));
                            let said = said.unwrap_or(&reason).to_owned();
                            return self.give_up(said, e.help(), e.exit());
                        }
                    }
                }
            }
        }
    }

    fn is_back(&self, resident: bool) {
        note(&self.node.name, Standing::Up { resident });
        let text = format!("rtsctl: node {} is reached again", self.node.name);
        self.out.say(&text);
    }

    fn is_lost(&self, reason: &str) {
        let (name, log) = (&self.node.name, self.log());
        let text = format!("the connection with node {name} was lost ({reason}); trying again");
        self.out.warn(&text);
        let reason = reason.to_owned();
        note(name, Standing::Lost { reason, log });
    }

    fn give_up(&self, reason: String, help: Option<String>, exit: Exit) {
        let (name, log) = (&self.node.name, self.log());
        self.out
            .warn(&format!("node {name} is not reached any more: {reason}"));
        let standing = Standing::GivenUp {
            reason,
            help,
            exit,
            log,
        };
        note(name, standing);
    }

    fn log(&self) -> PathBuf {
        self.home.agent_log(&self.node.name)
    }

    fn failed(&self, reason: String) -> LocalError {
        self.error(reason, None)
    }

    fn error(&self, reason: String, help: Option<String>) -> LocalError {
        LocalError::Relay {
            node: self.node.name.clone(),
            reason,
            help,
            exit: Exit::Unreachable,
            log: self.log(),
        }
    }

    fn late(&self, reason: &str) -> LocalError {
        self.failed(format!(
            "its session was lost and not made again within {} s: {reason}",
            self.patience.as_secs()
        ))
    }

    /// The error for a relay that runs and says nothing.
    fn hangs(&self) -> LocalError {
        let run = self.home.node_run(&self.node.name);
        let pid = Identity::read(&run.join("relay.json")).map(|identity| identity.pid);
        let who = pid
            .map(|pid| format!(" (process {pid})"))
            .unwrap_or_default();
        let reason = format!(
            "its relay{who} runs and says nothing within {} s",
            ANSWER.as_secs()
        );
        let help = pid.map(|pid| {
            format!("end it with `kill -9 {pid}`: the next command starts another one, and what runs over there goes on")
        });
        self.error(reason, help)
    }

    /// Starts a relay in a process group of its own, and waits until it has reached the node.
    async fn start(&self) -> Result<(), LocalError> {
        let (home, node) = (&self.home, &self.node);
        let Some(ssh) = &node.ssh else {
            return Err(self.failed("it is not reached by SSH".to_owned()));
        };
        let say = format!(
            "rtsctl: reaching node {} ({}) by SSH",
            node.name, ssh.destination
        );
        self.out.detail(&say);
        let program = self.program.clone();
        let mut command = Command::new(&program);
        command.arg("--home").arg(home.path());
        command.arg("--node").arg(&node.name);
        if let Some(path) = &self.module_path {
            command.env("RTSCTL_MODULE_PATH", path);
        }
        let log = home.agent_log(&node.name);
        let mut child = command
            .current_dir("/")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(open_log(&log)?)
            .process_group(0)
            .spawn()
            .map_err(|source| LocalError::Spawn { program, source })?;
        let mut line = String::new();
        if let Some(stdout) = child.stdout.take() {
            let mut reader = BufReader::new(stdout.take(MAX_LINE));
            if tokio::time::timeout(READY, reader.read_line(&mut line))
                .await
                .is_err()
            {
                let _ = child.start_kill();
                let reason = format!("it was not reached within {} s", READY.as_secs());
                return Err(self.failed(reason));
            }
        }
        match serde_json::from_str::<Readiness>(&line) {
            Ok(Readiness { ready: true, .. }) => Ok(()),
            Ok(said) => Err(LocalError::Relay {
                node: node.name.clone(),
                reason: said
                    .error
                    .unwrap_or_else(|| "its relay gave no reason".to_owned()),
                help: said.help,
                exit: said.exit.map_or(Exit::Unreachable, Exit::of_code),
                log,
            }),
            // It was killed before it could say anything: whoever waits finds out that none runs.
            Err(_) if line.is_empty() => Ok(()),
            Err(_) => Err(self.failed(format!("its relay said {line:?}"))),
        }
    }
}

/// How long a relay is left to itself that has ended so often in a row.
fn pause(deaths: u32) -> Duration {
    match deaths.checked_sub(1) {
        None => Duration::ZERO,
        Some(doublings) => (FIRST_PAUSE * 2_u32.pow(doublings.min(10))).min(LONGEST_PAUSE),
    }
}

/// The relays of a node that this process has seen, one after the other.
#[derive(Debug, Default)]
struct Lives {
    /// How many have ended in a row without having lived for a while.
    deaths: u32,
    /// Since when the last one is there, if it is not the first.
    since: Option<tokio::time::Instant>,
}

impl Lives {
    /// Another one is there.
    fn begun(&mut self) {
        self.since = Some(tokio::time::Instant::now());
    }

    /// It has ended: how long to wait before the next one; none when that is of no use.
    fn ended(&mut self) -> Option<Duration> {
        if self.since.is_none_or(|since| since.elapsed() >= STEADY) {
            self.deaths = 0;
        }
        let pause = pause(self.deaths);
        self.deaths += 1;
        (self.deaths <= DEATHS).then_some(pause)
    }
}

async fn answers(socket: &Path) -> bool {
    UnixStream::connect(socket).await.is_ok()
}

/// The lines of a relay.
struct States {
    from: BufReader<UnixStream>,
    /// What has come of the next one.
    line: Vec<u8>,
}

impl States {
    fn of(stream: UnixStream) -> Self {
        Self {
            from: BufReader::new(stream),
            line: Vec::new(),
        }
    }

    /// The next one; none when there are no more. Nothing is lost when this is given up.
    async fn next(&mut self) -> Option<State> {
        let mut bounded = (&mut self.from).take(MAX_LINE.saturating_sub(self.line.len() as u64));
        bounded.read_until(b'\n', &mut self.line).await.ok()?;
        let state = serde_json::from_slice(&self.line).ok();
        self.line.clear();
        state
    }
}

/// The one line that a relay prints.
#[derive(Deserialize)]
struct Readiness {
    ready: bool,
    #[serde(default)]
    error: Option<String>,
    #[serde(default)]
    help: Option<String>,
    #[serde(default)]
    exit: Option<u8>,
}

#[cfg(test)]
mod tests {
    use super::super::standing::{away, given_up};
    use super::*;
    use tokio::io::AsyncWriteExt;
    use tokio::net::UnixListener;

    fn waker(home: &Path) -> Waker {
        let globals = crate::cli::Globals {
            home: None,
            controller: None,
            color: crate::cli::Color::Never,
            verbose: 0,
            quiet: true,
        };
        Waker {
            home: Home::settle(Some(home.to_owned())).unwrap(),
            out: Output::new(&globals),
            node: NodeSetup::named("arm"),
            program: home.join("program"),
            module_path: None,
            patience: Duration::from_secs(8),
        }
    }

    #[tokio::test(start_paused = true)]
    async fn a_relay_that_hangs_is_named_and_one_that_reaches_again_is_waited_for() {
        let temp = tempfile::tempdir_in("/tmp").unwrap();
        let waker = waker(temp.path());
        let socket = temp.path().join("relay.sock");
        assert!(waker.connect(&socket).await.unwrap().is_none(), "none runs");
        let run = waker.home.node_run("arm");
        std::fs::create_dir_all(&run).unwrap();
        let own = serde_json::to_vec(&Identity::own("0")).unwrap();
        std::fs::write(run.join("relay.json"), own).unwrap();
        let relay = UnixListener::bind(&socket).unwrap();
        let hangs = waker.connect(&socket).await.err().unwrap();
        let pid = std::process::id();
        let told = format!("{hangs}; {}", hangs.help().unwrap());
        assert!(
            told.starts_with("node arm is not reached: its relay (process"),
            "{told}"
        );
        assert!(told.contains(&format!("kill -9 {pid}")), "{told}");

        let says = async |states: &[State]| {
            let mut said = Vec::new();
            for state in states {
                said.extend(serde_json::to_vec(state).unwrap());
                said.push(b'\n');
            }
            let (stream, _) = relay.accept().await.unwrap();
            let mut stream = stream;
            stream.write_all(&said).await.unwrap();
            stream
        };
        // The one that hung.
        drop(relay.accept().await);
        let lost = State::Lost {
            reason: "cut".to_owned(),
        };
        let up = State::Up { resident: true };
        let both = [lost.clone(), up];
        let (reached, stream) = tokio::join!(waker.connect(&socket), says(&both));
        assert_eq!(reached.unwrap().unwrap().0, Standing::Up { resident: true });
        drop(stream);

        // One that is not made again in time is held all the same: who needs it waits for it.
        std::fs::rename(&socket, waker.home.relay_socket("arm")).unwrap();
        let only = [lost];
        let (late, mut stream) = tokio::join!(waker.wake(), says(&only));
        let late = late.err().unwrap().to_string();
        assert!(late.ends_with("not made again within 8 s: cut"), "{late}");
        let arm = ["arm".to_owned()];
        assert!(away(&arm).is_some() && given_up(&arm).is_none());
        stream
            .write_all(b"{\"state\":\"up\",\"resident\":true}\n")
            .await
            .unwrap();
        while away(&arm).is_some() {
            tokio::time::sleep(PAUSE).await;
        }
    }

    #[test]
    fn a_relay_that_ends_again_and_again_is_started_ever_later_and_then_no_more() {
        let mut lives = Lives::default();
        let pauses: Vec<_> = std::iter::from_fn(|| {
            let pause = lives.ended()?;
            lives.begun();
            Some(pause.as_millis())
        })
        .collect();
        assert_eq!(pauses, [0, 200, 400, 800, 1600, 3200]);
        assert_eq!(pause(u32::MAX), LONGEST_PAUSE);
        lives.since = tokio::time::Instant::now().checked_sub(STEADY);
        assert_eq!(lives.ended(), Some(Duration::ZERO), "it was well for long");
    }

    #[tokio::test]
    async fn a_relay_that_is_killed_as_it_starts_is_started_again_but_not_for_ever() {
        use std::os::unix::fs::PermissionsExt;
        let temp = tempfile::tempdir_in("/tmp").unwrap();
        let mut waker = waker(temp.path());
        waker.node.ssh = Some(crate::local::nodes::SshNode {
            destination: "robot".parse().unwrap(),
            module_path: None,
            programs: None,
            keep_seconds: None,
        });
        rts_host::home::claim(temp.path()).unwrap();
        let play = |script: &str| {
            std::fs::write(
                &waker.program,
                format!(
                    "#!/bin/sh\ncd {}\necho >>starts\n{script}",
                    temp.path().display()
                ),
            )
            .unwrap();
            std::fs::set_permissions(&waker.program, std::fs::Permissions::from_mode(0o700))
                .unwrap();
        };
        let starts = || {
            std::fs::read_to_string(temp.path().join("starts"))
                .unwrap()
                .len()
        };
        play("kill -9 $$");
        let dead = waker.attach().await.err().unwrap();
        assert!(
            dead.to_string().ends_with("ended 3 times as it started"),
            "{dead}"
        );
        assert_eq!(starts(), 3);
        // The second one serves.
        let relay = UnixListener::bind(temp.path().join("bound")).unwrap();
        play(
            "[ $(wc -l <starts) -lt 5 ] && kill -9 $$\nmv bound run/arm/relay.sock\necho '{\"ready\":true}'",
        );
        let serve = async {
            let (mut stream, _) = relay.accept().await.unwrap();
            stream
                .write_all(b"{\"state\":\"up\",\"resident\":false}\n")
                .await
                .unwrap();
            stream
        };
        let (attached, _stream) = tokio::join!(waker.attach(), serve);
        let attached = attached.unwrap();
        assert_eq!((attached.started, starts()), (true, 5));
        assert_eq!(attached.standing, Standing::Up { resident: false });
    }
}
