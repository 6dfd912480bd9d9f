//! A line in a log where a new incarnation begins: logs are appended to, and readers must see where one life ends.

use std::fs::OpenOptions;
use std::io::{self, Write};
use std::os::unix::fs::FileExt;
use std::path::Path;

use rts_manager_api::control::CreateRequest;

use crate::agent::Agent;
use crate::events::lock;
use crate::managers::Manager;

/// What stands before the name.
const BEFORE: &str = "INFO --- a new incarnation of ";
/// What stands behind it.
const BEHIND: &str = " begins here ---";

/// Appends the line, unless the log is new.
pub(crate) fn mark(log: &Path, who: &str) -> io::Result<()> {
    let mut file = match OpenOptions::new().read(true).append(true).open(log) {
        Ok(file) => file,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(e) => return Err(e),
    };
    let length = file.metadata()?.len();
    if length == 0 {
        return Ok(());
    }
    // Who died while it wrote left a line without an end.
    let mut last = [0];
    let torn = file.read_at(&mut last, length - 1)? == 1 && last != *b"\n";
    let line = format!(
        "{}{:.3} {BEFORE}{}{BEHIND}\n",
        if torn { "\n" } else { "" },
        jiff::Timestamp::now(),
        who.escape_debug()
    );
    file.write_all(line.as_bytes())
}

/// True for a line that [`mark`] has written.
pub(crate) fn is_mark(line: &str) -> bool {
    let message = line.split_once(' ').map(|(_, message)| message);
    message.is_some_and(|m| m.starts_with(BEFORE) && m.ends_with(BEHIND))
}

impl Agent {
    /// Marks the log of a component that is about to be made in a manager.
    pub async fn mark_log(&self, manager: &Manager, request: &CreateRequest) {
        let is_there = {
            let seen = lock(&manager.seen);
            let mut components = seen.inventory.components.iter();
            components.any(|c| c.instance == request.instance)
        };
        if is_there {
            return;
        }
        let log = Path::new(&request.log_path);
        self.inputs.machine.mark_log(log, &request.instance).await;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_log_that_has_something_is_marked() {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("x.log");
        mark(&log, "Sine0").unwrap();
        assert!(!log.exists());
        std::fs::write(&log, "old\n").unwrap();
        mark(&log, "Sine0").unwrap();
        let text = std::fs::read_to_string(&log).unwrap();
        let end = " INFO --- a new incarnation of Sine0 begins here ---\n";
        assert!(text.starts_with("old\n2") && text.ends_with(end), "{text}");
        assert!(is_mark(text.lines().nth(1).unwrap()) && !is_mark("old"));
    }

    #[test]
    fn a_mark_stands_on_a_line_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("x.log");
        std::fs::write(&log, "torn").unwrap();
        mark(&log, "a\nb").unwrap();
        let text = std::fs::read_to_string(&log).unwrap();
        assert!(text.starts_with("torn\n2"), "{text}");
        assert!(is_mark(text.lines().nth(1).unwrap()), "{text}");
    }
}
