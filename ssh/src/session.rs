//! One connection with one account of one machine.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use crate::answer::tame;
use crate::child::Child;
use crate::collected::Collected;
use crate::copies::{self, Claim};
use crate::destination::Destination;
use crate::error::SshError;
use crate::master::Master;
use crate::remote::{self, NotRun, Ran};
use crate::store::{self, LocalFile, Stored};
use crate::survey::{self, Survey};

/// Longest wait for the answer of a short script.
const SHORT: Duration = Duration::from_secs(30);
/// How long a process that may just be ending is given, before its connection is taken for a good one.
const ENDING: Duration = Duration::from_millis(200);

/// A connection. It ends when it is closed or dropped, and when the process that holds it ends in whatever way.
#[derive(Debug)]
pub struct Session {
    mux: Arc<openssh::Session>,
    master: Master,
    host: String,
}

impl Session {
    /// Logs in. `control_folder` is a folder of this user in which the connection's socket may lie. What sessions have left there that
    /// were killed is removed.
    pub async fn open(destination: &Destination, control_folder: &Path) -> Result<Self, SshError> {
        destination.check().map_err(SshError::Destination)?;
        let master = Master::start(destination, control_folder).await?;
        let socket = master.socket().to_owned().into_boxed_path();
        Ok(Self {
            mux: Arc::new(openssh::Session::resume_mux(socket, None)),
            master,
            host: destination.to_string(),
        })
    }

    /// What kind of machine it is.
    pub async fn survey(&self) -> Result<Survey, SshError> {
        survey::survey(self).await
    }

    /// Copies files below the folder `root` there, each to `<SHA-256>/<name>`; those that are there already are not sent.
    pub async fn store(&self, files: &[LocalFile], root: &str) -> Result<Stored, SshError> {
        store::store(self, files, root, "").await
    }

    /// The same for programs of a home there. The lease of this name keeps them from before they are copied on.
    pub async fn store_programs(
        &self,
        files: &[LocalFile],
        home: &str,
        lease: &str,
    ) -> Result<Stored, SshError> {
        let lease = copies::place(home, lease);
        store::store(self, files, &format!("{home}/programs"), &lease).await
    }

    /// Removes the copies of a home there that nothing keeps once the claim was made.
    pub async fn collect(&self, home: &str, claim: Claim<'_>) -> Result<Collected, SshError> {
        copies::collect(self, home, claim).await
    }

    /// What [`Session::store`] would do: of the files that are not there, `sent` is said. Nothing is touched.
    pub async fn lacking(&self, files: &[LocalFile], root: &str) -> Result<Stored, SshError> {
        Ok(store::look(self, files, root).await?.0)
    }

    /// Starts a program, whose streams belong to the caller.
    pub async fn spawn(&self, program: &str, arguments: &[&str]) -> Result<Child, SshError> {
        Child::spawn(self, program, arguments).await
    }

    /// Runs a short script of `/bin/sh` to its end; `$1`… are the arguments. Each of its lines must stand for itself when all are
    /// joined by blanks, and have no `!` or `\\`.
    pub async fn run(&self, what: &str, script: &str, arguments: &[&str]) -> Result<Ran, SshError> {
        self.run_with(what, script, arguments, b"").await
    }

    /// The same with something on its standard input.
    pub async fn run_with(
        &self,
        what: &str,
        script: &str,
        arguments: &[&str],
        input: &[u8],
    ) -> Result<Ran, SshError> {
        let ran = remote::run(&self.mux, script, arguments, input, SHORT).await;
        match ran {
            Ok(ran) => Ok(ran),
            Err(NotRun::Late) => Err(SshError::TimedOut {
                host: self.host.clone(),
                what: what.to_owned(),
                seconds: SHORT.as_secs(),
            }),
            Err(NotRun::NoShell(said)) if !self.has_ended().await => Err(SshError::Answer {
                host: self.host.clone(),
                what: what.to_owned(),
                said,
            }),
            Err(NotRun::NoShell(_)) => Err(self.lost_error()),
            Err(NotRun::Mux(e)) => {
                let _ = self.has_ended().await;
                Err(self.broken(e))
            }
        }
    }

    /// Returns when the connection is gone.
    pub async fn lost(&self) {
        self.master.ended().await;
    }

    /// Ends the connection in order.
    pub async fn close(self) {
        self.master.stop().await;
    }

    /// Whom it is with, as the user wrote it.
    pub fn host(&self) -> &str {
        &self.host
    }

    pub(crate) fn mux(&self) -> Arc<openssh::Session> {
        Arc::clone(&self.mux)
    }

    /// True when the connection is gone, which it may only just be about to be.
    pub(crate) async fn has_ended(&self) -> bool {
        self.master.has_ended() || tokio::time::timeout(ENDING, self.lost()).await.is_ok()
    }

    /// The error of a connection that is gone.
    pub(crate) fn lost_error(&self) -> SshError {
        SshError::Lost {
            host: self.host.clone(),
            said: self.master.last_words(),
        }
    }

    /// What an error of the multiplexer means.
    pub(crate) fn broken(&self, error: openssh::Error) -> SshError {
        use openssh::Error;
        let gone = matches!(
            error,
            Error::Disconnected | Error::RemoteProcessTerminated | Error::ChildIo(_)
        );
        if gone || self.master.has_ended() {
            return self.lost_error();
        }
        let mut said = error.to_string();
        let mut source = std::error::Error::source(&error);
        while let Some(cause) = source {
            said = format!("{said}: {cause}");
            source = cause.source();
        }
        SshError::Failed {
            host: self.host.clone(),
            what: "open one more channel".to_owned(),
            said: tame(&said),
        }
    }
}
