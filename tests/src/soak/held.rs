//! What a process holds: memory, descriptors, mappings, threads.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::time::Duration;

use rts_manager_api::client::Client;

use crate::Stack;

/// A manager answers within this time.
const LIMIT: Duration = Duration::from_secs(5);

/// What one process holds at a calm moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Held {
    /// KiB of memory that no other process shares.
    pub memory: u64,
    /// Open descriptors.
    pub descriptors: u64,
    /// Lines of its memory map.
    pub mappings: u64,
    /// Threads.
    pub threads: u64,
}

/// By (program, pid).
pub type Snapshot = BTreeMap<(String, u32), Held>;

/// A pool, a cache or the heap may hold so much more than before; of memory also half of what was held, as caches fill
/// slowly on a busy machine.
const SLACK: Held = Held {
    memory: 4 * 1024,
    descriptors: 8,
    mappings: 24,
    threads: 8,
};

/// All processes of a stack.
pub fn all(stack: &Stack) -> Snapshot {
    let programs = ["rts-controller", "rts-agent", "rts-manager"];
    let of = |program: &str| {
        let pids = stack.daemons(program).into_iter();
        let program = program.to_owned();
        pids.filter_map(move |pid| Some(((program.clone(), pid), held(pid)?)))
            .collect::<Vec<_>>()
    };
    programs.iter().flat_map(|program| of(program)).collect()
}

/// None when it has ended meanwhile.
fn held(pid: u32) -> Option<Held> {
    let count = |what: &str| Some(fs::read_dir(format!("/proc/{pid}/{what}")).ok()?.count() as u64);
    let maps = fs::read_to_string(format!("/proc/{pid}/maps")).ok()?;
    let rollup = fs::read_to_string(format!("/proc/{pid}/smaps_rollup")).ok()?;
    let own = rollup.lines().filter(|l| l.starts_with("Private_"));
    let kib = own.filter_map(|l| l.split_whitespace().nth(1)?.parse::<u64>().ok());
    Some(Held {
        memory: kib.sum(),
        descriptors: count("fd")?,
        mappings: maps.lines().count() as u64,
        threads: count("task")?,
    })
}

/// What processes held at calm moments.
#[derive(Debug)]
pub struct Growth {
    /// Those that were there at the begin. What is made later still fills its pools and caches.
    begin: Snapshot,
    first: Option<Snapshot>,
    last: Snapshot,
}

impl Growth {
    /// Of these processes.
    pub fn of(begin: Snapshot) -> Self {
        Self {
            begin,
            first: None,
            last: Snapshot::new(),
        }
    }

    /// The moment that others are compared with.
    pub fn set_first(&mut self, now: Snapshot) {
        self.first = Some(now);
    }

    /// The newest moment.
    pub fn set_last(&mut self, now: Snapshot) {
        self.last = now;
    }

    /// First and last look at each process that has lived through all.
    fn pairs(&self) -> Vec<(&(String, u32), Held, Held)> {
        let old = self.first.iter().flatten();
        let old = old.filter(|(process, _)| self.begin.contains_key(process));
        old.filter_map(|(process, then)| Some((process, *then, *self.last.get(process)?)))
            .collect()
    }

    /// What has grown beyond the slack; also that there was nothing to compare.
    pub fn grown(&self) -> Vec<String> {
        let pairs = self.pairs();
        let mut found = Vec::new();
        for daemon in ["rts-controller", "rts-agent", "rts-manager"] {
            if !pairs.iter().any(|(process, ..)| process.0 == daemon) {
                found.push(format!("no {daemon} has lived through two measurements"));
            }
        }
        for ((program, pid), then, now) in pairs {
            let parts = [
                (
                    "KiB of memory",
                    then.memory,
                    now.memory,
                    SLACK.memory + then.memory / 2,
                ),
                (
                    "descriptors",
                    then.descriptors,
                    now.descriptors,
                    SLACK.descriptors,
                ),
                ("mappings", then.mappings, now.mappings, SLACK.mappings),
                ("threads", then.threads, now.threads, SLACK.threads),
            ];
            for (what, then, now, slack) in parts {
                if now > then + slack {
                    found.push(format!("{program} (pid {pid}) from {then} to {now} {what}"));
                }
            }
        }
        found
    }

    /// For people.
    pub fn table(&self) -> String {
        let mut text = format!(
            "{:<16} {:>8} {:>15} {:>13} {:>11} {:>9}\n",
            "PROCESS", "PID", "MEMORY KiB", "DESCRIPTORS", "MAPPINGS", "THREADS"
        );
        for ((program, pid), then, now) in self.pairs() {
            let change = |then: u64, now: u64| format!("{then} -> {now}");
            let _ = writeln!(
                text,
                "{program:<16} {pid:>8} {:>15} {:>13} {:>11} {:>9}",
                change(then.memory, now.memory),
                change(then.descriptors, now.descriptors),
                change(then.mappings, now.mappings),
                change(then.threads, now.threads),
            );
        }
        text
    }
}

/// Connections to every manager, which nobody closes.
pub fn leak_into(stack: &Stack) -> Vec<Client> {
    let sockets = stack.sockets();
    let many = sockets.iter().flat_map(|socket| [socket; 20]);
    many.filter_map(|socket| Client::connect(socket, LIMIT).ok())
        .collect()
}
