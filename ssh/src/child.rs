//! A program that runs on the far side, with its three streams.

use std::time::Duration;

use openssh::{ChildStderr, ChildStdin, ChildStdout, Stdio};
use tokio::io::{AsyncBufReadExt, AsyncReadExt, BufReader};

use crate::answer::tame;
use crate::error::SshError;
use crate::remote::{command_line, ended, mark};
use crate::session::Session;

/// Longest wait until the program has been started, start-up files of the shell included.
const START: Duration = Duration::from_secs(30);
/// Most bytes that start-up files may print.
const MAX_PRELUDE: u64 = 1024 * 1024;
/// Most bytes of a complaint.
const MAX_COMPLAINT: u64 = 64 * 1024;

/// A program must be there and be one; then it takes the place of the shell. One that a clean-up has just taken away, and that is named
/// by a lease, is put back in a moment.
const SCRIPT: &str = r#"
case "$1" in
*/*)
  if [ ! -e "$1" ]; then sleep 1; fi;
  if [ ! -e "$1" ]; then echo missing; exit 127; fi;
  if [ ! -x "$1" ]; then echo not-permitted; exit 126; fi;;
*)
  if command -v "$1" >/dev/null 2>&1; then :; else echo missing; exit 127; fi;;
esac;
echo started;
exec "$@"
"#;

/// A program on the far side. Dropping it closes its streams; it is for the program to end then.
#[derive(Debug)]
pub struct Child {
    /// Its standard input; dropping it closes it.
    pub stdin: Option<ChildStdin>,
    /// Its standard output, from its first byte on.
    pub stdout: BufReader<ChildStdout>,
    /// Its standard error. What the start-up files of the shell said on theirs comes first.
    pub stderr: Option<ChildStderr>,
    inner: openssh::Child<std::sync::Arc<openssh::Session>>,
    host: String,
}

impl Child {
    /// Starts it.
    pub(crate) async fn spawn(
        session: &Session,
        program: &str,
        arguments: &[&str],
    ) -> Result<Self, SshError> {
        let mut words = vec![program];
        words.extend(arguments);
        let mark = mark();
        let line = command_line(SCRIPT, &mark, &words);
        let start = async {
            let mut inner = session
                .mux()
                .arc_raw_command(line)
                .stdin(Stdio::piped())
                .stdout(Stdio::piped())
                .stderr(Stdio::piped())
                .spawn()
                .await
                .map_err(|e| session.broken(e))?;
            let (stdin, stderr) = (inner.stdin().take(), inner.stderr().take());
            let host = session.host().to_owned();
            let Some(stdout) = inner.stdout().take() else {
                return Err(session.lost_error());
            };
            let stdout = BufReader::new(stdout);
            let child = Self {
                stdin,
                stdout,
                stderr,
                inner,
                host,
            };
            child.started(session, program, &mark).await
        };
        let late = SshError::TimedOut {
            host: session.host().to_owned(),
            what: format!("{} does not start", tame(program)),
            seconds: START.as_secs(),
        };
        tokio::time::timeout(START, start)
            .await
            .unwrap_or(Err(late))
    }

    /// Reads up to the word that says what became of it.
    async fn started(
        mut self,
        session: &Session,
        program: &str,
        mark: &str,
    ) -> Result<Self, SshError> {
        let mut said = Vec::new();
        let mut prelude = (&mut self.stdout).take(MAX_PRELUDE);
        loop {
            let before = said.len();
            let read = prelude.read_until(b'\n', &mut said).await;
            if read.is_err() || said.len() == before {
                return Err(self.complaint(session, &said).await);
            }
            if said[before..]
                .strip_suffix(b"\n")
                .is_some_and(|line| line.ends_with(mark.as_bytes()))
            {
                break;
            }
            said.drain(..before);
        }
        let mut word = String::new();
        let read = (&mut self.stdout).take(64).read_line(&mut word).await;
        let (host, path) = (self.host.clone(), tame(program));
        match word.trim_end() {
            _ if read.is_err() => Err(self.complaint(session, b"").await),
            "started" => Ok(self),
            "missing" => Err(SshError::Missing { host, path }),
            "not-permitted" => {
                let said = "it is no program that may be started".to_owned();
                Err(SshError::NotPermitted { host, path, said })
            }
            _ => Err(self.complaint(session, word.as_bytes()).await),
        }
    }

    /// What was said instead of the mark.
    async fn complaint(mut self, session: &Session, out: &[u8]) -> SshError {
        let mut err = Vec::new();
        if let Some(stderr) = self.stderr.take() {
            let _ = stderr.take(MAX_COMPLAINT).read_to_end(&mut err).await;
        }
        if session.has_ended().await {
            return session.lost_error();
        }
        let said = [out, &err].concat();
        SshError::Answer {
            host: self.host,
            what: "a command for /bin/sh".to_owned(),
            said: tame(&String::from_utf8_lossy(&said)),
        }
    }

    /// Closes the standard input and waits for the end: the exit code, or none for a signal.
    pub async fn wait(mut self) -> Result<Option<i32>, SshError> {
        drop(self.stdin.take());
        ended(self.inner.wait().await).map_err(|e| SshError::Lost {
            host: self.host,
            said: tame(&e.to_string()),
        })
    }
}
