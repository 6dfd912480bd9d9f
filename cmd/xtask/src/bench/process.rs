//! What processes hold and use, as the kernel says.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::Duration;

use anyhow::{Context, Result};
use serde::Serialize;
use serde_json::Value;

/// Memory of a process, or of several together.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Memory {
    /// Proportional set size: what it shares with others counts in parts. Bytes.
    pub pss: u64,
    /// Resident set size, shared or not. Bytes.
    pub rss: u64,
}

/// Memory of a process.
pub fn memory(pid: u32) -> Result<Memory> {
    let file = format!("/proc/{pid}/smaps_rollup");
    let text = fs::read_to_string(&file).with_context(|| format!("cannot read {file}"))?;
    let field = |name: &str| {
        let line = text.lines().find(|line| line.starts_with(name));
        let kib = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<u64>().ok());
        let kib = kib.with_context(|| format!("{file} has no {name}"))?;
        Ok::<_, anyhow::Error>(kib * 1024)
    };
    Ok(Memory {
        pss: field("Pss:")?,
        rss: field("Rss:")?,
    })
}

/// Memory of several processes; those that have ended meanwhile have none.
pub fn memory_of(pids: &[u32]) -> Memory {
    let each = pids.iter().filter_map(|pid| memory(*pid).ok());
    each.fold(Memory::default(), |sum, one| Memory {
        pss: sum.pss + one.pss,
        rss: sum.rss + one.rss,
    })
}

/// Processor time that the threads of a process that are still there have used.
pub fn cpu(pid: u32) -> Result<Duration> {
    let file = format!("/proc/{pid}/task");
    let tasks = fs::read_dir(&file).with_context(|| format!("cannot read {file}"))?;
    let mut nanoseconds = 0;
    for task in tasks {
        // A thread may end between the listing and the reading.
        let text = fs::read_to_string(task?.path().join("schedstat")).unwrap_or_default();
        let first = text.split_whitespace().next();
        nanoseconds += first.and_then(|n| n.parse::<u64>().ok()).unwrap_or(0);
    }
    Ok(Duration::from_nanos(nanoseconds))
}

/// The same of several; those that have ended meanwhile have none.
pub fn cpu_of(pids: &[u32]) -> Duration {
    pids.iter().filter_map(|pid| cpu(*pid).ok()).sum()
}

/// Number of threads of several processes.
pub fn threads_of(pids: &[u32]) -> usize {
    let of = |pid: &u32| fs::read_dir(format!("/proc/{pid}/task")).map_or(0, Iterator::count);
    pids.iter().map(of).sum()
}

/// The process that a file of the home (`run/controller.json`, …) names.
pub fn named_in(file: &Path) -> Result<u32> {
    let text = fs::read(file).with_context(|| format!("cannot read {}", file.display()))?;
    let value: Value = serde_json::from_slice(&text)?;
    let pid = value["pid"].as_u64().and_then(|pid| pid.try_into().ok());
    pid.with_context(|| format!("{} names no process", file.display()))
}

/// Managers that hold a run folder of a node.
pub fn managers(home: &Path, node: &str) -> Vec<u32> {
    let folders = fs::read_dir(home.join("run").join(node))
        .into_iter()
        .flatten();
    let files = folders.flatten().map(|e| e.path().join("manager.json"));
    files.filter_map(|file| named_in(&file).ok()).collect()
}

/// Processes that a process has started, and those that they have.
pub fn below(pid: u32) -> Vec<u32> {
    let parents = parents();
    let mut found = vec![pid];
    let mut next = 0;
    while let Some(parent) = found.get(next).copied() {
        let children = parents.iter().filter(|(_, of)| **of == parent);
        found.extend(children.map(|(child, _)| *child));
        next += 1;
    }
    found.split_off(1)
}

/// Process → its parent.
fn parents() -> BTreeMap<u32, u32> {
    let entries = fs::read_dir("/proc").into_iter().flatten().flatten();
    let parent = |pid: u32| {
        let text = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        // The name, in parentheses, may have anything in it.
        let after = text.rsplit_once(')')?.1;
        Some((pid, after.split_whitespace().nth(1)?.parse().ok()?))
    };
    let pids = entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    pids.filter_map(parent).collect()
}

#[cfg(test)]
mod tests {
    use std::process::{Command, Stdio};

    use super::*;

    #[test]
    fn a_process_says_what_it_holds_and_who_its_children_are() {
        let own = std::process::id();
        let memory = memory(own).unwrap();
        assert!(memory.pss > 0 && memory.rss >= memory.pss);
        assert!(cpu(own).unwrap() > Duration::ZERO);
        assert!(threads_of(&[own]) >= 1);
        let mut child = Command::new("cat").stdin(Stdio::piped()).spawn().unwrap();
        assert!(below(own).contains(&child.id()));
        drop(child.stdin.take());
        child.wait().unwrap();
        assert!(!below(own).contains(&child.id()));
    }

    #[test]
    fn a_process_that_is_not_there_holds_nothing() {
        assert!(memory(u32::MAX).is_err() && cpu(u32::MAX).is_err());
        assert_eq!(memory_of(&[u32::MAX]), Memory::default());
    }
}
