//! What is there of a service, as the far side tells it, which is not trusted.

use serde::{Deserialize, Serialize};

use super::service::Keeper;
use crate::answer::tame;

/// Longest answer that is looked at in bytes.
const MAX_ANSWER: usize = 1024 * 1024;
/// Most managers.
const MAX_MANY: usize = 10_000;

/// What an installation remembers of itself: `services/<node>.json`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Record {
    /// Node.
    pub node: String,
    /// Who keeps it running.
    pub keeper: Keeper,
    /// The command of the agent.
    pub command: Vec<String>,
    /// Digests of programs that it needs.
    pub programs: Vec<String>,
    /// Digests and names of modules, in the order of the module path.
    pub modules: Vec<(String, String)>,
    /// Services run while nobody is logged in because of this one.
    #[serde(default)]
    pub lingers: bool,
}

impl Record {
    /// All digests that it needs.
    pub fn digests(&self) -> impl Iterator<Item = &str> {
        let modules = self.modules.iter().map(|(digest, _)| digest);
        self.programs.iter().chain(modules).map(String::as_str)
    }

    /// Names that are those of files of ours, so that no path of the far side leads anywhere else.
    fn is_sound(&self) -> bool {
        let digest = |text: &str| text.len() == 64 && text.bytes().all(|b| b.is_ascii_hexdigit());
        let name = |text: &str| {
            !text.is_empty() && !text.starts_with('.') && !text.contains(['/', '\n', ':'])
        };
        self.digests().all(digest) && self.modules.iter().all(|(_, file)| name(file))
    }
}

/// What is there.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Found {
    /// What an installation remembers.
    pub record: Option<Record>,
    /// There are installations of other nodes.
    pub others: bool,
    /// Text of the file that starts it.
    pub file: Option<String>,
    /// Process and program of the agent that runs.
    pub agent: Option<(u32, String)>,
    /// The agent serves.
    pub serves: bool,
    /// Processes of managers that run.
    pub managers: Vec<u32>,
}

impl Found {
    /// The answer of the script.
    pub fn parse(answer: &[u8]) -> Result<Self, String> {
        let answer = answer.get(..MAX_ANSWER).unwrap_or(answer);
        let text = String::from_utf8_lossy(answer);
        let mut found = Self::default();
        let mut whole = false;
        for line in text.lines() {
            let (word, value) = line.split_once(' ').unwrap_or((line, ""));
            match word {
                "record" => found.record = record(value),
                "other" => found.others = true,
                "file" => {
                    let file = found.file.get_or_insert_default();
                    file.push_str(value);
                    file.push('\n');
                }
                "agent" => found.agent = agent(value),
                "serves" => found.serves = true,
                "manager" if found.managers.len() < MAX_MANY => {
                    found.managers.extend(number(value));
                }
                "end" => whole = true,
                _ => {}
            }
        }
        match whole {
            true => Ok(found),
            false => Err("it does not come to its end".to_owned()),
        }
    }

    /// The agent that runs is of this program.
    pub fn runs(&self, program: &str) -> bool {
        self.agent
            .as_ref()
            .is_some_and(|(_, running)| running == program)
    }
}

fn record(text: &str) -> Option<Record> {
    serde_json::from_str(text).ok().filter(Record::is_sound)
}

fn agent(text: &str) -> Option<(u32, String)> {
    let (pid, program) = text.split_once(' ')?;
    let program = tame(program);
    // What was replaced on disk is marked by the kernel.
    let program = program.strip_suffix(" (deleted)").unwrap_or(&program);
    Some((number(pid)?, program.to_owned()))
}

/// The number of a process; 0, 1 and what is none are nobody.
fn number(text: &str) -> Option<u32> {
    text.parse()
        .ok()
        .filter(|pid| (2..=i32::MAX as u32).contains(pid))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(digest: &str) -> String {
        format!(
            r#"{{"node":"arm","keeper":"process","command":["/p"],"programs":["{digest}"],"modules":[["{digest}","libX.so"]]}}"#
        )
    }

    #[test]
    fn what_is_there_is_read() {
        let a = "a".repeat(64);
        let answer = format!(
            "record {}\nother yes\nfile [Unit]\nfile x=1\nagent 77 /h/programs/a/rts-agent (deleted)\nserves yes\nmanager 78\nmanager 1\n\
             agency 3\nend yes\n",
            record(&a)
        );
        let found = Found::parse(answer.as_bytes()).unwrap();
        assert_eq!(
            found.record.as_ref().unwrap().digests().collect::<Vec<_>>(),
            [a.as_str(), &a]
        );
        assert!(found.others);
        assert_eq!(found.file.as_deref(), Some("[Unit]\nx=1\n"));
        assert!(found.runs("/h/programs/a/rts-agent") && found.serves);
        assert_eq!(found.managers, [78]);
    }

    #[test]
    fn nothing_half_and_nothing_strange_is_taken() {
        assert!(Found::parse(b"serves yes\n").is_err());
        assert_eq!(Found::parse(b"end yes").unwrap(), Found::default());
        for strange in [
            record("../../etc"),
            record("").replace("libX", "../X"),
            "{".to_owned(),
        ] {
            let answer = format!("record {strange}\nagent -1 x\nagent x\nend yes\n");
            assert_eq!(
                Found::parse(answer.as_bytes()).unwrap(),
                Found::default(),
                "{strange}"
            );
        }
    }
}
