//! An out-port: hands each sample to all its connectors.

use std::sync::{Arc, Mutex};

use rts_manager_api::control::Failure;

use super::Payload;
use super::connector::Connector;
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
    connectors: Mutex<Vec<Arc<Connector>>>,
}

impl OutPort {
    /// An out-port without connectors.
    pub fn new(name: &str, data_type: &str) -> Self {
        Self {
            name: name.to_owned(),
            data_type: data_type.to_owned(),
            connectors: Mutex::default(),
        }
    }

    /// Gives a sample to each connector. Never blocks.
    pub fn write(&self, payload: &Payload) {
        for connector in lock(&self.connectors).iter() {
            connector.push(payload);
        }
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
        connectors.push(Arc::clone(connector));
        Ok(())
    }

    /// Takes the connectors out that `which` names.
    pub fn take(&self, which: impl Fn(&Arc<Connector>) -> bool) -> Vec<Arc<Connector>> {
        let mut connectors = lock(&self.connectors);
        connectors.extract_if(.., |c| which(c)).collect()
    }

    /// Its connectors.
    pub fn connectors(&self) -> Vec<Arc<Connector>> {
        lock(&self.connectors).clone()
    }
}
