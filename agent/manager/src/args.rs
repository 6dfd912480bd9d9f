//! Command line of the manager. It is read by hand-written clients (the agent), so it is small and starts fast.

use std::ffi::OsString;
use std::path::PathBuf;

use rts_manager_api::control::SystemId;
use rts_manager_api::zygote::Become;

const HELP: &str = "\
Holds components: loads modules and obeys its control socket. Usually started by rts-agent.

Usage: rts-manager --dir DIR --name NAME [OPTIONS]
       rts-manager --describe FILE --type NAME
       rts-manager --zygote [--home DIR]

Options:
      --dir DIR            Folder of this manager: lock, control.sock and manager.json
      --name NAME          Manager name
      --system-name NAME   System that it belongs to (needs --system-uid)
      --system-uid UID     Unique id of that system
      --incarnation UUID   Unique id of this start; made up when left out
      --describe FILE      Open a module, print what it says of itself as JSON, and leave
      --type NAME          Type that this module must hold
      --zygote             Fork managers for the agent whose socket is standard input
      --home DIR           Shown by `ps`, so that it is known whose zygote it is
  -h, --help               Print help
  -V, --version            Print version

A socket as standard input is served as the first control connection.
";

/// What the command line asks for.
pub enum Parsed {
    /// Serve.
    Run(Settings),
    /// Describe the module in this file, which must hold this type.
    Describe(PathBuf, String),
    /// Fork managers for an agent of this home.
    Zygote(OsString),
    /// Print and leave.
    Print(String),
}

/// Settled arguments.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Settings {
    /// Run folder.
    pub dir: PathBuf,
    /// Manager name.
    pub name: String,
    /// System that it belongs to.
    pub system: Option<SystemId>,
    /// Unique id of this start.
    pub incarnation: String,
    /// Name of its control group, where that is not the one that its run folder has.
    pub cgroup: Option<String>,
}

impl Settings {
    /// The command line that says the same, program name excluded.
    pub fn words(&self) -> Vec<OsString> {
        let mut words: Vec<OsString> = vec!["--dir".into(), self.dir.clone().into()];
        let mut say = |key: &str, value: &str| words.extend([key.into(), value.into()]);
        say("--name", &self.name);
        if let Some(system) = &self.system {
            say("--system-name", &system.name);
            say("--system-uid", &system.uid);
        }
        say("--incarnation", &self.incarnation);
        words
    }
}

impl From<Become> for Settings {
    fn from(named: Become) -> Self {
        let Become {
            dir,
            name,
            system,
            incarnation,
            cgroup,
        } = named;
        Self {
            dir,
            name,
            system,
            incarnation,
            cgroup,
        }
    }
}

/// A command line that cannot be obeyed.
#[derive(Debug, thiserror::Error)]
pub enum UsageError {
    /// Not one of the options, or a value is missing.
    #[error(transparent)]
    Option(#[from] lexopt::Error),
    /// An option that must be there.
    #[error("{0} is missing")]
    Missing(&'static str),
}

/// Reads the arguments, program name excluded.
pub fn parse(args: impl IntoIterator<Item = OsString>) -> Result<Parsed, UsageError> {
    use lexopt::prelude::*;
    let mut parser = lexopt::Parser::from_args(args);
    let (mut dir, mut name, mut incarnation) = (None, None, None);
    let (mut system_name, mut system_uid) = (None, None);
    let (mut module, mut type_name) = (None, None);
    let (mut zygote, mut home) = (false, OsString::new());
    while let Some(argument) = parser.next()? {
        match argument {
            Long("dir") => dir = Some(PathBuf::from(parser.value()?)),
            Long("name") => name = Some(parser.value()?.string()?),
            Long("system-name") => system_name = Some(parser.value()?.string()?),
            Long("system-uid") => system_uid = Some(parser.value()?.string()?),
            Long("incarnation") => incarnation = Some(parser.value()?.string()?),
            Long("describe") => module = Some(PathBuf::from(parser.value()?)),
            Long("zygote") => zygote = true,
            Long("home") => home = parser.value()?,
            // Holds the command lines of its copies open.
            Long("room") => drop(parser.value()?),
            Long("type") => type_name = Some(parser.value()?.string()?),
            Short('h') | Long("help") => return Ok(Parsed::Print(HELP.to_owned())),
            Short('V') | Long("version") => {
                return Ok(Parsed::Print(format!(
                    "rts-manager {}\n",
                    env!("CARGO_PKG_VERSION")
                )));
            }
            other => return Err(other.unexpected().into()),
        }
    }
    if zygote {
        return Ok(Parsed::Zygote(home));
    }
    if let Some(module) = module {
        let type_name = type_name.ok_or(UsageError::Missing("--type"))?;
        return Ok(Parsed::Describe(module, type_name));
    }
    let system = match (system_name, system_uid) {
        (Some(name), Some(uid)) => Some(SystemId { name, uid }),
        (None, None) => None,
        (Some(_), None) => return Err(UsageError::Missing("--system-uid")),
        (None, Some(_)) => return Err(UsageError::Missing("--system-name")),
    };
    Ok(Parsed::Run(Settings {
        dir: dir.ok_or(UsageError::Missing("--dir"))?,
        name: name.ok_or(UsageError::Missing("--name"))?,
        system,
        incarnation: incarnation.unwrap_or_else(|| uuid::Uuid::new_v4().to_string()),
        cgroup: None,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(line: &str) -> Result<Settings, String> {
        match parse(line.split_whitespace().map(OsString::from)) {
            Ok(Parsed::Run(settings)) => Ok(settings),
            Ok(Parsed::Print(text)) => Err(text),
            Ok(Parsed::Describe(file, name)) => Err(format!("{} of {}", name, file.display())),
            Ok(Parsed::Zygote(home)) => Err(format!("zygote of {}", home.display())),
            Err(error) => Err(error.to_string()),
        }
    }

    #[test]
    fn all_options_are_read() {
        let read = settings(
            "--dir /tmp/x --name main --system-name hello --system-uid u1 --incarnation i1",
        )
        .unwrap();
        assert_eq!(read.dir, PathBuf::from("/tmp/x"));
        assert_eq!(read.system.as_ref().unwrap().uid, "u1");
        assert_eq!(read.incarnation, "i1");
        assert_eq!(parse(read.words()).ok().map(again), Some(read));
    }

    fn again(parsed: Parsed) -> Settings {
        match parsed {
            Parsed::Run(settings) => settings,
            _ => panic!("other words"),
        }
    }

    #[test]
    fn a_zygote_knows_its_home_and_has_room() {
        let read = settings("--zygote --home /tmp/h --room xxxx");
        assert_eq!(read.err().unwrap(), "zygote of /tmp/h");
    }

    #[test]
    fn what_is_missing_is_named() {
        assert_eq!(settings("--name x").err().unwrap(), "--dir is missing");
        assert_eq!(
            settings("--dir /x --name x --system-name s").err().unwrap(),
            "--system-uid is missing"
        );
        assert_eq!(
            settings("--describe libx.so").err().unwrap(),
            "--type is missing"
        );
        assert_eq!(
            settings("--type X --describe libx.so").err().unwrap(),
            "X of libx.so"
        );
        assert!(settings("--what").err().unwrap().contains("--what"));
        assert!(settings("--help").err().unwrap().contains("Usage"));
    }
}
