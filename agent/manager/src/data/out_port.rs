//! An out-port: hands each sample to all its connectors.

use std::sync::{Arc, Mutex};
use std::time::Instant;

use rts_manager_api::control::Failure;

use super::Payload;
use super::connector::Connector;
use super::sample::{Written, now};
use super::tap::Taps;
use crate::failure::conflict;
use crate::sync::lock;

/// Connectors of one out-port that may exist at once.
const MAX_CONNECTORS: usize = 1024;

/// An out-port.
#[derive(Debug)]
pub struct OutPort {
    /// Bare name.
    pub name: String,
    /// IDL repository id.
    pub data_type: String,
    /// A list of its own for each change, so that a writer holds no lock while it waits.
    connectors: Mutex<Arc<Vec<Arc<Connector>>>>,
    /// Who looks at what it writes.
    pub taps: Arc<Taps>,
}

impl OutPort {
    /// An out-port without connectors.
    pub fn new(name: &str, data_type: &str) -> Self {
        Self {
            name: name.to_owned(),
            data_type: data_type.to_owned(),
            connectors: Mutex::default(),
            taps: Arc::default(),
        }
    }

    /// Gives a sample to each connector; the worst that became of it. Waits only where a connector's properties say so,
    /// once all the others have it, and for none longer than its own time-out.
    pub fn write(&self, payload: &Payload) -> Written {
        self.taps.offer(payload);
        let connectors = Arc::clone(&lock(&self.connectors));
        let mut full = Vec::new();
        let mut worst = Written::Taken;
        if !connectors.is_empty() {
            let written = now();
            for connector in connectors.iter() {
                match connector.offer(payload, written) {
                    Ok(written) => worst = worst.max(written),
                    Err(sample) => full.push((connector, sample)),
                }
            }
        }
        let began = Instant::now();
        let waited = full
            .into_iter()
            .map(|(connector, sample)| connector.wait(sample, began));
        waited.fold(worst, Written::max)
    }

    /// Adds a connector. `allowed` is asked under the lock, so that none is added while its component is deleted.
    pub fn add(
        &self,
        connector: &Arc<Connector>,
        allowed: impl FnOnce() -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let mut connectors = lock(&self.connectors);
        allowed()?;
        if connectors.len() >= MAX_CONNECTORS {
            return Err(conflict(format!(
                "out-port {} has {MAX_CONNECTORS} connectors already",
                self.name
            )));
        }
        Arc::make_mut(&mut connectors).push(Arc::clone(connector));
        Ok(())
    }

    /// Takes the connectors out that `which` names.
    pub fn take(&self, which: impl Fn(&Arc<Connector>) -> bool) -> Vec<Arc<Connector>> {
        let mut connectors = lock(&self.connectors);
        let list = Arc::make_mut(&mut connectors);
        list.extract_if(.., |c| which(c)).collect()
    }

    /// Its connectors.
    pub fn connectors(&self) -> Vec<Arc<Connector>> {
        lock(&self.connectors).to_vec()
    }
}
