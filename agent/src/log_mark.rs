//! A line in a log where a new incarnation begins: logs are appended to, and readers must see where one life ends.

use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::Path;

use rts_manager_api::control::CreateRequest;

use crate::agent::Agent;
use crate::events::lock;
use crate::managers::Manager;

/// Appends the line, unless the log is new.
pub(crate) fn mark(log: &Path, who: &str) -> io::Result<()> {
    let mut file = match OpenOptions::new().append(true).open(log) {
        Ok(file) => file,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(e) => return Err(e),
    };
    if file.metadata()?.len() == 0 {
        return Ok(());
    }
    let line = format!(
        "{:.3} INFO --- a new incarnation of {} begins here ---\n",
        jiff::Timestamp::now(),
        who.escape_debug()
    );
    file.write_all(line.as_bytes())
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
        let (log, instance) = (request.log_path.clone(), request.instance.clone());
        let marked = tokio::task::spawn_blocking(move || mark(log.as_ref(), &instance)).await;
        if let Err(e) = marked.map_err(io::Error::other).flatten() {
            // A full disk must not stop a robot.
            tracing::warn!("cannot mark the log {}: {e}", request.log_path);
        }
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
    }
}
