//! Measures transports beside their floors, in interleaved rounds, and prints JSON; `cargo xtask bench dataport` shows it.
//!
//! Whoever sends writes every byte of a sample, and whoever receives adds all of them up.

#![allow(clippy::unwrap_used, missing_docs)]

mod allocations;
mod bytes_of;
mod deaths;
mod link;
mod plain;
mod processes;
mod ring;
mod row;

use row::{Row, SIZES};

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    match args[..] {
        ["child", name, size, mode] => {
            stay_on(1);
            processes::play(name, size.parse().unwrap(), mode.parse().unwrap());
        }
        ["measure", rounds] => {
            stay_on(0);
            measure(rounds.parse().unwrap());
        }
        _ => eprintln!("dataport measure ROUNDS"),
    }
}

fn measure(rounds: u32) {
    let mut rows: Vec<Row> = SIZES
        .iter()
        .flat_map(|size| row::NAMES.map(|name| Row::new(name, *size)))
        .collect();
    // The first is not counted.
    for round in 0..=rounds {
        for row in &mut rows {
            row.measure(round > 0);
        }
    }
    let shown: Vec<_> = rows.iter_mut().map(|row| row.json()).collect();
    let deaths = deaths::json(u64::from(rounds));
    let rows = shown.join(",\n");
    println!("{{\"rows\": [\n{rows}\n], \"deaths\": [\n{deaths}\n]}}");
}

/// The two processes run beside each other, where there are two processors.
fn stay_on(processor: usize) {
    let mut set = rustix::thread::CpuSet::new();
    set.set(processor);
    // Fails where there is no such processor.
    let _ = rustix::thread::sched_setaffinity(None, &set);
}
