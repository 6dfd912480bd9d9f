//! Whatever was started is gone in the end, however often.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rts_tests::{Stack, processes_of, soak};

const HELLO: &str = "manifests/hello/system.xml";
const CYCLES: usize = 100;

/// All files, sockets and folders below a folder.
fn below(folder: &Path, found: &mut BTreeSet<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            below(&path, found);
        }
        found.insert(path);
    }
}

fn files(folder: &Path) -> BTreeSet<PathBuf> {
    let mut found = BTreeSet::new();
    below(folder, &mut found);
    found
}

/// Unix sockets of this stack that some process still has open.
fn sockets(stack: &Stack) -> Vec<String> {
    let home = stack.home().display().to_string();
    let text = std::fs::read_to_string("/proc/net/unix").expect("/proc/net/unix");
    let own = text.lines().filter(|line| line.contains(&home));
    own.map(str::to_owned).collect()
}

#[test]
fn a_hundred_cycles_leave_nothing() {
    let stack = Stack::new();
    let shm = files(Path::new("/dev/shm"));
    let mut first = BTreeSet::new();
    for cycle in 1..=CYCLES {
        stack.expect(0, &["up"]);
        stack.expect(0, &["apply", HELLO]);
        stack.expect(0, &["teardown", "hello", "--yes"]);
        stack.expect(0, &["down", "--yes"]);
        let left = processes_of(&stack.home());
        assert!(left.is_empty(), "cycle {cycle}: {left:?}");
        let now = files(&stack.home());
        if cycle == 1 {
            first = now;
        } else {
            let more: Vec<_> = now.difference(&first).collect();
            assert!(more.is_empty(), "cycle {cycle} left {more:?}");
        }
    }
    assert_eq!(sockets(&stack), Vec::<String>::new());
    let more: Vec<_> = files(Path::new("/dev/shm"))
        .difference(&shm)
        .cloned()
        .collect();
    assert!(more.is_empty(), "{more:?}");
    stack.leaves_nothing();
}

/// Open descriptors and threads of a process.
fn held_by(pid: u32) -> (usize, usize) {
    let count = |what: &str| {
        let entries = std::fs::read_dir(format!("/proc/{pid}/{what}"));
        entries.map_or(0, |entries| entries.flatten().count())
    };
    (count("fd"), count("task"))
}

#[test]
fn daemons_that_live_on_hold_no_more_than_before() {
    let stack = Stack::new();
    stack.expect(0, &["up"]);
    let cycle = || {
        stack.expect(0, &["apply", HELLO]);
        stack.expect(0, &["teardown", "hello", "--yes"]);
    };
    // Pools and caches are filled by then.
    (0..5).for_each(|_| cycle());
    let daemon = |name: &str| {
        let pids = stack.daemons(name);
        assert_eq!(pids.len(), 1, "{name}: {pids:?}");
        pids[0]
    };
    let pids = [daemon("rts-controller"), daemon("rts-agent")];
    let calm = |limits: &[(usize, usize); 2]| {
        let deadline = Instant::now() + Duration::from_secs(10);
        loop {
            let now = pids.map(held_by);
            let fits = now
                .iter()
                .zip(limits)
                .all(|(n, l)| n.0 <= l.0 && n.1 <= l.1);
            if fits || Instant::now() > deadline {
                return now;
            }
            std::thread::sleep(Duration::from_millis(100));
        }
    };
    std::thread::sleep(Duration::from_millis(500));
    let before = pids.map(held_by);
    (0..40).for_each(|_| cycle());
    // A few connections and threads of pools come and go; one that leaks in each cycle makes forty.
    let limits = before.map(|(fds, threads)| (fds + 8, threads + 8));
    let after = calm(&limits);
    for ((name, limit), now) in ["controller", "agent"].iter().zip(limits).zip(after) {
        assert!(
            now.0 <= limit.0 && now.1 <= limit.1,
            "{name}: (descriptors, threads) {now:?}, before {before:?}"
        );
    }
    stack.leaves_nothing();
}

#[test]
fn a_large_system_that_is_changed_all_the_time_does_not_grow() {
    let options = soak::Options {
        time: Duration::from_secs(20),
        seed: 1,
        components: 100,
        leak: false,
    };
    match soak::run(&options) {
        Ok(report) => println!("{report}"),
        Err(problem) => panic!("{problem}"),
    }
}
