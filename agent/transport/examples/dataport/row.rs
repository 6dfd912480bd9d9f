//! One row of the table.

use std::hint::black_box;
use std::num::NonZeroUsize;
use std::time::Instant;

use bytes::Bytes;
use rts_transport::{Receiver, Sample, Sender, inproc};

use crate::allocations;
use crate::bytes_of::{Payloads, expected, fill, sum};
use crate::processes::Peer;

/// Bytes of a sample.
pub const SIZES: [usize; 3] = [8, 1024, 1 << 20];

/// All rows.
pub const NAMES: [&str; 9] = [
    "floor-call",
    "inproc",
    "floor-memcpy",
    "floor-ring",
    "shm",
    "floor-uds",
    "uds",
    "floor-tcp",
    "tcp",
];

/// A row that is being measured.
pub struct Row {
    name: &'static str,
    size: usize,
    way: Way,
    /// Nanoseconds from the first byte written until the last was read.
    latencies: Vec<f64>,
    /// The median of each round.
    medians: Vec<f64>,
    /// Samples a second, of each round.
    rates: Vec<f64>,
    allocations: u64,
    samples: u64,
}

enum Way {
    /// All within this process; sends and receives a sample.
    Inside(Box<dyn FnMut(u64)>, u64),
    /// Answers each sample, and answers many with one.
    Processes(Peer, u64, Peer, u64),
}

/// Samples of a round that are timed together, where one would take less than the clock.
fn batch(size: usize) -> u64 {
    if size < 100_000 { 100 } else { 1 }
}

/// Samples of a round.
fn count(size: usize) -> u64 {
    if size < 100_000 { 300 } else { 20 }
}

/// Samples that are sent in one go.
fn stream(size: usize) -> u64 {
    if size < 100_000 { 5000 } else { 60 }
}

impl Row {
    pub fn new(name: &'static str, size: usize) -> Self {
        let way = match name {
            "floor-call" => Way::Inside(call(size), 0),
            "floor-memcpy" => Way::Inside(memcpys(size), 0),
            "inproc" => Way::Inside(inside(size), 0),
            _ => Way::Processes(
                Peer::start(name, size, 1),
                0,
                Peer::start(name, size, stream(size)),
                0,
            ),
        };
        Self {
            name,
            size,
            way,
            latencies: Vec::with_capacity(100_000),
            medians: Vec::with_capacity(1000),
            rates: Vec::with_capacity(1000),
            allocations: 0,
            samples: 0,
        }
    }

    /// One round.
    pub fn measure(&mut self, counts: bool) {
        let (size, count, stream) = (self.size, count(self.size), stream(self.size));
        let known = self.latencies.len();
        let allocated = allocations::count();
        match &mut self.way {
            Way::Inside(pass, sequence) => {
                let batch = batch(size);
                for _ in 0..count {
                    let start = Instant::now();
                    for _ in 0..batch {
                        pass(*sequence);
                        *sequence += 1;
                    }
                    let took = start.elapsed().as_nanos() as f64;
                    self.latencies.push(took / batch as f64);
                }
                let start = Instant::now();
                for _ in 0..stream {
                    pass(*sequence);
                    *sequence += 1;
                }
                self.rates
                    .push(stream as f64 / start.elapsed().as_secs_f64());
                self.samples += count * batch + stream;
                self.allocations += allocations::count() - allocated;
            }
            Way::Processes(echo, sequence, sink, streamed) => {
                for _ in 0..count {
                    let start = Instant::now();
                    echo.link.send(*sequence);
                    assert!(echo.link.receive(*sequence), "the other process is gone");
                    self.latencies.push(start.elapsed().as_nanos() as f64 / 2.0);
                    *sequence += 1;
                }
                // Each way and back this process has sent one and received one.
                self.samples += count;
                self.allocations += allocations::count() - allocated;
                let start = Instant::now();
                for _ in 0..stream {
                    sink.link.send(*streamed);
                    *streamed += 1;
                }
                let answer = *streamed / stream - 1;
                assert!(sink.link.receive(answer), "the other process is gone");
                self.rates
                    .push(stream as f64 / start.elapsed().as_secs_f64());
            }
        }
        if !counts {
            self.latencies.clear();
            self.rates.clear();
            (self.allocations, self.samples) = (0, 0);
            return;
        }
        let mut round = self.latencies[known..].to_vec();
        round.sort_by(f64::total_cmp);
        self.medians.push(at(&round, 0.5));
    }

    pub fn json(&mut self) -> String {
        self.latencies.sort_by(f64::total_cmp);
        self.rates.sort_by(f64::total_cmp);
        self.medians.sort_by(f64::total_cmp);
        let rate = at(&self.rates, 0.5);
        format!(
            "  {{\"row\": \"{}\", \"bytes\": {}, \"medianNs\": {:.1}, \"p99Ns\": {:.1}, \"quietestNs\": {:.1}, \"perSecond\": {:.0}, \
             \"megabytesPerSecond\": {:.1}, \"allocationsPerSample\": {:.3}}}",
            self.name,
            self.size,
            at(&self.latencies, 0.5),
            at(&self.latencies, 0.99),
            self.medians[0],
            rate,
            rate * self.size as f64 / 1e6,
            self.allocations as f64 / self.samples as f64,
        )
    }
}

/// Of sorted figures the one with so many below it.
fn at(sorted: &[f64], share: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * share).round() as usize]
}

trait Target {
    fn put(&mut self, payload: &Bytes) -> u64;
}

struct Reads;

impl Target for Reads {
    #[inline(never)]
    fn put(&mut self, payload: &Bytes) -> u64 {
        // Kept as long as it is read, as a port does.
        let kept = payload.clone();
        sum(&kept)
    }
}

/// A call through a trait object, and a clone.
fn call(size: usize) -> Box<dyn FnMut(u64)> {
    let mut payloads = Payloads::new(size);
    let mut target: Box<dyn Target> = black_box(Box::new(Reads));
    Box::new(move |sequence| {
        let payload = payloads.next(sequence);
        assert_eq!(target.put(&payload), expected(size, sequence));
    })
}

/// Copied in, and copied out.
fn memcpys(size: usize) -> Box<dyn FnMut(u64)> {
    let [mut from, mut ring, mut to] = [(); 3].map(|()| vec![0; size]);
    Box::new(move |sequence| {
        fill(&mut from, sequence);
        black_box(&mut ring).copy_from_slice(&from);
        black_box(&mut to).copy_from_slice(&ring);
        assert_eq!(sum(&to), expected(size, sequence));
    })
}

/// The transport inside a process, with the reader in the thread of the writer: what it costs, without a wake-up.
fn inside(size: usize) -> Box<dyn FnMut(u64)> {
    let mut payloads = Payloads::new(size);
    let capacity = NonZeroUsize::new(64).unwrap();
    let (sender, receiver) = inproc::pair(capacity);
    let mut sender: Box<dyn Sender> = Box::new(sender);
    let mut receiver: Box<dyn Receiver> = Box::new(receiver);
    Box::new(move |sequence| {
        let sample = Sample {
            sequence,
            time: 0,
            payload: payloads.next(sequence),
        };
        sender.push(sample).unwrap();
        let sample = receiver.try_take().unwrap().unwrap();
        assert_eq!(sum(&sample.payload), expected(size, sequence));
    })
}
