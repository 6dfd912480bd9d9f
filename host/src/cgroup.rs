//! Control groups that hold a manager and all that it starts, so that nothing of it survives: a process may leave its
//! process group, but not its control group.
//!
//! `<own cgroup>/rtsctl-<12 digits of the home>/<node>.<run folder>`: the name alone tells whose it is, so that it is
//! found with every daemon dead and the run folder gone. Where none is permitted, the process group has to do.

mod group;
mod hierarchy;
mod kill;
mod name;
mod survey;

use std::io;
use std::path::{Path, PathBuf};

pub use group::Cgroup;
use hierarchy::Hierarchy;
pub use hierarchy::Version;

/// Names the environment variable that chooses.
pub const VARIABLE: &str = "RTSCTL_CGROUP";
/// Tries to make a group while others remove the folder above it.
const TRIES: u32 = 10;

/// Which control groups may be used: the value of `RTSCTL_CGROUP`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Choice {
    /// `auto`: the first that is permitted of version 2, then version 1.
    #[default]
    Auto,
    /// `v2`: none but version 2.
    V2,
    /// `v1`: none but version 1, by its freezer or else its pids controller.
    V1,
    /// `off`: none; those of this home that are there already are left alone too.
    Off,
}

impl Choice {
    /// What `RTSCTL_CGROUP` says. Anything that is no choice is `auto`.
    pub fn from_env() -> Self {
        let value = std::env::var(VARIABLE).unwrap_or_default();
        Self::parse(&value).unwrap_or_default()
    }

    /// Reads a value; `None` when it is no choice.
    pub fn parse(value: &str) -> Option<Self> {
        match value {
            "auto" | "" => Some(Self::Auto),
            "v2" => Some(Self::V2),
            "v1" => Some(Self::V1),
            "off" => Some(Self::Off),
            _ => None,
        }
    }

    fn allows(self, version: Version) -> bool {
        match self {
            Self::Auto => true,
            Self::V2 => version == Version::V2,
            Self::V1 => version != Version::V2,
            Self::Off => false,
        }
    }
}

/// No control group can be made here.
#[derive(Debug)]
pub struct NotPermitted(Vec<(PathBuf, io::Error)>);

impl std::fmt::Display for NotPermitted {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0.is_empty() {
            return f.write_str("no control groups are mounted that may be used");
        }
        f.write_str("cannot make a control group")?;
        for (n, (path, error)) in self.0.iter().enumerate() {
            let comma = if n == 0 { ": " } else { ", " };
            write!(f, "{comma}{}: {error}", path.display())?;
        }
        Ok(())
    }
}

impl std::error::Error for NotPermitted {}

/// The control groups of a home. Holds no state: what is there is asked each time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cgroups {
    /// Of the folder above them.
    name: String,
    choice: Choice,
}

impl Cgroups {
    /// Of a home; nothing is made yet.
    pub fn of(home: &Path, choice: Choice) -> Self {
        Self {
            name: name::of_home(home),
            choice,
        }
    }

    /// Makes a group, in the first hierarchy where that is permitted. One that is there already is given as it is.
    pub fn create(&self, name: &str) -> Result<Cgroup, NotPermitted> {
        let mut refused = Vec::new();
        for hierarchy in hierarchy::all() {
            if !self.choice.allows(hierarchy.version) {
                continue;
            }
            match self.make(&hierarchy, name) {
                Ok(group) => return Ok(group),
                Err(error) => refused.push((hierarchy.own, error)),
            }
        }
        Err(NotPermitted(refused))
    }

    fn make(&self, hierarchy: &Hierarchy, name: &str) -> io::Result<Cgroup> {
        let parent = hierarchy.own.join(&self.name);
        let path = parent.join(name);
        for _ in 0..TRIES {
            make_folder(&parent)?;
            match make_folder(&path) {
                // The last group of the home was just removed, and the folder with it.
                Err(e) if e.kind() == io::ErrorKind::NotFound => {}
                Err(e) => {
                    let _ = std::fs::remove_dir(&parent);
                    return Err(e);
                }
                Ok(()) => return Ok(Cgroup::new(path, hierarchy.version)),
            }
        }
        Err(io::Error::from(io::ErrorKind::NotFound))
    }

    /// The group of this name that a process is in.
    pub fn holding(&self, name: &str, pid: u32) -> Option<Cgroup> {
        let groups = hierarchy::groups_of(pid);
        groups.into_iter().find(|group| {
            self.choice != Choice::Off
                && group.name() == name
                && group.path().parent().is_some_and(|p| self.is_parent(p))
        })
    }

    /// All groups of the home, wherever they are below the mounts: whoever made them may have lived in another group
    /// than this process. Those of another process namespace, such as a container's with a home of the same path, are
    /// not meant.
    pub fn find(&self) -> Vec<Cgroup> {
        let mut groups = Vec::new();
        for (parent, version) in self.parents() {
            for path in survey::folders(&parent) {
                groups.push(Cgroup::new(path, version));
            }
        }
        groups.retain(Cgroup::is_near);
        groups.sort_by(|a, b| a.path().cmp(b.path()));
        groups
    }

    /// Removes what is left of the folders above the groups, if they are empty.
    pub fn tidy(&self) {
        for (parent, _) in self.parents() {
            let _ = std::fs::remove_dir(parent);
        }
    }

    /// The folders above the groups of the home, empty ones included.
    pub fn folders(&self) -> Vec<PathBuf> {
        self.parents().into_iter().map(|(path, _)| path).collect()
    }

    fn parents(&self) -> Vec<(PathBuf, Version)> {
        if self.choice == Choice::Off {
            return Vec::new();
        }
        let mut found = Vec::new();
        for hierarchy in hierarchy::all() {
            let paths = survey::named(&hierarchy.mount, &self.name);
            found.extend(paths.into_iter().map(|path| (path, hierarchy.version)));
        }
        found
    }

    fn is_parent(&self, path: &Path) -> bool {
        path.file_name().is_some_and(|name| name == &*self.name)
    }
}

fn make_folder(path: &Path) -> io::Result<()> {
    match std::fs::create_dir(path) {
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists => Ok(()),
        other => other,
    }
}

#[cfg(test)]
mod tests;
