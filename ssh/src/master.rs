//! The `ssh` process that holds the one connection. It runs a command of its own there, which ends when this process does: so
//! a connection never outlives who opened it, however that ends.

use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};
use tokio::io::{AsyncBufReadExt, AsyncRead, AsyncReadExt, BufReader};
use tokio::process::{Child, ChildStdin, Command};
use tokio::sync::{oneshot, watch};

use crate::answer::after_mark;
use crate::control::Folder;
use crate::destination::{Destination, plain};
use crate::diagnose::{instead, refusal};
use crate::error::SshError;
use crate::log::Log;
use crate::remote::{command_line, mark};

/// Longest wait of `ssh` for the machine to answer at all, in seconds.
const CONNECT: u64 = 10;
/// Longest wait until a command runs there, start-up files of the shell included.
const OPEN: Duration = Duration::from_secs(30);
/// Seconds between two signs of life, and how many may stay out: a pulled cable is noticed within 9 s.
const ALIVE: (u32, u32) = (3, 3);
/// Longest wait for `ssh` to end by itself.
const GRACE: Duration = Duration::from_secs(2);
/// Longest line of `ssh` that is read in bytes.
const MAX_LINE: u64 = 16 * 1024;
/// Most bytes that the start-up files of a shell may print.
const MAX_PRELUDE: u64 = 1024 * 1024;

/// The process.
#[derive(Debug)]
pub(crate) struct Master {
    socket: PathBuf,
    log: Arc<Mutex<Log>>,
    ended: watch::Receiver<bool>,
    stop: Option<oneshot::Sender<()>>,
    watcher: tokio::task::JoinHandle<()>,
    _folder: Folder,
}

