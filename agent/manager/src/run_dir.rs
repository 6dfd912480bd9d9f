//! The run folder: lock, control socket and `manager.json`.

use std::fs::{self, Permissions};
use std::io;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::os::unix::net::UnixListener;
use std::path::{Path, PathBuf};

use rts_host::files;
use rts_host::identity::{boot_id, start_ticks};
use rts_manager_api::PROTOCOL_VERSION;
use rts_manager_api::control::Hello;
use rts_manager_api::files::{CONTROL_SOCKET, LOCK, MANAGER_JSON, ManagerFile};

use crate::log;

/// Name of the socket before it is renamed into place. Not longer than its final name.
const NEW_SOCKET: &str = "control.new";

/// A run folder that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum RunDirError {
    /// Another manager lives there.
    #[error("{0} is held by another manager that still runs")]
    Held(PathBuf),
    /// The path leaves no room for a socket's.
    #[error(
        "the socket path {0} has {1} bytes, of which 107 are allowed; set RTSCTL_HOME to a shorter folder"
    )]
    TooLong(PathBuf, usize),
    /// Something about a file.
    #[error("cannot {action} {path}: {error}", path = path.display())]
    File {
        /// What was tried.
        action: &'static str,
        /// With what.
        path: PathBuf,
        /// Why not.
        error: io::Error,
    },
}

/// A run folder whose lock this process holds, with the socket in it.
pub struct RunDir {
    dir: PathBuf,
    description: Vec<u8>,
    listener: UnixListener,
    lock: files::Lock,
    marks: Marks,
    trouble: Option<String>,
}

/// What tells our files from others at their paths: device and number, and for the description also its last change.
struct Marks {
    lock: Option<(u64, u64)>,
    socket: Option<(u64, u64)>,
    description: Option<(u64, u64, i64, i64)>,
}

impl RunDir {
    /// Takes the folder: lock, socket, `manager.json`, in this order. Connections are possible from then on.
    /// `cgroup` is the name of a control group that is not the folder's.
    pub fn take(dir: &Path, hello: &Hello, cgroup: Option<String>) -> Result<Self, RunDirError> {
        let lock = lock(dir)?;
        let description = describe(hello, cgroup);
        let (listener, socket) = bind(dir)?;
        let mut run_dir = Self {
            marks: Marks {
                lock: number(&dir.join(LOCK)),
                socket: Some(socket),
                description: None,
            },
            dir: dir.to_owned(),
            description,
            listener,
            lock,
            trouble: None,
        };
        run_dir.write_description()?;
        Ok(run_dir)
    }

    /// The socket's listener; does not block.
    pub fn listener(&self) -> &UnixListener {
        &self.listener
    }

    /// Restores what is no longer ours in the folder (a cleaner of old files, a careless hand). The lock comes first:
    /// without it the folder belongs to somebody else.
    pub fn repair(&mut self) {
        match self.restore() {
            Ok(restored) => {
                self.trouble = None;
                for name in restored {
                    log::warn(format_args!(
                        "{} was gone or replaced; it was made anew",
                        self.dir.join(name).display()
                    ));
                }
            }
            Err(error) => {
                // Each second again, but said once.
                let trouble = Some(error.to_string());
                if self.trouble != trouble {
                    log::error(format_args!(
                        "this manager cannot be found any more: {error}"
                    ));
                    self.trouble = trouble;
                }
            }
        }
    }

    fn restore(&mut self) -> Result<Vec<&'static str>, RunDirError> {
        let mut restored = Vec::new();
        let path = self.dir.join(LOCK);
        if self.marks.lock.is_none() || number(&path) != self.marks.lock {
            self.lock = lock(&self.dir)?;
            self.marks.lock = number(&path);
            restored.push(LOCK);
        }
        if number(&self.dir.join(CONTROL_SOCKET)) != self.marks.socket {
            let (listener, socket) = bind(&self.dir)?;
            self.listener = listener;
            self.marks.socket = Some(socket);
            restored.push(CONTROL_SOCKET);
        }
        if version(&self.dir.join(MANAGER_JSON)) != self.marks.description {
            self.write_description()?;
            restored.push(MANAGER_JSON);
        }
        Ok(restored)
    }

    /// Removes what was made, but for the lock file.
    pub fn leave(self) {
        for name in [CONTROL_SOCKET, MANAGER_JSON] {
            let _ = fs::remove_file(self.dir.join(name));
        }
    }

    fn write_description(&mut self) -> Result<(), RunDirError> {
        let path = self.dir.join(MANAGER_JSON);
        files::replace(&path, &self.description).map_err(fault("write", &path))?;
        self.marks.description = version(&path);
        Ok(())
    }
}

fn number(path: &Path) -> Option<(u64, u64)> {
    let file = fs::symlink_metadata(path).ok()?;
    Some((file.dev(), file.ino()))
}

fn version(path: &Path) -> Option<(u64, u64, i64, i64)> {
    let file = fs::symlink_metadata(path).ok()?;
    Some((file.dev(), file.ino(), file.mtime(), file.mtime_nsec()))
}

fn fault(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> RunDirError {
    let path = path.to_owned();
    move |error| RunDirError::File {
        action,
        path,
        error,
    }
}

fn lock(dir: &Path) -> Result<files::Lock, RunDirError> {
    files::private_folder(dir).map_err(fault("create", dir))?;
    let path = dir.join(LOCK);
    match files::lock(&path) {
        Ok(Some(lock)) => Ok(lock),
        Ok(None) => Err(RunDirError::Held(path)),
        Err(error) => Err(fault("lock", &path)(error)),
    }
}

/// Binds the socket beside its place and renames it there: it is never there with other rights, nor missing.
fn bind(dir: &Path) -> Result<(UnixListener, (u64, u64)), RunDirError> {
    let path = dir.join(CONTROL_SOCKET);
    let length = path.as_os_str().len();
    if length > 107 {
        return Err(RunDirError::TooLong(path, length));
    }
    let new = dir.join(NEW_SOCKET);
    let _ = fs::remove_file(&new);
    let listener = UnixListener::bind(&new).map_err(fault("bind", &path))?;
    let inode = listener
        .set_nonblocking(true)
        .and_then(|()| fs::set_permissions(&new, Permissions::from_mode(0o600)))
        .and_then(|()| fs::symlink_metadata(&new))
        .and_then(|file| fs::rename(&new, &path).map(|()| (file.dev(), file.ino())))
        .map_err(fault("bind", &path))?;
    Ok((listener, inode))
}

fn describe(hello: &Hello, cgroup: Option<String>) -> Vec<u8> {
    let file = ManagerFile {
        protocol_version: PROTOCOL_VERSION,
        system: hello.system.clone(),
        name: hello.name.clone(),
        incarnation: hello.incarnation.clone(),
        pid: hello.pid,
        start_ticks: start_ticks(hello.pid).unwrap_or_default(),
        boot_id: boot_id().unwrap_or_default(),
        started: hello.started.clone(),
        cgroup,
    };
    serde_json::to_vec(&file).unwrap_or_default()
}
