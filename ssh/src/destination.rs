//! Whom to reach, and how: what the user said, and the arguments of `ssh` that follow.

use std::ffi::OsString;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Longest name of a host or user in bytes.
const MAX_NAME: usize = 255;

/// What is done about a host key that is not known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum HostKeys {
    /// It is refused.
    #[default]
    Known,
    /// It is taken and remembered. One that has changed is refused all the same.
    AcceptNew,
}

/// An account of a machine. What is not said here is as the user's `ssh` settings have it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Destination {
    /// Host name, address, or a name in the settings.
    pub host: String,
    /// Account.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub user: Option<String>,
    /// TCP port.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub port: Option<u16>,
    /// Private key; no other one is offered then.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub identity: Option<PathBuf>,
    /// Settings that are read instead of the user's (`ssh -F`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub config: Option<PathBuf>,
    /// File of known host keys instead of the user's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub known_hosts: Option<PathBuf>,
    /// What is done about a host key that is not known.
    #[serde(default)]
    pub host_keys: HostKeys,
}

impl Destination {
    /// A host of which nothing else is said.
    pub fn new(host: &str) -> Result<Self, String> {
        let destination = Self {
            host: host.to_owned(),
            user: None,
            port: None,
            identity: None,
            config: None,
            known_hosts: None,
            host_keys: HostKeys::Known,
        };
        destination.check()?;
        Ok(destination)
    }

    /// Names that `ssh` could take for something else are refused, wherever they come from.
    pub fn check(&self) -> Result<(), String> {
        let sound = |name: &str| {
            let bad =
                |c: char| c.is_whitespace() || c.is_control() || "'\"`$\\;&<>|(){}*?".contains(c);
            (1..=MAX_NAME).contains(&name.len()) && !name.starts_with('-') && !name.contains(bad)
        };
        // Only an address has colons, and more than one.
        let one_colon = self.host.matches(':').count() == 1;
        if !sound(&self.host) || self.host.contains(['/', '@', '[', ']']) || one_colon {
            return Err(format!("{:?} is no name of a host", self.host));
        }
        match self.user.as_deref().filter(|user| !sound(user)) {
            Some(user) => Err(format!("{user:?} is no name of an account")),
            None => Ok(()),
        }
    }

    /// Arguments of `ssh` up to the name of the host.
    pub(crate) fn arguments(&self) -> Vec<OsString> {
        let mut arguments: Vec<OsString> = Vec::new();
        let mut add = |name: &str, value: OsString| arguments.extend([name.into(), value]);
        if let Some(config) = &self.config {
            add("-F", config.into());
        }
        if let Some(user) = &self.user {
            add("-l", user.into());
        }
        if let Some(port) = self.port {
            add("-p", port.to_string().into());
        }
        if let Some(identity) = &self.identity {
            add("-i", plain(identity));
            add("-o", "IdentitiesOnly=yes".into());
        }
        if let Some(known) = &self.known_hosts {
            let mut option = OsString::from("UserKnownHostsFile=\"");
            option.push(plain(known));
            option.push("\"");
            add("-o", option);
        }
        let check = match self.host_keys {
            HostKeys::Known => "StrictHostKeyChecking=yes",
            HostKeys::AcceptNew => "StrictHostKeyChecking=accept-new",
        };
        add("-o", check.into());
        add("--", self.host.as_str().into());
        arguments
    }
}

/// A path in which `ssh` finds no word of its own (`%h`).
pub(crate) fn plain(path: &Path) -> OsString {
    match path.to_str() {
        Some(text) => text.replace('%', "%%").into(),
        None => path.into(),
    }
}

impl FromStr for Destination {
    type Err = String;

