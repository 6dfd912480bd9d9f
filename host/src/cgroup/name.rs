//! The name of the folder above the groups of a home.

use std::fmt::Write;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

/// Bytes of the digest that are shown.
const BYTES: usize = 6;

/// `rtsctl-` and 12 hexadecimal digits of the digest of the home's real path.
pub(super) fn of_home(home: &Path) -> String {
    let digest = Sha256::digest(real(home).as_os_str().as_bytes());
    let mut name = "rtsctl-".to_owned();
    for byte in digest.iter().take(BYTES) {
        let _ = write!(name, "{byte:02x}");
    }
    name
}

/// The path without links, also while its last parts do not exist.
fn real(path: &Path) -> PathBuf {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let found = path
        .ancestors()
        .find_map(|part| Some((part, std::fs::canonicalize(part).ok()?)));
    match found {
        Some((part, real)) => match path.strip_prefix(part) {
            Ok(rest) if rest.as_os_str().is_empty() => real,
            Ok(rest) => real.join(rest),
            Err(_) => path,
        },
        None => path,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_home_has_one_name_by_whatever_link_and_before_and_after_its_life() {
        let temp = tempfile::tempdir().unwrap();
        let home = temp.path().join("real/home");
        let before = of_home(&home);
        std::fs::create_dir_all(&home).unwrap();
        std::os::unix::fs::symlink(temp.path().join("real"), temp.path().join("link")).unwrap();
        assert_eq!(of_home(&home), before);
        assert_eq!(of_home(&temp.path().join("link/home")), before);
        assert_eq!(of_home(&home.join("")), before);
        assert_ne!(of_home(temp.path()), before);
        std::fs::remove_dir(&home).unwrap();
        assert_eq!(of_home(&temp.path().join("link/home")), before);
        assert_eq!(before.len(), "rtsctl-".len() + 12);
    }
}
