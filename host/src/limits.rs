//! Limits of this process.

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// Open files that are enough for any node, and for a controller of a thousand.
const MAX_FILES: u64 = 65_536;

/// Raises the soft limit of open files: the usual one of 1024 is meant for programs that use `select`. Where it cannot be
/// raised, that is a warning in the log.
pub fn raise_open_files() {
    let limit = getrlimit(Resource::Nofile);
    let wanted = limit.maximum.unwrap_or(MAX_FILES).min(MAX_FILES);
    if limit.current.is_none_or(|current| current >= wanted) {
        return;
    }
    let raised = Rlimit {
        current: Some(wanted),
        maximum: limit.maximum,
    };
    if let Err(e) = setrlimit(Resource::Nofile, raised) {
        tracing::warn!("cannot raise the limit of open files to {wanted}: {e}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_files_as_are_permitted() {
        raise_open_files();
        let limit = getrlimit(Resource::Nofile);
        let wanted = limit.maximum.unwrap_or(MAX_FILES).min(MAX_FILES);
        assert!(limit.current.is_none_or(|current| current >= wanted));
    }
}
