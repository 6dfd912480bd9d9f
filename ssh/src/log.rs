//! What `ssh` says on its standard error, bounded: its words for people, and what its debug lines tell of the server.

use std::collections::VecDeque;

use crate::answer::tame;

/// Lines for people that are kept; of more, the oldest go.
const MAX_LINES: usize = 40;
/// Offered keys that are kept.
const MAX_OFFERED: usize = 20;

/// What was said so far.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Log {
    lines: VecDeque<String>,
    /// Type and fingerprint of the server's key (`ssh-ed25519 SHA256:…`).
    pub host_key: Option<String>,
    /// Keys that were offered, as `ssh` names them.
    pub offered: Vec<String>,
    /// Ways to log in that the server has (`publickey,password`).
    pub methods: Option<String>,
    /// Whom `ssh` logged in as, where (`127.0.0.1:22 as 'pi'`).
    pub target: Option<String>,
}

impl Log {
    /// Takes in one line.
    pub fn add(&mut self, line: &str) {
        let line = tame(line);
        let Some(debug) = line.strip_prefix("debug1: ") else {
            if line.is_empty() || line.starts_with("debug") {
                return;
            }
            if self.lines.len() >= MAX_LINES {
                self.lines.pop_front();
            }
            self.lines.push_back(line);
            return;
        };
        let told = |prefix: &str| debug.strip_prefix(prefix).map(str::to_owned);
        if let Some(key) = told("Server host key: ") {
            self.host_key = Some(key);
        } else if let Some(methods) = told("Authentications that can continue: ") {
            self.methods = Some(methods);
        } else if let Some(target) = told("Authenticating to ") {
            self.target = Some(target);
        } else if let Some(key) = told("Offering public key: ")
            && self.offered.len() < MAX_OFFERED
        {
            self.offered.push(key);
        }
    }

    /// The lines for people.
    pub fn lines(&self) -> impl Iterator<Item = &str> {
        self.lines.iter().map(String::as_str)
    }

    /// True when a line has these words.
    pub fn has(&self, words: &str) -> bool {
        self.lines().any(|line| line.contains(words))
    }

    /// All that it said to people, in one line.
    pub fn text(&self) -> String {
        self.lines.iter().cloned().collect::<Vec<_>>().join("; ")
    }

    /// The last thing that it said to people.
    pub fn last(&self) -> &str {
        self.lines.back().map_or("", String::as_str)
    }
}
