//! Which control groups are mounted, and where a process is in them.

use std::path::{Component, Path, PathBuf};

use super::Cgroup;

/// How the groups of a hierarchy are ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Version {
    /// Version 2, alone or beside version 1.
    V2,
    /// Version 1 with the freezer.
    Freezer,
    /// Version 1 with the pids controller.
    Pids,
}

/// A mounted hierarchy.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Hierarchy {
    pub version: Version,
    /// Where it is mounted.
    pub mount: PathBuf,
    /// The group of the process that was asked for.
    pub own: PathBuf,
}

/// The hierarchies that this process can see, the best first.
pub(super) fn all() -> Vec<Hierarchy> {
    of("self")
}

/// The groups of a process.
pub(super) fn groups_of(pid: u32) -> Vec<Cgroup> {
    let groups = of(&pid.to_string());
    let groups = groups.into_iter().map(|h| Cgroup::new(h.own, h.version));
    groups.collect()
}

fn of(process: &str) -> Vec<Hierarchy> {
    // Other mounts than ours are of no use: paths are looked up by us.
    let mounts = std::fs::read_to_string("/proc/self/mountinfo");
    let places = std::fs::read_to_string(format!("/proc/{process}/cgroup"));
    match (mounts, places) {
        (Ok(mounts), Ok(places)) => parse(&mounts, &places),
        _ => Vec::new(),
    }
}

fn parse(mounts: &str, places: &str) -> Vec<Hierarchy> {
    let mut found: Vec<Hierarchy> = Vec::new();
    for mount in mounts.lines().filter_map(Mount::read) {
        for version in mount.versions() {
            let Some(own) = place(places, version).and_then(|path| mount.locate(path)) else {
                continue;
            };
            if found.iter().all(|known| known.version != version) {
                let mount = mount.point.clone();
                found.push(Hierarchy {
                    version,
                    mount,
                    own,
                });
            }
        }
    }
    found.sort_by_key(|hierarchy| hierarchy.version);
    found
}

/// Path of a process within a hierarchy, by its `/proc/PID/cgroup`.
fn place(places: &str, version: Version) -> Option<&str> {
    places.lines().find_map(|line| {
        let (number, rest) = line.split_once(':')?;
        let (controllers, path) = rest.split_once(':')?;
        let has = |name| controllers.split(',').any(|controller| controller == name);
        let meant = match version {
            Version::V2 => number == "0" && controllers.is_empty(),
            Version::Freezer => has("freezer"),
            Version::Pids => has("pids"),
        };
        meant.then_some(path)
    })
}

/// A line of `mountinfo` that is about control groups.
struct Mount<'a> {
    /// The group that is seen at the point.
    root: PathBuf,
    point: PathBuf,
    is_v2: bool,
    options: &'a str,
}

impl<'a> Mount<'a> {
    fn read(line: &'a str) -> Option<Self> {
        let (place, kind) = line.split_once(" - ")?;
        let mut place = place.split(' ').skip(3);
        let (root, point) = (place.next()?, place.next()?);
        let mut kind = kind.split(' ');
        let is_v2 = match kind.next()? {
            "cgroup2" => true,
            "cgroup" => false,
            _ => return None,
        };
        Some(Self {
            root: unescape(root),
            point: unescape(point),
            is_v2,
            options: kind.nth(1).unwrap_or_default(),
        })
    }

    fn versions(&self) -> Vec<Version> {
        if self.is_v2 {
            return vec![Version::V2];
        }
        let v1 = [("freezer", Version::Freezer), ("pids", Version::Pids)];
        let has = |name: &str| self.options.split(',').any(|option| option == name);
        v1.into_iter()
            .filter_map(|(name, version)| has(name).then_some(version))
            .collect()
    }

    /// Where a group is seen; `None` when it is outside of what is mounted.
    fn locate(&self, path: &str) -> Option<PathBuf> {
        let rest = Path::new(path).strip_prefix(&self.root).ok()?;
        let inside = rest
            .components()
            .all(|part| matches!(part, Component::Normal(_)));
        // Without the slash that joining an empty path leaves.
        inside.then(|| self.point.join(rest).components().collect())
    }
}

/// Blanks and the like are written as three octal digits.
fn unescape(text: &str) -> PathBuf {
    use std::os::unix::ffi::OsStringExt;
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let code = after
            .get(..3)
            .filter(|_| first == b'\\')
            .and_then(|digits| u8::from_str_radix(std::str::from_utf8(digits).ok()?, 8).ok());
        bytes.push(code.unwrap_or(first));
        rest = if code.is_some() { &after[3..] } else { after };
    }
    PathBuf::from(std::ffi::OsString::from_vec(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(mounts: &str, places: &str) -> Vec<(Version, String)> {
        let all = parse(mounts, places).into_iter();
        all.map(|h| (h.version, h.own.display().to_string()))
            .collect()
    }

    #[test]
    fn a_pure_version_2_as_systemd_mounts_it() {
        let mounts = "23 1 0:5 / /proc rw - proc proc rw\n\
            35 24 0:30 / /sys/fs/cgroup rw,nosuid shared:9 - cgroup2 cgroup2 rw,nsdelegate\n";
        let places = "0::/user.slice/user-1000.slice/user@1000.service/app.slice/x.scope\n";
        let own = "/sys/fs/cgroup/user.slice/user-1000.slice/user@1000.service/app.slice/x.scope";
        assert_eq!(seen(mounts, places), [(Version::V2, own.to_owned())]);
    }

    #[test]
    fn a_hybrid_prefers_version_2_then_the_freezer() {
        let mounts = "39 31 0:36 / /c/pids rw - cgroup cgroup rw,pids\n\
            37 31 0:34 / /c/freezer rw - cgroup cgroup rw,freezer\n\
            32 31 0:29 / /c/cpu rw - cgroup cgroup rw,cpu,cpuacct\n\
            41 31 0:38 / /c/uni\\040fied rw - cgroup2 cgroup2 rw\n";
        let places = "8:pids:/p\n6:freezer:/\n4:memory:/m\n0::/\n";
        let want = [
            (Version::V2, "/c/uni fied".to_owned()),
            (Version::Freezer, "/c/freezer".to_owned()),
            (Version::Pids, "/c/pids/p".to_owned()),
        ];
        assert_eq!(seen(mounts, places), want);
    }

    #[test]
    fn a_container_sees_its_part_of_the_tree() {
        let mount = |root: &str| format!("1 2 0:3 {root} /sys/fs/cgroup ro - cgroup2 cgroup rw");
        let own = |root: &str, path: &str| seen(&mount(root), &format!("0::{path}"));
        let at = |path: &str| vec![(Version::V2, path.to_owned())];
        assert_eq!(own("/docker/a", "/docker/a"), at("/sys/fs/cgroup"));
        assert_eq!(own("/docker/a", "/docker/a/b"), at("/sys/fs/cgroup/b"));
        assert_eq!(own("/docker/a", "/docker/b"), []);
        assert_eq!(own("/", "/../../x"), []);
        assert_eq!(seen("rubbish - x\n\n", "0::/"), []);
        assert_eq!(seen("1 2 3 / /a rw - cgroup", "rubbish\n::"), []);
    }
}
