//! Files that `#include` names: found by who has them.

/// How an `#include` names a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Include<'a> {
    /// The file that it stands in, as [`Found::path`] or the caller named it.
    pub from: &'a str,
    /// The name between the quotes or the angle brackets.
    pub name: &'a str,
    /// `<name>`: not looked for beside `from`.
    pub angled: bool,
}

/// A file that was found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    /// What findings call it. Two files never have the same path.
    pub path: String,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

/// What finds files.
pub trait Sources {
    /// The file that is meant; `None` if there is none.
    ///
    /// # Errors
    /// Why a file that is there cannot be read.
    fn find(&self, include: Include<'_>) -> Result<Option<Found>, String>;
}

/// Nothing can be included.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoSources;

impl Sources for NoSources {
    fn find(&self, _: Include<'_>) -> Result<Option<Found>, String> {
        Ok(None)
    }
}
