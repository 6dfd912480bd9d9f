//! Limits of this process.

use std::io;

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// Open files that are enough for any node, and for a controller of a thousand.
const MAX_FILES: u64 = 65_536;

/// Raises the soft limit of open files, of which a warning is logged where it cannot be.
pub fn raise_open_files() {
    if let Err(e) = try_raise_open_files() {
        tracing::warn!("cannot raise the limit of open files: {e}");
    }
}

/// Raises the soft limit of open files: the usual one of 1024 is meant for programs that use `select`. A program without more
/// still works.
pub fn try_raise_open_files() -> io::Result<()> {
    let limit = getrlimit(Resource::Nofile);
    let wanted = limit.maximum.unwrap_or(MAX_FILES).min(MAX_FILES);
    if limit.current.is_none_or(|current| current >= wanted) {
        return Ok(());
    }
    let raised = Rlimit {
        current: Some(wanted),
        maximum: limit.maximum,
    };
    Ok(setrlimit(Resource::Nofile, raised)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_files_as_are_permitted() {
        try_raise_open_files().unwrap();
        let limit = getrlimit(Resource::Nofile);
        let wanted = limit.maximum.unwrap_or(MAX_FILES).min(MAX_FILES);
        assert!(limit.current.is_none_or(|current| current >= wanted));
    }
}
