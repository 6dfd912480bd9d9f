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
    inode: (u64, u64),
    _lock: files::Lock,
}

impl RunDir {
    /// Takes the folder: lock, socket, `manager.json`, in this order. Connections are possible from then on.
    pub fn take(dir: &Path, hello: &Hello) -> Result<Self, RunDirError> {
        let lock = lock(dir)?;
        let description = describe(hello);
        let (listener, inode) = bind(dir)?;
        let run_dir = Self {
            dir: dir.to_owned(),
            description,
            listener,
            inode,
            _lock: lock,
        };
        run_dir.write_description()?;
        Ok(run_dir)
    }

    /// The socket's listener; does not block.
    pub fn listener(&self) -> &UnixListener {
        &self.listener
    }

    /// Binds anew when the socket's file is no longer ours (a cleaner of old files, a careless hand).
    pub fn repair(&mut self) {
        let ours = fs::symlink_metadata(self.dir.join(CONTROL_SOCKET))
            .is_ok_and(|file| (file.dev(), file.ino()) == self.inode);
        if ours {
            return;
        }
        match bind(&self.dir).and_then(|bound| self.write_description().map(|()| bound)) {
            Ok((listener, inode)) => {
                self.listener = listener;
                self.inode = inode;
                log::warn(format_args!(
                    "{} was gone or replaced; it was bound anew",
                    self.dir.join(CONTROL_SOCKET).display()
                ));
            }
            Err(error) => log::error(format_args!("nobody can connect any more: {error}")),
        }
    }

    /// Removes what was made, but for the lock file.
    pub fn leave(self) {
        for name in [CONTROL_SOCKET, MANAGER_JSON] {
            let _ = fs::remove_file(self.dir.join(name));
        }
    }

    fn write_description(&self) -> Result<(), RunDirError> {
        let path = self.dir.join(MANAGER_JSON);
        files::replace(&path, &self.description).map_err(fault("write", &path))
    }
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

fn describe(hello: &Hello) -> Vec<u8> {
    let file = ManagerFile {
        protocol_version: PROTOCOL_VERSION,
        system: hello.system.clone(),
        name: hello.name.clone(),
        incarnation: hello.incarnation.clone(),
        pid: hello.pid,
        start_ticks: start_ticks(hello.pid).unwrap_or_default(),
        boot_id: boot_id().unwrap_or_default(),
        started: hello.started.clone(),
    };
    serde_json::to_vec(&file).unwrap_or_default()
}
