//! In-port ends that wait for, or have, their connector.

use std::collections::BTreeMap;
use std::os::unix::net::UnixStream;
use std::sync::{Arc, Mutex};

use rts_manager_api::control::{Binding, BindingInfo, Failure};

use super::in_port::{Counts, InPort, Source};
use crate::failure::conflict;
use crate::sync::lock;

/// Bindings of a manager that may exist at once.
const MAX_BINDINGS: usize = 65_536;

/// An in-port end.
pub struct End {
    /// As given.
    pub binding: Binding,
    /// Incarnation of the component that owns the in-port.
    pub incarnation: String,
    /// The in-port.
    pub port: Arc<InPort>,
    source: Mutex<Option<Arc<Source>>>,
}

impl End {
    /// An end without a source.
    pub fn new(binding: Binding, incarnation: &str, port: &Arc<InPort>) -> Self {
        Self {
            binding,
            incarnation: incarnation.to_owned(),
            port: Arc::clone(port),
            source: Mutex::default(),
        }
    }

    /// Takes a new source in; the newest wins, the former one is closed.
    pub fn open(&self, stream: Option<UnixStream>) -> Arc<Source> {
        let source = Arc::new(Source::new(stream));
        if let Some(former) = lock(&self.source).replace(Arc::clone(&source)) {
            former.close();
        }
        source
    }

    /// Closes its source. True when that was one of this process, which then does not notice by itself.
    pub fn close(&self) -> bool {
        lock(&self.source)
            .as_ref()
            .is_some_and(|source| source.close() && source.is_direct())
    }

    /// What the inventory shows.
    pub fn info(&self) -> BindingInfo {
        let source = lock(&self.source).clone();
        let counts = source.as_ref().map_or_else(Counts::default, |s| s.counts());
        BindingInfo {
            connector: self.binding.connector.clone(),
            port: self.binding.port.clone(),
            connected: source.is_some_and(|source| source.is_open()),
            samples_received: counts.received,
            drops: counts.drops,
            gaps: counts.gaps,
        }
    }
}

/// All bindings of a manager, by connector.
#[derive(Default)]
pub struct Bindings(Mutex<BTreeMap<String, Arc<End>>>);

impl Bindings {
    /// Adds an end unless there is the same already; another one for that connector is closed and replaced.
    /// `allowed` is asked under the lock, so that no end is added to a component that is being deleted.
    pub fn add(
        &self,
        end: End,
        allowed: impl FnOnce() -> Result<(), Failure>,
    ) -> Result<Arc<End>, Failure> {
        let mut ends = lock(&self.0);
        allowed()?;
        if let Some(former) = ends.get(&end.binding.connector) {
            if former.binding == end.binding && former.incarnation == end.incarnation {
                return Ok(Arc::clone(former));
            }
            former.close();
        } else if ends.len() >= MAX_BINDINGS {
            return Err(conflict(format!(
                "there are {MAX_BINDINGS} bindings already"
            )));
        }
        let end = Arc::new(end);
        ends.insert(end.binding.connector.clone(), Arc::clone(&end));
        Ok(end)
    }

    /// The end of a connector.
    pub fn find(&self, connector: &str) -> Option<Arc<End>> {
        lock(&self.0).get(connector).cloned()
    }

    /// Removes the end of a connector.
    pub fn remove(&self, connector: &str) -> Option<Arc<End>> {
        lock(&self.0).remove(connector)
    }

    /// Removes the ends of a component.
    pub fn remove_of(&self, incarnation: &str) -> Vec<Arc<End>> {
        lock(&self.0)
            .extract_if(.., |_, end| end.incarnation == incarnation)
            .map(|(_, end)| end)
            .collect()
    }

    /// All ends.
    pub fn all(&self) -> Vec<Arc<End>> {
        lock(&self.0).values().cloned().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn end(port: &str, incarnation: &str) -> End {
        let binding = Binding {
            connector: "c".to_owned(),
            instance: "B".to_owned(),
            port: port.to_owned(),
            source: "A.out".to_owned(),
        };
        End::new(binding, incarnation, &Arc::new(InPort::new(port, "T")))
    }

    #[test]
    fn the_same_binding_keeps_its_connection_and_another_closes_it() {
        let bindings = Bindings::default();
        let first = bindings.add(end("in", "i1"), || Ok(())).unwrap();
        let source = first.open(None);
        bindings.add(end("in", "i1"), || Ok(())).unwrap();
        assert!(source.is_open());
        bindings.add(end("other", "i1"), || Ok(())).unwrap();
        assert!(!source.is_open());
        assert_eq!(bindings.all().len(), 1);
        assert_eq!(bindings.remove_of("i1").len(), 1);
        assert!(bindings.find("c").is_none());
    }

    #[test]
    fn the_newest_source_wins() {
        let end = end("in", "i1");
        let first = end.open(None);
        let second = end.open(None);
        assert!(!first.is_open() && second.is_open());
        assert!(end.close());
        assert!(!end.info().connected);
    }
}
