//! The nodes of a home: each an agent of this machine, as `up` was told of them. Kept in `state/nodes.json`.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::str::FromStr;

use rts_ssh::Destination;
use serde::{Deserialize, Serialize};

use super::home::Home;
use super::{LOCAL_NODE, LocalError};

/// Longest file of nodes in bytes.
const MAX_FILE: u64 = 1024 * 1024;
/// Most nodes of one home.
const MAX_NODES: usize = 64;
/// Beginnings of names that other files of a home have.
const TAKEN: [&str; 2] = ["controller.", "nodes."];

/// A node, and the hosts of profiles that mean it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct NodeSetup {
    /// Name.
    pub name: String,
    /// Host names and addresses besides its name; none when nothing was said of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub aliases: Option<Vec<String>>,
    /// How it is reached, if it is not of this machine.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ssh: Option<SshNode>,
}

/// A node that is reached by SSH alone.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SshNode {
    /// Whom to reach.
    pub destination: Destination,
    /// Folders of this machine that are searched for its modules; none for those of the one who starts its relay.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub module_path: Option<Vec<PathBuf>>,
    /// Folder of this machine with the programs for it; none for that of `rtsctl`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub programs: Option<PathBuf>,
    /// Seconds for which the session is kept when no command needs it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keep_seconds: Option<u64>,
}

impl NodeSetup {
    /// A node of this name, of whose hosts nothing is said.
    pub fn named(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            aliases: None,
            ssh: None,
        }
    }

    /// The hosts that mean it.
    pub fn hosts(&self) -> &[String] {
        self.aliases.as_deref().unwrap_or_default()
    }
}

impl FromStr for NodeSetup {
    type Err = String;

    /// `NAME` or `NAME=HOST,…`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (name, hosts) = match text.split_once('=') {
            Some((name, hosts)) => (name, Some(hosts)),
            None => (text, None),
        };
        if !rts_agent::is_node_name(name) || TAKEN.iter().any(|taken| name.starts_with(taken)) {
            return Err(format!(
                "{name:?} is no name of a node: use 1 to 63 of a-z, A-Z, 0-9, '-', '_' and '.', not starting with '.', `controller.` or `nodes.`"
            ));
        }
        let hosts = hosts.map(|hosts| hosts.split(',').filter(|host| !host.is_empty()));
        let aliases = hosts.map(|hosts| hosts.map(str::to_owned).collect::<Vec<_>>());
        let bad = |host: &&String| host.chars().any(|c| c.is_whitespace() || "=/:".contains(c));
        if let Some(host) = aliases.iter().flatten().find(bad) {
            return Err(format!(
                "{host:?} is no host: write NAME=HOST,HOST without ports or paths"
            ));
        }
        Ok(Self {
            name: name.to_owned(),
            aliases,
            ssh: None,
        })
    }
}

/// All nodes of a home, the first of which takes what no host means.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Nodes {
    nodes: Vec<NodeSetup>,
}

impl Nodes {
    /// Those of a home; none when it was never told of any.
    fn read(home: &Home) -> Result<Option<Self>, LocalError> {
        use std::io::Read;
        let path = file(home);
        let read = std::fs::File::open(&path).and_then(|file| {
            let mut text = Vec::new();
            file.take(MAX_FILE).read_to_end(&mut text).map(|_| text)
        });
        let text = match read {
            Ok(text) => text,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(LocalError::file("read", path)(e)),
        };
        let nodes: Self =
            serde_json::from_slice(&text).map_err(|e| LocalError::file("read", &path)(e.into()))?;
        if nodes.nodes.is_empty() {
            return Ok(None);
        }
        for node in &nodes.nodes {
            let sound = node.name.parse::<NodeSetup>();
            sound.map_err(|e| LocalError::file("read", &path)(std::io::Error::other(e)))?;
        }
        Ok(Some(nodes))
    }

    /// Those of a home; `local` alone when it was never told of any.
    pub fn of(home: &Home) -> Result<Self, LocalError> {
        Ok(Self::read(home)?.unwrap_or_else(|| Self {
            nodes: vec![NodeSetup::named(LOCAL_NODE)],
        }))
    }

    /// Those that a home was told of, or in which they ran; none in a home in which nothing ever ran.
    pub fn known(home: &Home) -> Result<Self, LocalError> {
        match Self::read(home)? {
            Some(nodes) => Ok(nodes),
            None if home.node_state(LOCAL_NODE).is_dir() => Self::of(home),
            None => Ok(Self { nodes: Vec::new() }),
        }
    }

    /// The one of this name.
    pub fn named(&self, name: &str) -> Option<&NodeSetup> {
        self.nodes.iter().find(|node| node.name == name)
    }

