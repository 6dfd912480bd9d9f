//! A real SSH server on loopback, with keys and settings of its own: an ordinary process that ends with the benchmark.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::{project, tools};

/// What the server is called in the client's settings.
pub const HOST: &str = "robot";
/// Where OpenSSH as root wants an empty folder.
const PRIVILEGE_SEPARATION: &str = "/run/sshd";
/// Tries for a port that is still free when the server takes it.
const TRIES: u32 = 5;

/// The server.
pub struct Server {
    process: Child,
    folder: tempfile::TempDir,
}

impl Server {
    /// Starts it; it listens when this returns.
    pub fn start() -> Result<Self> {
        let program = tools::sshd()?;
        let folder = tempfile::Builder::new().prefix("rtss").tempdir_in("/tmp")?;
        if rustix::process::geteuid().is_root() {
            fs::create_dir_all(PRIVILEGE_SEPARATION)
                .with_context(|| format!("cannot make {PRIVILEGE_SEPARATION}"))?;
        }
        for key in ["host_key", "user_key"] {
            project::run(
                project::command("ssh-keygen")
                    .args(["-q", "-t", "ed25519", "-N", "", "-f"])
                    .arg(folder.path().join(key)),
            )?;
        }
        fs::copy(
            folder.path().join("user_key.pub"),
            folder.path().join("authorized_keys"),
        )?;
        for _ in 0..TRIES {
            // A server says of no port of its own choice which it is: one that was free a moment ago is tried.
            let port = TcpListener::bind("127.0.0.1:0")?.local_addr()?.port();
            if let Some(process) = listen(&program, folder.path(), port)? {
                let server = Self { process, folder };
                server.write_client_settings(port)?;
                return Ok(server);
            }
        }
        bail!("no port stays free for {}", program.display())
    }

    /// Settings of a client: `ssh -F CONFIG robot …`.
    pub fn config(&self) -> PathBuf {
        self.folder.path().join("config")
    }

    fn write_client_settings(&self, port: u16) -> Result<()> {
        let folder = self.folder.path();
        let key = fs::read_to_string(folder.join("host_key.pub"))?;
        fs::write(
            folder.join("known_hosts"),
            format!("[127.0.0.1]:{port} {key}"),
        )?;
        let (user, folder) = (user()?, folder.display());
        fs::write(
            self.config(),
            format!(
                "Host {HOST}\nHostName 127.0.0.1\nPort {port}\nUser {user}\nIdentityFile {folder}/user_key\nIdentitiesOnly yes\n\
                 UserKnownHostsFile {folder}/known_hosts\nStrictHostKeyChecking yes\nBatchMode yes\n"
            ),
        )?;
        Ok(())
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Starts the server on a port; none when the port is taken.
fn listen(program: &Path, folder: &Path, port: u16) -> Result<Option<Child>> {
    let settings = folder.join("sshd_config");
    // SHLVL: a bash that believes to be the first one of a login reads the user's .bashrc for each command, which may take
    // longer than all the rest.
    let folder = folder.display();
    fs::write(
        &settings,
        format!(
            "ListenAddress 127.0.0.1\nPort {port}\nHostKey {folder}/host_key\nAuthorizedKeysFile {folder}/authorized_keys\n\
             PasswordAuthentication no\nKbdInteractiveAuthentication no\nUsePAM no\nStrictModes no\nPidFile none\n\
             MaxStartups 100\nSetEnv SHLVL=1\n"
        ),
    )?;
    let mut process = Command::new(program)
        .args(["-D", "-e", "-f"])
        .arg(&settings)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .with_context(|| format!("cannot start {}", program.display()))?;
    let log = process.stderr.take().context("no log")?;
    let mut log = BufReader::new(log);
    let mut said = String::new();
    while log.read_line(&mut said)? > 0 {
        if said
            .lines()
            .last()
            .is_some_and(|l| l.starts_with("Server listening"))
        {
            // What more it says is of no use, but must not fill its pipe.
            std::thread::spawn(move || std::io::copy(&mut log, &mut std::io::sink()));
            return Ok(Some(process));
        }
    }
    process.wait()?;
    match said.contains("Address already in use") {
        true => Ok(None),
        false => bail!("{} does not start: {}", program.display(), said.trim_end()),
    }
}

/// The name of whoever runs this: as nobody else can be logged in without being root.
fn user() -> Result<String> {
    let mut name = String::new();
    let mut id = Command::new("id")
        .arg("-un")
        .stdout(Stdio::piped())
        .spawn()?;
    id.stdout
        .take()
        .context("no output")?
        .read_to_string(&mut name)?;
    id.wait()?;
    Ok(name.trim_end().to_owned())
}