impl Master {
    /// Logs in; a command runs there when this returns.
    pub async fn start(destination: &Destination, folder: &Path) -> Result<Self, SshError> {
        let host = destination.to_string();
        let folder = Folder::make(folder)?;
        let socket = folder.socket();
        let mark = mark();
        let mut child = command(destination, &socket, &mark)
            .spawn()
            .map_err(SshError::NoProgram)?;
        let log = Arc::new(Mutex::new(Log::default()));
        let (stdin, stdout, stderr) =
            (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let read = tokio::spawn(read_log(stderr, Arc::clone(&log)));
        let ready = async {
            let mut stdout = stdout.ok_or_else(Vec::new)?;
            wait_for_mark(&mut stdout, &mark).await?;
            // Nothing more comes, but if it did it must not stop the process.
            tokio::spawn(async move { tokio::io::copy(&mut stdout, &mut tokio::io::sink()).await });
            Ok::<(), Vec<u8>>(())
        };
        let up = tokio::time::timeout(OPEN, ready).await;
        if !matches!(up, Ok(Ok(()))) {
            let _ = child.start_kill();
            let _ = tokio::time::timeout(GRACE, child.wait()).await;
            let _ = tokio::time::timeout(GRACE, read).await;
            let log = log.lock().unwrap_or_else(PoisonError::into_inner).clone();
            return Err(match up {
                Ok(said) => refusal(&host, &log, CONNECT, &said.err().unwrap_or_default()),
                Err(_) if log.forced.is_some() => instead(host, &log, b""),
                Err(_) => SshError::TimedOut {
                    host,
                    what: format!("no command runs there {}", log.text())
                        .trim_end()
                        .to_owned(),
                    seconds: OPEN.as_secs(),
                },
            });
        }
        let (ending, ended) = watch::channel(false);
        let (stop, stopped) = oneshot::channel();
        let watcher = tokio::spawn(watch_over(child, stdin, stopped, ending));
        Ok(Self {
            socket,
            log,
            ended,
            stop: Some(stop),
            watcher,
            _folder: folder,
        })
    }

    /// Where other commands find the connection.
    pub fn socket(&self) -> &Path {
        &self.socket
    }

    /// The process has ended, and with it the connection.
    pub fn has_ended(&self) -> bool {
        *self.ended.borrow()
    }

    /// Returns when the process has ended.
    pub async fn ended(&self) {
        // A watcher that is gone has no process any more.
        let _ = self.ended.clone().wait_for(|ended| *ended).await;
    }

    /// The last words of the process.
    pub fn last_words(&self) -> String {
        let log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
        log.last().to_owned()
    }

    /// Ends the connection.
    pub async fn stop(mut self) {
        if let Some(stop) = self.stop.take() {
            let _ = stop.send(());
        }
        self.ended().await;
    }
}

impl Drop for Master {
    fn drop(&mut self) {
        // With the task goes the process: it is killed when it is dropped.
        self.watcher.abort();
    }
}

/// `ssh` with nothing of the user's settings that would disturb, nor ask.
fn command(destination: &Destination, socket: &Path, mark: &str) -> Command {
    let mut command = Command::new("ssh");
    command.arg("-M").arg("-T").arg("-S").arg(plain(socket));
    let (interval, count) = ALIVE;
    for option in [
        "BatchMode=yes".to_owned(),
        format!("ConnectTimeout={CONNECT}"),
        format!("ServerAliveInterval={interval}"),
        format!("ServerAliveCountMax={count}"),
        "ControlPersist=no".to_owned(),
        "ClearAllForwardings=yes".to_owned(),
        "ForwardAgent=no".to_owned(),
        "ForwardX11=no".to_owned(),
        "PermitLocalCommand=no".to_owned(),
        "RemoteCommand=none".to_owned(),
        "ForkAfterAuthentication=no".to_owned(),
        "SessionType=default".to_owned(),
        "StdinNull=no".to_owned(),
        "EscapeChar=none".to_owned(),
        // The server's key, and which keys were offered, are told at this level.
        "LogLevel=DEBUG1".to_owned(),
    ] {
        command.arg("-o").arg(option);
    }
    command.args(destination.arguments());
    command.arg(command_line("cat >/dev/null", mark, &[]));
    // The words of errors are looked at.
    command.env("LC_ALL", "C").env_remove("SSH_ASKPASS");
    command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        // Ctrl-C at a terminal is for the program that waits, which then ends this one in order.
        .process_group(0)
        .kill_on_drop(true);
    command
}

/// Reads up to the mark; the error is what came instead of it.
async fn wait_for_mark(stdout: &mut (impl AsyncRead + Unpin), mark: &str) -> Result<(), Vec<u8>> {
    let mut said = Vec::new();
    let mut stdout = stdout.take(MAX_PRELUDE);
    loop {
        match stdout.read_buf(&mut said).await {
            Ok(0) | Err(_) => return Err(said),
            Ok(_) if after_mark(&said, mark).is_some() => return Ok(()),
            Ok(_) => {}
        }
    }
}

/// Reads to the end, so that the pipe never fills.
async fn read_log(stderr: Option<impl AsyncRead + Unpin>, log: Arc<Mutex<Log>>) {
    let Some(stderr) = stderr else { return };
    let mut stderr = BufReader::new(stderr);
    let mut line = Vec::new();
    loop {
        line.clear();
        match (&mut stderr)
            .take(MAX_LINE)
            .read_until(b'\n', &mut line)
            .await
        {
            Ok(0) | Err(_) => return,
            Ok(_) => {
                let text = String::from_utf8_lossy(&line);
                log.lock()
                    .unwrap_or_else(PoisonError::into_inner)
                    .add(&text);
            }
        }
    }
}

/// Waits for the end of the process, or ends it.
async fn watch_over(
    mut child: Child,
    stdin: Option<ChildStdin>,
    stopped: oneshot::Receiver<()>,
    ending: watch::Sender<bool>,
) {
    tokio::select! {
        _ = child.wait() => {}
        _ = stopped => {
            drop(stdin);
            // Not reaped yet, so the number is still this child's.
            let pid = child.id().and_then(|pid| Pid::from_raw(i32::try_from(pid).ok()?));
            if let Some(pid) = pid {
                let _ = kill_process(pid, Signal::TERM);
            }
            if tokio::time::timeout(GRACE, child.wait()).await.is_err() {
                let _ = child.kill().await;
            }
        }
    }
    let _ = ending.send(true);
}