    /// Those of a home, and `more`: what is said of the hosts of a node replaces what was said before. A home in which
    /// nothing ever ran has only those, if there are any.
    pub fn with(home: &Home, more: &[NodeSetup]) -> Result<Self, LocalError> {
        let mut all = match more {
            [] => Self::of(home)?,
            _ => Self::known(home)?,
        };
        for node in more {
            match all.nodes.iter_mut().find(|known| known.name == node.name) {
                Some(known) if known.ssh != node.ssh && node.ssh.is_some() => {
                    known.clone_from(node);
                }
                Some(known) if node.aliases.is_some() => known.aliases.clone_from(&node.aliases),
                Some(_) => {}
                None => all.nodes.push(node.clone()),
            }
        }
        all.check()?;
        Ok(all)
    }

    /// A host means one node, and there are not too many.
    fn check(&self) -> Result<(), LocalError> {
        if self.nodes.len() > MAX_NODES {
            return Err(LocalError::Nodes(format!(
                "a home has room for {MAX_NODES} nodes, and these would be {}",
                self.nodes.len()
            )));
        }
        let mut meant: BTreeMap<String, &str> = BTreeMap::new();
        for node in &self.nodes {
            meant.insert(node.name.to_ascii_lowercase(), &node.name);
        }
        for node in &self.nodes {
            for host in node.hosts() {
                let before = meant.insert(host.to_ascii_lowercase(), &node.name);
                if let Some(other) = before.filter(|other| *other != node.name) {
                    return Err(LocalError::Nodes(format!(
                        "host {host} would mean node {other} and node {}",
                        node.name
                    )));
                }
            }
        }
        Ok(())
    }

    /// Undoes that a home was told of a node, of which it knew what `before` says: all other nodes stay as they are now. When
    /// none is left, the home was never told of any. The caller holds the home's lock.
    pub fn take_back(
        home: &Home,
        told: &NodeSetup,
        before: Option<&NodeSetup>,
    ) -> Result<(), LocalError> {
        let Some(mut nodes) = Self::read(home)? else {
            return Ok(());
        };
        let place = nodes.nodes.iter().position(|node| node.name == told.name);
        // Somebody else may have said something of it since.
        let Some(at) = place.filter(|at| nodes.nodes[*at].ssh == told.ssh) else {
            return Ok(());
        };
        match before {
            Some(before) => nodes.nodes[at].clone_from(before),
            None => drop(nodes.nodes.remove(at)),
        }
        if !nodes.nodes.is_empty() {
            return nodes.save(home);
        }
        let path = file(home);
        match std::fs::remove_file(&path) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
                Err(LocalError::file("remove", path)(e))
            }
            _ => Ok(()),
        }
    }

    /// Remembers them.
    pub fn save(&self, home: &Home) -> Result<(), LocalError> {
        let path = file(home);
        let text = serde_json::to_vec_pretty(self)
            .map_err(|e| LocalError::file("write", &path)(e.into()))?;
        rts_host::files::replace_durably(&path, &text).map_err(LocalError::file("write", &path))
    }

    /// Those that are reached by SSH.
    pub fn by_ssh(&self) -> impl Iterator<Item = &NodeSetup> {
        self.nodes.iter().filter(|node| node.ssh.is_some())
    }

    /// All but one.
    #[must_use]
    pub fn without(&self, name: &str) -> Self {
        let others = self.nodes.iter().filter(|node| node.name != name);
        Self {
            nodes: others.cloned().collect(),
        }
    }

    /// Each of them.
    pub fn all(&self) -> &[NodeSetup] {
        &self.nodes
    }

    /// The node that takes what no host means.
    pub fn first(&self) -> &str {
        let first = self.nodes.first();
        first.map_or(LOCAL_NODE, |node| node.name.as_str())
    }

    /// What is known of the hosts of a node.
    pub fn hosts_of(&self, name: &str) -> &[String] {
        let node = self.nodes.iter().find(|node| node.name == name);
        node.map_or(&[], NodeSetup::hosts)
    }
}

