//! What is left of connections that have ended.

use std::thread;
use std::time::{Duration, Instant};

use rts_transport::{Kind, Parting};

use crate::child::start;
use crate::ends::{PATIENCE, end, fill, next, pair, sample};

/// Counted in a process of its own, as other tests run beside this one.
pub fn no_descriptor_no_mapping_and_no_thread_is_left(kind: Kind) {
    assert!(start("leak", kind, None).wait().unwrap().success());
}

fn count(folder: &str) -> usize {
    std::fs::read_dir(folder).unwrap().count()
}

/// Descriptors, threads, and mappings of memory that is shared with others.
fn counts() -> (usize, usize, usize) {
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap();
    let shared = |line: &&str| {
        line.split_whitespace()
            .nth(1)
            .is_some_and(|p| p.ends_with('s'))
    };
    (
        count("/proc/self/fd"),
        count("/proc/self/task"),
        maps.lines().filter(shared).count(),
    )
}

/// Makes connections and ends them in every way.
pub fn measure(kind: Kind) {
    let before = counts();
    for _ in 0..20 {
        connect(kind);
    }
    // The last thread of a connection may still be on its way out.
    let begin = Instant::now();
    while counts() != before {
        assert!(
            begin.elapsed() < PATIENCE,
            "{before:?} became {:?}",
            counts()
        );
        thread::sleep(Duration::from_millis(5));
    }
}

fn connect(kind: Kind) {
    // In order, also while a rest waits for room.
    for size in [10, 2 << 20] {
        let (mut sender, mut receiver) = pair(kind);
        sender.push(sample(1, size)).unwrap();
        next(&mut *receiver);
        sender.push(sample(2, size)).unwrap();
        sender.close(Parting::GoodBye);
        end(&mut *receiver);
    }
    // Lost, from both sides.
    let (mut sender, receiver) = pair(kind);
    fill(&mut *sender, 100_000);
    drop(receiver);
    drop(sender);
    let (mut sender, receiver) = pair(kind);
    fill(&mut *sender, 100_000);
    drop(sender);
    drop(receiver);
    // One who waits for a receiver that never comes.
    let (mut sender, _receiver) = pair(kind);
    fill(&mut *sender, 1 << 20);
    sender.close(Parting::GoodBye);
}
