//! Why something over SSH failed, what kind of failure it is, and how to mend it.

use std::io;
use std::path::PathBuf;

/// Kinds of failures, for the exit code of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The other machine cannot be reached, or what is there does not work.
    Unreachable,
    /// Somebody is not trusted: the machine, the user, or the user with a file.
    Forbidden,
    /// Something was done, and the rest was not.
    Partly,
    /// What was asked for does not fit.
    Usage,
    /// Something else is there already.
    Conflict,
}

/// Why something over SSH failed. Texts of the other machine in it are bounded and cannot move a cursor.
#[derive(Debug, thiserror::Error)]
#[allow(
    missing_docs,
    reason = "the text of each variant says what its fields are"
)]
pub enum SshError {
    #[error("cannot start `ssh`")]
    NoProgram(#[source] io::Error),
    #[error("{0}")]
    Destination(String),
    #[error("cannot make a folder for the session in {}", path.display())]
    Folder { path: PathBuf, source: io::Error },
    #[error("the host key of {host} is not known{}", key.as_ref().map(|key| format!(": it shows {key}")).unwrap_or_default())]
    UnknownHostKey { host: String, key: Option<String> },
    #[error(
        "the host key of {host} has changed{}{}",
        key.as_ref().map(|key| format!(": it shows {key}")).unwrap_or_default(),
        known.as_ref().map(|known| format!(", another one is known in {known}")).unwrap_or_default()
    )]
    ChangedHostKey {
        host: String,
        key: Option<String>,
        known: Option<String>,
    },
    #[error("{host} let nobody in{}: {said}", target.as_ref().map(|target| format!(" ({target})")).unwrap_or_default())]
    Refused {
        host: String,
        target: Option<String>,
        offered: Vec<String>,
        methods: Option<String>,
        said: String,
    },
    #[error(
        "{host} let us in and ran something else than what it was sent{}{}",
        place.as_ref().map(|place| format!(", as {place} forces it to")).unwrap_or_default(),
        if said.is_empty() { String::new() } else { format!(": {said}") }
    )]
    Forced {
        host: String,
        place: Option<String>,
        said: String,
    },
    #[error("{host} cannot be reached: {said}")]
    Unreachable { host: String, said: String },
    #[error("{host} did not answer within {seconds} s: {what}")]
    TimedOut {
        host: String,
        what: String,
        seconds: u64,
    },
    #[error("the account on {host} has no permission for {path}: {said}")]
    NotPermitted {
        host: String,
        path: String,
        said: String,
    },
    #[error("there is no {path} on {host}")]
    Missing { host: String, path: String },
    #[error(
        "the disk of {host} is full: {path} needs {needed} bytes{}",
        free.map(|free| format!(", and {free} are free")).unwrap_or_default()
    )]
    Full {
        host: String,
        path: String,
        needed: u64,
        free: Option<u64>,
    },
    #[error("{} is made for {here}, and {host} is {there}", file.display())]
    WrongMachine {
        host: String,
        file: PathBuf,
        here: String,
        there: String,
    },
    #[error("the connection to {host} was lost{}", if said.is_empty() { String::new() } else { format!(": {said}") })]
    Lost { host: String, said: String },
    #[error("cannot read {}", path.display())]
    Read { path: PathBuf, source: io::Error },
    #[error("{} changed while it was copied", path.display())]
    Changed { path: PathBuf },
    #[error("{path} did not arrive on {host} as it was sent: {said}")]
    Damaged {
        host: String,
        path: String,
        said: String,
    },
    #[error("the answer of {host} to {what} cannot be understood: {said}")]
    Answer {
        host: String,
        what: String,
        said: String,
    },
    #[error("{host} cannot {what}: {said}")]
    Failed {
        host: String,
        what: String,
        said: String,
    },
}

