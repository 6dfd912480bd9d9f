//! A disk that forgets what was never made durable. It survives the lives of the programs that use it.

mod files;
mod grip;
#[cfg(test)]
mod tests;

use std::io;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rts_host::disk::Disk;

use self::files::Files;
use self::grip::Grip;
use crate::life::Life;
use crate::seed::{Seed, Stream};

/// Usual time of a call in microseconds, from and to.
const USUAL: (u64, u64) = (100, 3_000);

/// The disk of one host. Clones are the same disk.
#[derive(Debug, Clone)]
pub struct SimDisk(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    files: Mutex<Files>,
    trouble: Mutex<Trouble>,
    /// Times of calls.
    times: Stream,
    /// Where a write is cut, and which error it gets.
    faults: Stream,
    /// What a loss of power leaves.
    losses: Stream,
}

/// What is wrong with it now.
#[derive(Debug, Clone, Copy, Default)]
struct Trouble {
    fails: bool,
    slow: Option<Duration>,
}

impl SimDisk {
    /// The empty disk of a host.
    pub fn new(host: &str, seed: Seed) -> Self {
        let stream = |purpose: &str| seed.stream(&format!("disk/{host}/{purpose}"));
        Self(Arc::new(Shared {
            files: Mutex::default(),
            trouble: Mutex::default(),
            times: stream("times"),
            faults: stream("faults"),
            losses: stream("losses"),
        }))
    }

    /// The disk as one life of a program has it.
    pub fn grip(&self, life: Life) -> Arc<dyn Disk> {
        Arc::new(Grip {
            disk: self.clone(),
            life,
        })
    }

    /// From now on writes fail, or no more.
    pub fn fail_writes(&self, fails: bool) {
        self.trouble().fails = fails;
    }

    /// From now on each call takes up to this much longer; none for the usual time.
    pub fn slow(&self, slow: Option<Duration>) {
        self.trouble().slow = slow;
    }

    /// The machine loses its power: what was not made durable may be gone, in whole or in part.
    pub fn lose_power(&self) {
        self.files().lose_power(&self.0.losses);
    }

    /// A file as whoever reads it finds it; none when there is none.
    pub fn contents(&self, path: &Path) -> Option<Vec<u8>> {
        self.files().read(path).map(<[u8]>::to_vec)
    }

    /// Waits for as long as a call takes now.
    async fn delay(&self) {
        let (low, high) = USUAL;
        let mut time = Duration::from_micros(self.0.times.between(low, high));
        if let Some(bound) = self.trouble().slow {
            let bound = u64::try_from(bound.as_micros()).unwrap_or(u64::MAX);
            time += Duration::from_micros(self.0.times.between(0, bound));
        }
        tokio::time::sleep(time).await;
    }

    /// The error of a call that writes, while writes fail.
    fn refuse(&self, otherwise: io::ErrorKind) -> io::Result<()> {
        if !self.trouble().fails {
            return Ok(());
        }
        Err(if self.0.faults.chance(0.5) {
            io::Error::other("input/output error (simulated)")
        } else {
            io::Error::new(otherwise, "the disk fails (simulated)")
        })
    }

    fn files(&self) -> MutexGuard<'_, Files> {
        self.0.files.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn trouble(&self) -> MutexGuard<'_, Trouble> {
        let trouble = self.0.trouble.lock();
        trouble.unwrap_or_else(PoisonError::into_inner)
    }
}
