//! What a process uses of its machine, as `/proc` tells it.

use std::sync::OnceLock;
use std::time::Duration;

use crate::identity::{Identity, stat_fields};

/// `USER_HZ`: ticks of a second in `/proc`, whatever the kernel's own are.
const TICKS: u64 = 100;
/// `AT_PAGESZ`.
const PAGE_SIZE: u64 = 6;

/// What a process uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Usage {
    /// Processor time of all its threads, since it began.
    pub cpu: Duration,
    /// Memory that is resident, in bytes.
    pub memory: u64,
}

/// Of this very process; none when it has ended.
pub fn usage(identity: &Identity) -> Option<Usage> {
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", identity.pid)).ok()?;
    let (start, usage) = parse(&stat, page_size()?)?;
    (start == identity.start_ticks).then_some(usage)
}

/// When it started, and what it uses.
fn parse(stat: &str, page: u64) -> Option<(u64, Usage)> {
    let fields: Vec<u64> = stat_fields(stat)?
        .map(|field| field.parse().unwrap_or_default())
        .collect();
    let ticks = fields.get(11)?.checked_add(*fields.get(12)?)?;
    let usage = Usage {
        cpu: Duration::from_millis(ticks.checked_mul(1000 / TICKS)?),
        memory: fields.get(21)?.checked_mul(page)?,
    };
    Some((*fields.get(19)?, usage))
}

/// Bytes of a page of memory.
fn page_size() -> Option<u64> {
    static SIZE: OnceLock<Option<u64>> = OnceLock::new();
    *SIZE.get_or_init(|| {
        let vector = std::fs::read("/proc/self/auxv").ok()?;
        let words: Vec<u64> = vector
            .chunks_exact(size_of::<usize>())
            .filter_map(|word| Some(usize::from_ne_bytes(word.try_into().ok()?) as u64))
            .collect();
        let mut pairs = words.chunks_exact(2);
        pairs.find(|pair| pair[0] == PAGE_SIZE).map(|pair| pair[1])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_pages_are_read_behind_any_name() {
        let stat = "7 (a) b) S 1 7 7 0 -1 4194560 1 0 0 0 120 30 0 0 20 0 1 0 4711 8000 9 1844";
        let usage = Usage {
            cpu: Duration::from_millis(1500),
            memory: 9 * 4096,
        };
        assert_eq!(parse(stat, 4096), Some((4711, usage)));
        assert_eq!(parse("7 (a) S 1", 4096), None);
    }

    #[test]
    fn it_is_that_of_the_very_process() {
        let own = Identity::own("").unwrap();
        assert!(usage(&own).unwrap().memory > 4096);
        let other = Identity {
            start_ticks: own.start_ticks + 1,
            ..own
        };
        assert_eq!(usage(&other), None);
    }
}
