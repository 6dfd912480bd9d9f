//! A process that is killed while it writes: what it was told to be stored is there.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use rts_controller::store::{NodeGeneration, RedbStore, Write as Change};

/// Set for the run of this program that writes.
const WRITER: &str = "RTSCTL_TEST_WRITER";
const ROUNDS: u64 = 5;

#[test]
fn what_was_acknowledged_outlives_a_kill() {
    if let Ok(path) = std::env::var(WRITER) {
        return write_for_ever(Path::new(&path));
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("controller.redb");
    let mut last = 0;
    for round in 0..ROUNDS {
        let acknowledged = killed(&path, Duration::from_millis(40 + 37 * round));
        assert!(acknowledged > last, "it wrote something");
        let state = RedbStore::open(&path, "u").unwrap().load().unwrap();
        let (a, b) = (&state.nodes["a"], &state.nodes["b"]);
        assert!(a.generation >= acknowledged, "{a:?} < {acknowledged}");
        assert_eq!(a, b, "both rows of a write, or none");
        last = a.generation;
    }
}

/// Lets a child write for a while after its first word, kills it, and gives the last number that it acknowledged.
fn killed(path: &Path, after: Duration) -> u64 {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args([
            "--exact",
            "killed::what_was_acknowledged_outlives_a_kill",
            "--nocapture",
        ])
        .env(WRITER, path)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let mut numbers = lines.map_while(Result::ok).filter_map(|line| {
        let number = line.strip_prefix("stored ")?;
        number.parse::<u64>().ok()
    });
    let first = numbers.next().unwrap();
    std::thread::sleep(after);
    child.kill().unwrap();
    child.wait().unwrap();
    numbers.last().unwrap_or(first)
}

fn write_for_ever(path: &Path) {
    let store = RedbStore::open(path, "u").unwrap();
    let state = store.load().unwrap();
    let mut number = state.nodes.get("a").map_or(0, |a| a.generation);
    println!();
    loop {
        number += 1;
        let generation = NodeGeneration {
            epoch: 1,
            generation: number,
            digest: "x".repeat(200),
        };
        let put = |node: &str| Change::PutNode(node.to_owned(), generation.clone());
        store.write(&[put("a"), put("b")]).unwrap();
        println!("stored {number}");
        std::io::stdout().flush().unwrap();
    }
}
