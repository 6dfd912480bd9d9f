//! What `down` did, in words.

use crate::local::plural;

/// What was stopped.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Stopped {
    /// The controller.
    pub controller: bool,
    /// Relays, by node.
    pub relays: Vec<String>,
    /// Agents, by node.
    pub agents: Vec<String>,
    /// Managers, by display name.
    pub managers: Vec<String>,
    /// What had to be killed.
    pub killed: Vec<String>,
    /// What would not stop, and why.
    pub left: Vec<String>,
}

impl Stopped {
    /// `stopped the controller, 1 agent and 2 managers`.
    pub fn words(&self) -> String {
        let mut parts = Vec::new();
        if self.controller {
            parts.push("the controller".to_owned());
        }
        if !self.relays.is_empty() {
            parts.push(plural("SSH relay", self.relays.len()));
        }
        if !self.agents.is_empty() {
            parts.push(plural("agent", self.agents.len()));
        }
        if !self.managers.is_empty() {
            let (count, names) = (self.managers.len(), self.managers.join(", "));
            parts.push(format!("{} ({names})", plural("manager", count)));
        }
        match parts.split_last() {
            None if self.killed.is_empty() => "nothing was running".to_owned(),
            None => "stopped what dead managers had started".to_owned(),
            Some((last, [])) => format!("stopped {last}"),
            Some((last, rest)) => format!("stopped {} and {last}", rest.join(", ")),
        }
    }

    /// `killed by force: manager hello.main (pid 4711)`; none when all went in order.
    pub fn force(&self) -> Option<String> {
        (!self.killed.is_empty()).then(|| format!("killed by force: {}", self.killed.join(", ")))
    }
}