    /// `[user@]host[:port]`; an IPv6 address with a port is written `[::1]:22`.
    fn from_str(text: &str) -> Result<Self, String> {
        let help = "write [user@]host[:port]";
        let (user, rest) = match text.rsplit_once('@') {
            Some((user, rest)) => (Some(user), rest),
            None => (None, text),
        };
        let (host, port) = match rest.strip_prefix('[') {
            Some(rest) => {
                let (host, after) = rest.split_once(']').ok_or(help)?;
                (
                    host,
                    after.strip_prefix(':').or(after.is_empty().then_some("")),
                )
            }
            None => match rest.split_once(':') {
                // Several colons are an address.
                Some((_, port)) if port.contains(':') => (rest, Some("")),
                Some((host, port)) if !port.is_empty() => (host, Some(port)),
                Some(_) => (rest, None),
                None => (rest, Some("")),
            },
        };
        let port = match port.ok_or(help)? {
            "" => None,
            port => match port.parse::<u16>() {
                Ok(port) if port > 0 => Some(port),
                _ => return Err(format!("{port:?} is no port: {help}")),
            },
        };
        let destination = Self {
            user: user.map(str::to_owned),
            port,
            ..Self::new(host).map_err(|e| format!("{e}: {help}"))?
        };
        destination.check().map_err(|e| format!("{e}: {help}"))?;
        Ok(destination)
    }
}

/// As [`Destination::from_str`] reads it.
impl fmt::Display for Destination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(user) = &self.user {
            write!(f, "{user}@")?;
        }
        match self.port {
            Some(port) if self.host.contains(':') => write!(f, "[{}]:{port}", self.host),
            Some(port) => write!(f, "{}:{port}", self.host),
            None => write!(f, "{}", self.host),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read(text: &str) -> (Option<String>, String, Option<u16>) {
        let read: Destination = text.parse().unwrap();
        assert_eq!(read.to_string().parse::<Destination>().unwrap(), read);
        (read.user, read.host, read.port)
    }

    #[test]
    fn people_write_user_host_and_port() {
        let some = |text: &str| Some(text.to_owned());
        assert_eq!(read("robot"), (None, "robot".into(), None));
        assert_eq!(read("pi@robot:22"), (some("pi"), "robot".into(), Some(22)));
        assert_eq!(read("a@b@robot"), (some("a@b"), "robot".into(), None));
        assert_eq!(read("fe80::1%eth0"), (None, "fe80::1%eth0".into(), None));
        assert_eq!(
            read("pi@[::1]:2222"),
            (some("pi"), "::1".into(), Some(2222))
        );
        assert_eq!(read("[::1]"), (None, "::1".into(), None));
        for wrong in ["pi@[:]", "[a:b]", "[[a]"] {
            assert!(wrong.parse::<Destination>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn what_ssh_could_take_for_something_else_is_refused() {
        let wrong = [
            "",
            "@",
            "pi@",
            "@robot",
            "-oProxyCommand=x",
            "pi@-x",
            "-x@robot",
            "a b",
            "a;b",
            "a`b`",
            "robot:",
            "robot:0",
            "robot:65536",
            "robot:ssh",
            "[::1",
            "[::1]x",
            "a/b",
            "a\nb",
        ];
        for text in wrong {
            assert!(text.parse::<Destination>().is_err(), "{text:?}");
        }
    }

    #[test]
    fn arguments_name_what_was_said_and_end_with_the_host() {
        let mut destination: Destination = "pi@robot:2222".parse().unwrap();
        destination.identity = Some("/k/%h".into());
        destination.known_hosts = Some("/k/known hosts".into());
        destination.host_keys = HostKeys::AcceptNew;
        let arguments: Vec<_> = destination.arguments();
        let text: Vec<_> = arguments.iter().map(|a| a.to_str().unwrap()).collect();
        insta::assert_snapshot!(text.join(" "), @r#"-l pi -p 2222 -i /k/%%h -o IdentitiesOnly=yes -o UserKnownHostsFile="/k/known hosts" -o StrictHostKeyChecking=accept-new -- robot"#);
    }

    #[test]
    fn a_manifest_may_say_no_more_than_there_is() {
        let read = |text| serde_json::from_str::<Destination>(text);
        let sound = read(r#"{"host":"robot","user":"pi","hostKeys":"acceptNew"}"#).unwrap();
        assert_eq!(sound.host_keys, HostKeys::AcceptNew);
        assert!(read(r#"{"host":"robot","password":"x"}"#).is_err());
        assert!(read(r#"{"host":"-x"}"#).unwrap().check().is_err());
    }

    proptest! {
        #[test]
        fn what_is_read_is_sound_and_written_the_same(text in "[-a-z@:%0-9\\[\\]. ]{0,20}") {
            if let Ok(read) = text.parse::<Destination>() {
                prop_assert!(read.check().is_ok());
                prop_assert_eq!(read.to_string().parse::<Destination>().unwrap(), read);
            }
        }
    }
}
