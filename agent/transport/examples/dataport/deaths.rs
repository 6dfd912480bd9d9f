//! How long it takes until the death of the other process is noticed.

use std::thread;
use std::time::{Duration, Instant};

use rts_transport::{Ended, Kind};
use rustix::event::{PollFd, PollFlags, poll};

use crate::link::Link;
use crate::processes::transported;

/// Kills so many processes of each transport between processes, and shows how long both ends took.
pub fn json(kills: u64) -> String {
    let kinds = Kind::ALL.into_iter().filter(|k| *k != Kind::InProcess);
    let shown: Vec<_> = kinds.map(|kind| row(kind, kills)).collect();
    shown.join(",\n")
}

fn row(kind: Kind, kills: u64) -> String {
    let mut all: Vec<_> = (0..kills).map(|kill| noticed(kind, kill)).collect();
    all.sort_by(f64::total_cmp);
    format!(
        "  {{\"row\": \"{kind}\", \"medianMs\": {:.2}, \"mostMs\": {:.2}}}",
        all[all.len() / 2],
        all[all.len() - 1]
    )
}

/// Milliseconds until a receiver that waits, and a thread that watches an idle sender, know of it.
fn noticed(kind: Kind, kill: u64) -> f64 {
    let (mut link, mut child) = transported(kind, 8, 1);
    link.send(0);
    assert!(link.receive(0));
    // At any time of a wait.
    let pause = Duration::from_millis(3 + kill * 17 % 140);
    let killing = thread::spawn(move || {
        thread::sleep(pause);
        let killed = Instant::now();
        child.kill().unwrap();
        child.wait().unwrap();
        killed
    });
    let ended = loop {
        match link.receiver.take(Duration::MAX) {
            Ok(_) => {}
            Err(ended) => break ended,
        }
    };
    assert!(matches!(ended, Ended::Lost(_)), "{ended}");
    while link.sender.ended().is_none() {
        let handle = link.sender.handle();
        let watched = handle.watched().unwrap();
        let mut fds = [PollFd::new(&watched, PollFlags::IN)];
        poll(&mut fds, None).unwrap();
    }
    let noticed = Instant::now();
    (noticed - killing.join().unwrap()).as_secs_f64() * 1e3
}
