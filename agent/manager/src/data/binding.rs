//! In-port ends that wait for, or have, their connector.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use rts_manager_api::control::{Binding, BindingInfo, Failure};

use rts_schemas::connector::ConnectorSettings;
use rts_transport::Handle;

use super::Parting;
use super::in_port::InPort;
use super::outbox::Outbox;
use super::source::{Counts, Source};
use crate::events::Events;
use crate::failure::{conflict, not_found};
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
    link: Mutex<Link>,
}

/// What an end is connected to.
#[derive(Default)]
struct Link {
    source: Option<Arc<Source>>,
    /// It was removed: nobody may connect to it any more.
    removed: bool,
}

impl End {
    /// An end without a source.
    pub fn new(binding: Binding, incarnation: &str, port: &Arc<InPort>) -> Self {
        Self {
            binding,
            incarnation: incarnation.to_owned(),
            port: Arc::clone(port),
            link: Mutex::default(),
        }
    }

    /// Takes a new source in; the newest wins, the former one is closed. Refused when the end was removed.
    pub fn open(
        &self,
        transport: Option<Handle>,
        settings: ConnectorSettings,
        outbox: Option<Arc<Outbox>>,
        events: &Events,
    ) -> Result<Arc<Source>, Failure> {
        let mut link = lock(&self.link);
        if link.removed {
            return Err(not_found(format!(
                "{}.{} does not expect the connector {} any more: it was unbound",
                self.binding.instance, self.binding.port, self.binding.connector
            )));
        }
        let source = Arc::new(Source::new(transport, settings, outbox));
        self.port.open(&source);
        let former = link.source.replace(Arc::clone(&source));
        drop(link);
        let reason = "another source took its place";
        self.end(former.as_ref(), reason, Parting::GoodBye, events);
        Ok(source)
    }

    /// Closes it for good, with its source.
    pub fn close(&self, events: &Events, parting: Parting) {
        let source = {
            let mut link = lock(&self.link);
            link.removed = true;
            link.source.clone()
        };
        let binding = &self.binding;
        let reason = format!("its target {}.{} has gone", binding.instance, binding.port);
        self.end(source.as_ref(), &reason, parting, events);
    }

    /// Closes a source. One in this process has no connection that would break, so it is told here.
    fn end(&self, source: Option<&Arc<Source>>, reason: &str, parting: Parting, events: &Events) {
        let Some(source) = source else {
            return;
        };
        if self.port.close(source, parting) && source.is_direct() {
            let target = format!("connector/{}", self.binding.connector);
            events.changed(target, reason.to_owned());
        }
    }

    /// True when its source is, or was, in this process.
    pub fn is_direct(&self) -> bool {
        let link = lock(&self.link);
        link.source
            .as_ref()
            .is_some_and(|source| source.is_direct())
    }

    /// True when its source was lost, until another one takes its place.
    pub fn is_lost(&self) -> bool {
        let link = lock(&self.link);
        link.source.as_ref().is_some_and(|source| source.is_lost())
    }

    /// What the inventory shows.
    pub fn info(&self) -> BindingInfo {
        let source = lock(&self.link).source.clone();
        let counts = source.as_ref().map_or_else(Counts::default, |s| s.counts());
        BindingInfo {
            connector: self.binding.connector.clone(),
            port: self.binding.port.clone(),
            source: Some(self.binding.source.clone()),
            connected: source.is_some_and(|source| source.is_open()),
            samples_received: counts.received,
            drops: counts.drops,
            gaps: counts.gaps,
            latency: counts.latency,
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
        events: &Events,
        allowed: impl FnOnce() -> Result<(), Failure>,
    ) -> Result<Arc<End>, Failure> {
        let mut ends = lock(&self.0);
        allowed()?;
        if let Some(former) = ends.get(&end.binding.connector) {
            if former.binding == end.binding && former.incarnation == end.incarnation {
                return Ok(Arc::clone(former));
            }
            former.close(events, Parting::GoodBye);
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

    /// A connector of a component whose source was lost.
    pub fn lost_of(&self, incarnation: &str) -> Option<String> {
        lock(&self.0)
            .values()
            .find(|end| end.incarnation == incarnation && end.is_lost())
            .map(|end| end.binding.connector.clone())
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
        let (bindings, events) = (Bindings::default(), Events::default());
        let add = |end| bindings.add(end, &events, || Ok(())).unwrap();
        let first = add(end("in", "i1"));
        let source = first
            .open(None, ConnectorSettings::default(), None, &events)
            .unwrap();
        add(end("in", "i1"));
        assert!(source.is_open());
        add(end("other", "i1"));
        assert!(!source.is_open());
        assert_eq!(bindings.all().len(), 1);
        assert_eq!(bindings.remove_of("i1").len(), 1);
        assert!(bindings.find("c").is_none());
    }

    #[test]
    fn a_lost_end_stays_lost_until_it_is_opened_again_or_removed() {
        let (bindings, events) = (Bindings::default(), Events::default());
        let bind = || bindings.add(end("in", "i1"), &events, || Ok(())).unwrap();
        let lost = || bindings.lost_of("i1");
        let bound = bind();
        assert_eq!(lost(), None, "it never had a source");
        let source = bound
            .open(None, ConnectorSettings::default(), None, &events)
            .unwrap();
        bound.port.close(&source, Parting::Loss);
        bind();
        assert_eq!(
            lost().as_deref(),
            Some("c"),
            "bound again is not opened again"
        );
        assert_eq!(bindings.lost_of("i2"), None);
        let source = bound
            .open(None, ConnectorSettings::default(), None, &events)
            .unwrap();
        assert_eq!(lost(), None);
        bound.port.close(&source, Parting::GoodBye);
        assert_eq!(lost(), None, "an order is no loss");
        let source = bound
            .open(None, ConnectorSettings::default(), None, &events)
            .unwrap();
        bound.port.close(&source, Parting::Loss);
        bindings.remove("c");
        assert_eq!(lost(), None);
    }

    #[test]
    fn the_newest_source_wins() {
        let (end, events) = (end("in", "i1"), Events::default());
        let first = end
            .open(None, ConnectorSettings::default(), None, &events)
            .unwrap();
        let second = end
            .open(None, ConnectorSettings::default(), None, &events)
            .unwrap();
        assert!(!first.is_open() && second.is_open());
        end.close(&events, Parting::GoodBye);
        assert!(!second.is_open() && !end.info().connected);
    }

    #[test]
    fn an_end_that_was_removed_takes_nobody_in() {
        let (bindings, events) = (Bindings::default(), Events::default());
        let end = bindings.add(end("in", "i1"), &events, || Ok(())).unwrap();
        bindings
            .remove("c")
            .unwrap()
            .close(&events, Parting::GoodBye);
        let refusal = end
            .open(None, ConnectorSettings::default(), None, &events)
            .unwrap_err();
        assert!(refusal.message.contains("it was unbound"), "{refusal}");
        assert!(!end.info().connected);
    }
}
