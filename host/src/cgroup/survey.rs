//! Looking through the folders of a hierarchy, with bounds.

use std::path::{Path, PathBuf};

/// Most folders that are looked at.
const MOST: usize = 50_000;

/// The folders in a folder; none when it cannot be read.
pub(super) fn folders(path: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
    entries
        .filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()))
        .map(|entry| entry.path())
        .collect()
}

/// Folders of this name below a root.
pub(super) fn named(root: &Path, name: &str) -> Vec<PathBuf> {
    let mut found = below(root);
    found.retain(|path| path.file_name().is_some_and(|own| own == name));
    found
}

/// A folder and all below it, each after the one that holds it.
pub(super) fn below(root: &Path) -> Vec<PathBuf> {
    let mut all = vec![root.to_owned()];
    let mut next = 0;
    while next < all.len() && all.len() < MOST {
        all.extend(folders(&all[next]));
        next += 1;
    }
    all
}