impl SshError {
    /// What kind of failure it is.
    pub fn kind(&self) -> Kind {
        match self {
            SshError::UnknownHostKey { .. }
            | SshError::ChangedHostKey { .. }
            | SshError::Refused { .. }
            | SshError::Forced { .. }
            | SshError::NotPermitted { .. } => Kind::Forbidden,
            SshError::Full { .. } | SshError::Damaged { .. } | SshError::Changed { .. } => {
                Kind::Partly
            }
            SshError::Destination(_)
            | SshError::Folder { .. }
            | SshError::WrongMachine { .. }
            | SshError::Read { .. } => Kind::Usage,
            SshError::NoProgram(_)
            | SshError::Unreachable { .. }
            | SshError::TimedOut { .. }
            | SshError::Missing { .. }
            | SshError::Lost { .. }
            | SshError::Answer { .. }
            | SshError::Failed { .. } => Kind::Unreachable,
        }
    }

    /// Trying again may help without that anybody mends something.
    pub fn is_passing(&self) -> bool {
        matches!(
            self,
            SshError::Unreachable { .. } | SshError::TimedOut { .. } | SshError::Lost { .. }
        )
    }

    /// The connection was there, or just coming about, and was cut: it may well come about at once.
    pub fn was_cut(&self) -> bool {
        match self {
            SshError::Lost { .. } => true,
            SshError::Unreachable { said, .. } => ["closed by", "Connection reset", "Broken pipe"]
                .iter()
                .any(|words| said.contains(words)),
            _ => false,
        }
    }

    /// How to mend it.
    pub fn help(&self) -> Option<String> {
        let text = match self {
            SshError::NoProgram(_) => "install the OpenSSH client (Debian: openssh-client)".to_owned(),
            SshError::UnknownHostKey { .. } => {
                "compare the key with `ssh-keygen -lf /etc/ssh/ssh_host_ed25519_key.pub` on that machine; then say --accept-new, or \
                 log in once with `ssh`"
                    .to_owned()
            }
            SshError::ChangedHostKey { known, .. } => {
                let file = known.as_ref().and_then(|known| Some(known.rsplit_once(':')?.0));
                let file = file.map(|file| format!(" -f {file}")).unwrap_or_default();
                format!(
                    "somebody may be between you and the machine. If it was installed anew, remove the old key with \
                     `ssh-keygen{file} -R HOST` and compare the new one there; --accept-new does not help here"
                )
            }
            SshError::Refused { offered, methods, .. } => refused(offered, methods.as_deref()),
            SshError::Forced { place, .. } => {
                let what = match place {
                    Some(_) => "the key has a forced command (`command=`)".to_owned(),
                    None => "the server's settings force a command (`ForceCommand`), or the account's shell is none".to_owned(),
                };
                format!("{what}, so that nothing else can be run: let in a key without one, or log in as another account")
            }
            SshError::Unreachable { .. } => {
                "is the machine on, and does an SSH server listen there? try `ssh` by hand".to_owned()
            }
            SshError::NotPermitted { path, .. } => {
                format!("let the account read, write and start programs in {path}, or log in as another one")
            }
            SshError::Full { path, .. } => format!(
                "free space below {path} on that machine and run the same again: what has arrived is not sent again"
            ),
            SshError::WrongMachine { there, .. } => format!(
                "build the programs for {there} and name their folder with --programs DIR"
            ),
            SshError::Lost { .. } => "run the same again: what is done is not done again".to_owned(),
            SshError::Damaged { .. } | SshError::Changed { .. } => "run the same again".to_owned(),
            _ => return None,
        };
        Some(text)
    }
}

fn refused(offered: &[String], methods: Option<&str>) -> String {
    let offered = match offered {
        [] => "no key was offered".to_owned(),
        keys => format!("offered was {}", keys.join(", ")),
    };
    let methods = methods.map(|methods| format!("; the machine takes {methods}"));
    format!(
        "{offered}{}. Nobody is asked for a password: let a key in with `ssh-copy-id`, add it to your agent with `ssh-add`, or name it \
         with --identity FILE",
        methods.unwrap_or_default()
    )
}
