//! Load on processors: one busy thread on each, which also moves memory.

use std::hint::black_box;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use anyhow::Result;
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

/// More than the caches hold.
const MEMORY: usize = 64 * 1024 * 1024;

/// Processors that this program may run on.
pub fn processors() -> Result<Vec<usize>> {
    let set = sched_getaffinity(None)?;
    Ok((0..CpuSet::MAX_CPU)
        .filter(|cpu| set.is_set(*cpu))
        .collect())
}

/// Binds the calling thread to a processor.
pub fn bind(cpu: usize) -> Result<()> {
    let mut set = CpuSet::new();
    set.set(cpu);
    Ok(sched_setaffinity(None, &set)?)
}

/// Busy threads. Their drop ends them.
pub struct Load {
    end: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Load {
    /// Starts one on each of these processors.
    pub fn start(cpus: &[usize]) -> Result<Self> {
        let end = Arc::new(AtomicBool::new(false));
        let mut load = Self {
            end: Arc::clone(&end),
            threads: Vec::new(),
        };
        for &cpu in cpus {
            let end = Arc::clone(&end);
            let busy = move || {
                if let Err(error) = bind(cpu) {
                    eprintln!("no load on processor {cpu}: {error}");
                    return;
                }
                let (from, mut to) = (vec![1_u8; MEMORY], vec![0_u8; MEMORY]);
                while !end.load(Ordering::Relaxed) {
                    to.copy_from_slice(black_box(&from));
                    black_box(&to);
                }
            };
            load.threads
                .push(thread::Builder::new().name("load".to_owned()).spawn(busy)?);
        }
        Ok(load)
    }
}

impl Drop for Load {
    fn drop(&mut self) {
        self.end.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            // It cannot panic.
            let _ = thread.join();
        }
    }
}
