//! What kind of machine is on the far side: one command there, and its answer, which is not trusted.

use std::path::Path;

use crate::answer::tame;
use crate::error::SshError;
use crate::machine::{common_name, machine_of};

/// Longest answer that is looked at, in bytes.
pub const MAX_SURVEY: usize = 64 * 1024;
/// Longest value in bytes.
const MAX_VALUE: usize = 4096;

const SCRIPT: &str = include_str!("survey.sh");

/// What can keep a program running there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Systemd {
    /// No systemd.
    Absent,
    /// It runs, but has no services of this account.
    System,
    /// It runs, with services of this account too.
    User,
}

/// The far side, by what it says itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Survey {
    /// `uname -s`.
    pub kernel: String,
    /// `uname -r`.
    pub release: String,
    /// `uname -m`.
    pub machine: String,
    /// `uname -n`.
    pub node: String,
    /// Bits of a `long` of programs there, where that is known.
    pub bits: Option<u32>,
    /// C library and its version, as far as known (`glibc 2.36`).
    pub libc: String,
    /// `HOME`; absolute.
    pub home: String,
    /// `XDG_STATE_HOME` where it is set; absolute.
    pub state: Option<String>,
    /// `XDG_CONFIG_HOME` where it is set; absolute.
    pub config: Option<String>,
    /// Name of the account.
    pub user: String,
    /// Its number.
    pub uid: u32,
    /// What keeps services.
    pub systemd: Systemd,
    /// Services of this account run while nobody is logged in.
    pub linger: bool,
    /// There is a `sha256sum`.
    pub sha256sum: bool,
    /// Free bytes where the account keeps its state, as far as known.
    pub free: Option<u64>,
}

impl Survey {
    /// The answer of the script, as far as it goes.
    pub fn parse(answer: &[u8]) -> Result<Self, String> {
        let answer = answer.get(..MAX_SURVEY).unwrap_or(answer);
        let text = String::from_utf8_lossy(answer);
        let value = |key: &str| {
            let mut lines = text.lines().filter_map(|line| line.split_once('='));
            let (_, value) = lines.find(|(known, _)| *known == key)?;
            let value = tame(value);
            (!value.is_empty() && value.len() <= MAX_VALUE).then_some(value)
        };
        let needed = |key: &str| value(key).ok_or_else(|| format!("it does not say its {key}"));
        let folder = |key: &str| value(key).filter(|path| is_folder(path));
        if value("end").is_none() {
            return Err("it does not come to its end".to_owned());
        }
        Ok(Self {
            kernel: needed("kernel")?,
            release: value("release").unwrap_or_default(),
            machine: needed("machine")?,
            node: value("node").unwrap_or_default(),
            bits: value("bits").and_then(|bits| bits.parse().ok()),
            libc: value("libc").unwrap_or_default(),
            home: folder("home").ok_or("its HOME is no absolute path")?,
            state: folder("state"),
            config: folder("config"),
            user: value("user").unwrap_or_default(),
            uid: needed("uid")?.parse().map_err(|_| "its uid is no number")?,
            systemd: match (value("systemd"), value("services")) {
                (None, _) => Systemd::Absent,
                (Some(_), None) => Systemd::System,
                (Some(_), Some(_)) => Systemd::User,
            },
            linger: value("linger").is_some(),
            sha256sum: value("sha256sum").is_some(),
            free: value("free").and_then(|free| free.parse::<u64>().ok()?.checked_mul(1024)),
        })
    }

    /// Folder of rtsctl there: `$XDG_STATE_HOME/rtsctl`.
    pub fn rtsctl_home(&self) -> String {
        let state = || format!("{}/.local/state", self.home.trim_end_matches('/'));
        let state = self.state.clone().unwrap_or_else(state);
        format!("{}/rtsctl", state.trim_end_matches('/'))
    }

    /// The machine by the name that [`machine_of`] has for programs.
    pub fn machine_name(&self) -> String {
        common_name(&self.machine, self.bits)
    }

    /// Refuses a program or module of another kind of machine.
    pub fn check_machine(&self, host: &str, file: &Path) -> Result<(), SshError> {
        let read = |source| SshError::Read {
            path: file.to_owned(),
            source,
        };
        let there = self.machine_name();
        match machine_of(file).map_err(read)? {
            Some(here) if here != there || self.kernel != "Linux" => Err(SshError::WrongMachine {
                host: host.to_owned(),
                file: file.to_owned(),
                here: format!("Linux on {here}"),
                there: format!("{} on {there}", self.kernel),
            }),
            _ => Ok(()),
        }
    }
}

/// A path that starts at the root, and in which nothing goes up again.
fn is_folder(path: &str) -> bool {
    path.starts_with('/') && path.split('/').all(|part| part != "..")
}

/// Asks.
#[cfg(feature = "session")]
pub(crate) async fn survey(session: &crate::Session) -> Result<Survey, SshError> {
    let what = "what kind of machine it is";
    let ran = session.run(what, SCRIPT, &[]).await?;
    Survey::parse(&ran.out).map_err(|reason| SshError::Answer {
        host: session.host().to_owned(),
        what: what.to_owned(),
        said: [reason, ran.err].join(" ").trim_end().to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ANSWER: &str = "kernel=Linux\nrelease=6.1\nmachine=aarch64\nnode=arm7\nbits=64\nlibc=glibc 2.36\nhome=/home/pi\nstate=\n\
                          uid=1000\nuser=pi\nsystemd=system\nservices=user\nsha256sum=yes\nfree=1024\nend=yes\n";

    #[test]
    fn an_answer_is_read() {
        let survey = Survey::parse(ANSWER.as_bytes()).unwrap();
        assert_eq!(survey.rtsctl_home(), "/home/pi/.local/state/rtsctl");
        assert_eq!(
            (survey.machine_name().as_str(), survey.uid),
            ("aarch64", 1000)
        );
        assert_eq!((survey.systemd, survey.linger), (Systemd::User, false));
        assert_eq!((survey.free, survey.sha256sum), (Some(1 << 20), true));
        let state = ANSWER.replace("state=", "state=/data/");
        let survey = Survey::parse(state.as_bytes()).unwrap();
        assert_eq!(survey.rtsctl_home(), "/data/rtsctl");
    }

    #[test]
    fn half_an_answer_and_strange_folders_are_refused() {
        let whole = ANSWER.len() - "end=yes\n".len();
        assert!(Survey::parse(&ANSWER.as_bytes()[..whole]).is_err());
        for home in ["home=pi", "home=/home/../etc", "home=", "homes=/x"] {
            let answer = ANSWER.replace("home=/home/pi", home);
            assert!(Survey::parse(answer.as_bytes()).is_err(), "{home}");
        }
        assert!(Survey::parse(ANSWER.replace("uid=1000", "uid=-1").as_bytes()).is_err());
    }

    #[test]
    fn this_machine_answers_and_runs_this_test() {
        let output = std::process::Command::new("/bin/sh")
            .args(["-c", SCRIPT])
            .output()
            .unwrap();
        let survey = Survey::parse(&output.stdout).unwrap();
        let own = std::env::current_exe().unwrap();
        survey.check_machine("robot", &own).unwrap();
        let other = Survey {
            machine: "mips".to_owned(),
            bits: None,
            ..survey
        };
        let error = other.check_machine("robot", &own).unwrap_err();
        assert!(error.help().unwrap().contains("--programs"), "{error}");
    }
}
