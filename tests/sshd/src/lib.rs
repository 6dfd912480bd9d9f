//! A real SSH server on loopback, with keys and settings of its own: an ordinary process that ends with the test or benchmark
//! that started it. Nothing of the machine's own server, keys or known hosts is used.

mod processes;
mod settings;

use std::fs;
use std::io::{self, BufRead, BufReader, Error};
use std::net::TcpListener;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

pub use settings::Setup;

/// What the server is called in the client's settings.
pub const HOST: &str = "robot";
/// Where Debian has the server, which is on the path of root alone.
const USUAL: &str = "/usr/sbin/sshd";
/// Where OpenSSH as root wants an empty folder.
const PRIVILEGE_SEPARATION: &str = "/run/sshd";
/// Tries for a port that is still free when the server takes it.
const TRIES: u32 = 5;

/// The server's program, if this machine has one.
pub fn program() -> Option<PathBuf> {
    let on_path = std::env::var_os("PATH").and_then(|path| {
        let mut files = std::env::split_paths(&path).map(|folder| folder.join("sshd"));
        files.find(|file| file.is_file())
    });
    on_path.or_else(|| Some(PathBuf::from(USUAL)).filter(|file| file.is_file()))
}

/// A server for a test; none, and said so, on a machine that has none.
///
/// # Panics
/// When there is one that does not start.
pub fn for_test(setup: Setup) -> Option<Server> {
    if program().is_none() {
        eprintln!("SKIPPED: there is no sshd on this machine (Debian: openssh-server)");
        return None;
    }
    Some(Server::start(setup).unwrap_or_else(|e| panic!("sshd does not start: {e}")))
}

/// The server.
#[derive(Debug)]
pub struct Server {
    process: Option<Child>,
    folder: tempfile::TempDir,
    setup: Setup,
    port: u16,
}

impl Server {
    /// Starts it; it listens when this returns.
    pub fn start(setup: Setup) -> io::Result<Self> {
        let folder = tempfile::Builder::new().prefix("rtss").tempdir_in("/tmp")?;
        // The server reads the allowed keys as the account that logs in.
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o711))?;
        if rustix::process::geteuid().is_root() {
            fs::create_dir_all(PRIVILEGE_SEPARATION)?;
        }
        for key in ["host_key", "user_key", "stranger_key"] {
            make_key(&folder.path().join(key))?;
        }
        let allowed = if setup.stranger {
            "stranger_key.pub"
        } else {
            "user_key.pub"
        };
        let allowed_keys = folder.path().join("authorized_keys");
        fs::copy(folder.path().join(allowed), &allowed_keys)?;
        fs::set_permissions(&allowed_keys, fs::Permissions::from_mode(0o644))?;
        let mut server = Self {
            process: None,
            folder,
            setup,
            port: 0,
        };
        for _ in 0..TRIES {
            // A server says of no port of its own choice which it is: one that was free a moment ago is tried.
            server.port = TcpListener::bind("127.0.0.1:0")?.local_addr()?.port();
            if server.listen()? {
                server.know(&server.host_key()?)?;
                fs::write(server.config(), server.client_settings()?)?;
                return Ok(server);
            }
        }
        Err(Error::other("no port stays free for sshd"))
    }

    /// Settings of a client: `ssh -F CONFIG robot …`.
    pub fn config(&self) -> PathBuf {
        self.folder.path().join("config")
    }

    /// The port on 127.0.0.1.
    pub fn port(&self) -> u16 {
        self.port
    }

    /// The private key of who may log in.
    pub fn identity(&self) -> PathBuf {
        self.folder.path().join("user_key")
    }

    /// The file of known hosts that the client's settings name.
    pub fn known_hosts(&self) -> PathBuf {
        self.folder.path().join("known_hosts")
    }

    /// A folder of this server that the sessions' account may enter.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// The server's public host key, as `ssh-keygen` wrote it.
    pub fn host_key(&self) -> io::Result<String> {
        fs::read_to_string(self.folder.path().join("host_key.pub"))
    }

    /// Lets the client know this key, and no other, for the server.
    pub fn know(&self, key: &str) -> io::Result<()> {
        let line = format!("[127.0.0.1]:{} {}\n", self.port, key.trim_end());
        fs::write(self.known_hosts(), line)
    }

    /// Lets the client know no key at all.
    pub fn know_nothing(&self) -> io::Result<()> {
        fs::write(self.known_hosts(), "")
    }

    /// Ends the listener and every session at once (SIGKILL), as when the machine loses power.
    pub fn kill(&mut self) {
        self.kill_sessions();
        if let Some(mut process) = self.process.take() {
            let _ = process.kill();
            let _ = process.wait();
        }
        self.kill_sessions();
    }

    /// Ends every session at once (SIGKILL); the server listens on.
    pub fn kill_sessions(&self) {
        for pid in self.sessions() {
            processes::kill(pid);
        }
    }

    /// The server's processes of sessions.
    pub fn sessions(&self) -> Vec<u32> {
        let listener = self.process.as_ref().map(Child::id);
        let settings = self.folder.path().join("sshd_config");
        processes::sessions(listener, &settings)
    }

    /// Starts the server again at the same port, after [`Server::kill`].
    pub fn restart(&mut self) -> io::Result<()> {
        self.kill();
        match self.listen()? {
            true => Ok(()),
            false => Err(Error::other(format!("port {} was taken", self.port))),
        }
    }

    /// The same server at the same port shows another host key from now on.
    pub fn change_host_key(&mut self) -> io::Result<()> {
        for name in ["host_key", "host_key.pub"] {
            fs::remove_file(self.folder.path().join(name))?;
        }
        make_key(&self.folder.path().join("host_key"))?;
        self.restart()
    }

    /// Starts the process; false when the port is taken.
    fn listen(&mut self) -> io::Result<bool> {
        let program = program().ok_or_else(|| Error::other(format!("there is no {USUAL}")))?;
        let settings = self.folder.path().join("sshd_config");
        fs::write(&settings, self.server_settings())?;
        let mut process = self
            .setup
            .command(&program)
            .args(["-D", "-e", "-f"])
            .arg(&settings)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()?;
        let log = process.stderr.take();
        let mut log = BufReader::new(log.ok_or_else(|| Error::other("sshd has no log"))?);
        let mut said = String::new();
        while log.read_line(&mut said)? > 0 {
            let last = said.lines().last();
            if last.is_some_and(|line| line.starts_with("Server listening")) {
                // What more it says is of no use, but must not fill its pipe.
                std::thread::spawn(move || io::copy(&mut log, &mut io::sink()));
                self.process = Some(process);
                return Ok(true);
            }
        }
        process.wait()?;
        match said.contains("Address already in use") {
            true => Ok(false),
            false => Err(Error::other(said.trim_end().to_owned())),
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.kill();
    }
}

fn make_key(path: &Path) -> io::Result<()> {
    let status = Command::new("ssh-keygen")
        .args(["-q", "-t", "ed25519", "-N", "", "-f"])
        .arg(path)
        .stdin(Stdio::null())
        .status()?;
    match status.success() {
        true => Ok(()),
        false => Err(Error::other(format!("ssh-keygen ended with {status}"))),
    }
}
