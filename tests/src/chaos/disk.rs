//! A small disk of its own below `state/`, which can be filled.
//!
//! It is mounted in a mount namespace of this program, so that nobody else sees it and nothing is left of it.

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Says that this program is in a mount namespace of its own.
pub const INSIDE: &str = "RTS_CHAOS_INSIDE";

/// The disk; nothing when it cannot be had.
#[derive(Debug)]
pub struct Disk(Option<PathBuf>);

/// True when this user may mount, in a namespace.
pub fn may_mount() -> bool {
    let mut command = Command::new("unshare");
    command
        .args(["-m", "true"])
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

impl Disk {
    /// Mounts it when it is wanted.
    pub fn mount(home: &Path, wanted: bool) -> Self {
        let state = home.join("state");
        if !wanted || std::env::var_os(INSIDE).is_none() {
            return Self(None);
        }
        let mut command = Command::new("mount");
        command
            .args(["-t", "tmpfs", "-o", "size=6m,mode=700", "tmpfs"])
            .arg(&state);
        let mounted = std::fs::create_dir_all(&state).is_ok()
            && command.status().is_ok_and(|status| status.success());
        Self(mounted.then_some(state))
    }

    /// True when it can be filled.
    pub fn is_there(&self) -> bool {
        self.0.is_some()
    }

    /// Fills it to the last byte.
    pub fn fill(&self) {
        let Some(filler) = self.filler() else { return };
        let Ok(mut file) = OpenOptions::new().create(true).append(true).open(filler) else {
            return;
        };
        while file.write_all(&[b'x'; 4096]).is_ok() {}
        while file.write_all(b"x").is_ok() {}
    }

    /// Frees it.
    pub fn free(&self) {
        if let Some(filler) = self.filler() {
            let _ = std::fs::remove_file(filler);
        }
    }

    fn filler(&self) -> Option<PathBuf> {
        Some(self.0.as_ref()?.join("filler"))
    }

    /// Copies what is on it to a folder that stays.
    pub fn keep(&self, folder: &Path) {
        if let Some(state) = &self.0 {
            self.free();
            let _ = Command::new("cp").arg("-a").arg(state).arg(folder).status();
        }
    }

    /// Takes it away.
    pub fn unmount(&mut self) {
        if let Some(state) = self.0.take() {
            let _ = Command::new("umount").arg("-l").arg(state).status();
        }
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        self.unmount();
    }
}
