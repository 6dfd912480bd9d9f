//! What `ssh` says on its standard error, bounded: its words for people, and what its debug lines tell of the server.

use std::collections::VecDeque;

use crate::answer::tame;

/// Lines for people that are kept; of more, the oldest go.
const MAX_LINES: usize = 40;
/// Offered keys that are kept.
const MAX_OFFERED: usize = 20;
/// Beginnings of what it says of every session.
const USUAL: [&str; 3] = ["Authenticated to ", "Transferred: ", "Bytes per second: "];

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
    /// Somebody was let in, and the command was sent.
    pub sent: bool,
    /// What was run instead of it, or it itself, has come to its end.
    pub ran: bool,
    /// The entry of the server's file of keys that forces a command (`/home/pi/.ssh/authorized_keys:1`).
    pub forced: Option<String>,
}

impl Log {
    /// Takes in one line.
    pub fn add(&mut self, line: &str) {
        let line = tame(line);
        let Some(debug) = line.strip_prefix("debug1: ") else {
            let usual = USUAL.iter().any(|usual| line.starts_with(usual));
            if usual || line.is_empty() || line.starts_with("debug") {
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
        } else if debug.starts_with("Sending command: ") {
            self.sent = true;
        } else if debug.contains("rtype exit-status") {
            self.ran = true;
        } else if let Some((place, options)) = told("Remote: ")
            .as_deref()
            .and_then(|told| told.split_once(": key options: "))
        {
            let forces = options.split(' ').any(|option| option == "command");
            self.forced = forces.then(|| place.to_owned());
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
