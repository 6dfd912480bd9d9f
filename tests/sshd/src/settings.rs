//! What a test may ask of the server, and the settings of server and client that follow.

use std::fmt::Write;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::{HOST, Server};

/// What is different from a server at which who runs this may log in.
#[derive(Debug, Clone, Default)]
pub struct Setup {
    /// Account of the sessions; else the one who runs this. As another one nobody can be logged in without being root.
    pub user: Option<String>,
    /// The client's key is not among those that may log in.
    pub stranger: bool,
    /// Variables of the sessions (`HOME`, `PATH`, …), whatever the account has.
    pub environment: Vec<(String, String)>,
    /// Shell commands that prepare a mount namespace of the server's own, as root (`mount -t tmpfs …`).
    pub namespace: Option<String>,
}

impl Setup {
    /// Sessions have their home in this folder.
    pub fn home(folder: &Path) -> Self {
        Self::default().with("HOME", &folder.display().to_string())
    }

    /// Sessions have this variable.
    pub fn with(mut self, name: &str, value: &str) -> Self {
        self.environment.retain(|(known, _)| known != name);
        self.environment.push((name.to_owned(), value.to_owned()));
        self
    }

    /// How the server's program is started.
    pub(super) fn command(&self, program: &Path) -> Command {
        let Some(prepare) = &self.namespace else {
            return Command::new(program);
        };
        let mut command = Command::new("unshare");
        let script = format!("set -e\n{prepare}\nexec \"$0\" \"$@\"");
        command.args(["-m", "--propagation", "private", "sh", "-c", &script]);
        command.arg(program);
        command
    }
}

impl Server {
    pub(super) fn server_settings(&self) -> String {
        let (folder, port) = (self.folder.path().display(), self.port);
        // SHLVL: a bash that believes to be the first one of a login reads the user's .bashrc for each command, which may
        // take longer than all the rest.
        let mut environment = "SHLVL=1".to_owned();
        for (name, value) in &self.setup.environment {
            let _ = write!(environment, " {name}={value}");
        }
        format!(
            "ListenAddress 127.0.0.1\nPort {port}\nHostKey {folder}/host_key\nAuthorizedKeysFile {folder}/authorized_keys\n\
             PasswordAuthentication no\nKbdInteractiveAuthentication no\nUsePAM no\nStrictModes no\nPidFile none\n\
             MaxStartups 100\nSetEnv {environment}\n"
        )
    }

    pub(super) fn client_settings(&self) -> io::Result<String> {
        let (folder, port) = (self.folder.path().display(), self.port);
        let user = match &self.setup.user {
            Some(user) => user.clone(),
            None => user()?,
        };
        Ok(format!(
            "Host {HOST}\nHostName 127.0.0.1\nPort {port}\nUser {user}\nIdentityFile {folder}/user_key\nIdentitiesOnly yes\n\
             IdentityAgent none\nUserKnownHostsFile {folder}/known_hosts\nGlobalKnownHostsFile none\n\
             StrictHostKeyChecking yes\nBatchMode yes\n"
        ))
    }

    /// Where the mount namespace of the server has a path, as seen from outside.
    pub fn inside(&self, path: &Path) -> PathBuf {
        let pid = self.process.as_ref().map_or(0, std::process::Child::id);
        let within = path.strip_prefix("/").unwrap_or(path);
        PathBuf::from(format!("/proc/{pid}/root")).join(within)
    }
}

/// The name of whoever runs this.
fn user() -> io::Result<String> {
    let output = Command::new("id").arg("-un").output()?;
    Ok(String::from_utf8_lossy(&output.stdout)
        .trim_end()
        .to_owned())
}