fn file(home: &Home) -> PathBuf {
    home.state().join("nodes.json")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn home(folder: &std::path::Path) -> Home {
        let home = Home::settle(Some(folder.to_owned())).unwrap();
        rts_host::home::claim(home.path()).unwrap();
        home
    }

    fn names(nodes: &Nodes) -> Vec<&str> {
        nodes.all().iter().map(|node| node.name.as_str()).collect()
    }

    fn setup(text: &str) -> NodeSetup {
        text.parse().unwrap()
    }

    #[test]
    fn a_node_is_said_with_its_hosts_or_without() {
        assert_eq!(setup("arm").hosts(), [""; 0]);
        assert_eq!(setup("arm").aliases, None);
        assert_eq!(setup("arm=").aliases, Some(Vec::new()));
        assert_eq!(
            setup("arm=robot1.local,10.0.0.5").hosts(),
            ["robot1.local", "10.0.0.5"]
        );
        for wrong in ["", "a/b", ".a", "controller.sock", "nodes.json", "=x"] {
            assert!(wrong.parse::<NodeSetup>().is_err(), "{wrong}");
        }
        for wrong in ["a=robot:2809", "a=x y", "a=x=y"] {
            let error = wrong.parse::<NodeSetup>().unwrap_err();
            assert!(error.contains("NAME=HOST"), "{error}");
        }
    }

    #[test]
    fn a_home_that_was_told_of_none_has_local() {
        let temp = tempfile::tempdir().unwrap();
        let home = home(temp.path());
        assert_eq!(names(&Nodes::of(&home).unwrap()), ["local"]);
        assert_eq!(names(&Nodes::with(&home, &[]).unwrap()), ["local"]);
    }

    #[test]
    fn nodes_are_remembered_in_order_and_more_are_added() {
        let temp = tempfile::tempdir().unwrap();
        let home = home(temp.path());
        let two = Nodes::with(&home, &[setup("b=x"), setup("a")]).unwrap();
        assert_eq!((names(&two), two.first()), (vec!["b", "a"], "b"));
        two.save(&home).unwrap();
        assert_eq!(Nodes::of(&home).unwrap(), two);
        let three = Nodes::with(&home, &[setup("c"), setup("b"), setup("a=y")]).unwrap();
        assert_eq!(names(&three), ["b", "a", "c"]);
        assert_eq!(
            (three.hosts_of("b"), three.hosts_of("a")),
            (&["x".to_owned()][..], &["y".to_owned()][..])
        );
    }

    #[test]
    fn a_node_that_was_not_reached_is_taken_back_and_no_other_is() {
        let temp = tempfile::tempdir().unwrap();
        let home = home(temp.path());
        let by_ssh = |name: &str, host: &str| NodeSetup {
            ssh: Some(SshNode {
                destination: host.parse().unwrap(),
                module_path: None,
                programs: None,
                keep_seconds: None,
            }),
            ..setup(name)
        };
        let tell = |node: &NodeSetup| {
            let all = Nodes::with(&home, std::slice::from_ref(node)).unwrap();
            all.save(&home).unwrap();
        };
        let back = |node: &NodeSetup, before: Option<&NodeSetup>| {
            Nodes::take_back(&home, node, before).unwrap();
            names(&Nodes::known(&home).unwrap()).join(" ")
        };
        let (arm, leg, other) = (by_ssh("arm", "a"), by_ssh("leg", "b"), by_ssh("arm", "c"));
        tell(&arm);
        // Told by another `node add` while this one was still trying.
        tell(&leg);
        assert_eq!(back(&arm, None), "leg");
        tell(&other);
        assert_eq!(back(&arm, None), "leg arm", "somebody else's word stays");
        tell(&arm);
        assert_eq!(back(&arm, Some(&other)), "leg arm");
        assert_eq!(Nodes::of(&home).unwrap().named("arm"), Some(&other));
        back(&other, None);
        assert_eq!(back(&leg, None), "", "as if it had never been told of any");
        assert!(!file(&home).exists());
    }

    #[test]
    fn a_home_in_which_local_ran_keeps_it() {
        let temp = tempfile::tempdir().unwrap();
        let home = home(temp.path());
        std::fs::create_dir(home.node_state("local")).unwrap();
        assert_eq!(
            names(&Nodes::with(&home, &[setup("a")]).unwrap()),
            ["local", "a"]
        );
    }

    #[test]
    fn a_host_means_one_node() {
        let temp = tempfile::tempdir().unwrap();
        let home = home(temp.path());
        for wrong in [["a=x", "b=X"], ["a=b", "b"]] {
            let error = Nodes::with(&home, &wrong.map(setup)).unwrap_err();
            assert_eq!(error.exit().code(), 2, "{error}");
        }
        assert!(Nodes::with(&home, &["a=a,x", "a=x"].map(setup)).is_ok());
    }

    #[test]
    fn a_file_that_cannot_be_read_is_named() {
        let temp = tempfile::tempdir().unwrap();
        let home = home(temp.path());
        for wrong in ["{", r#"{"nodes":[{"name":"../x"}]}"#] {
            std::fs::write(file(&home), wrong).unwrap();
            let error = Nodes::of(&home).unwrap_err();
            assert!(error.to_string().ends_with("state/nodes.json"), "{error}");
        }
    }
}
