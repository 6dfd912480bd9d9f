//! About how many bytes a change holds on to: what people write may be large, all else is small.

use std::collections::BTreeMap;
use std::sync::Arc;

use rts_controller_api::objects::{Component, Connector, Event, Manager, Node, System};
use rts_schemas::system::Configuration;

use crate::json_size::json_size;

/// What each object takes besides.
const REST: usize = 1024;

/// Something that takes memory.
pub trait Weigh {
    /// Bytes that nobody else holds; `before` is what it was.
    fn weight(&self, before: Option<&Self>) -> usize;
}

impl Weigh for System {
    fn weight(&self, before: Option<&Self>) -> usize {
        // The spec of a generation is held once, however often its state changes.
        let spec = match before.is_some_and(|before| Arc::ptr_eq(&before.spec, &self.spec)) {
            true => 0,
            false => json_size(&self.spec),
        };
        REST + spec + json_size(&self.status)
    }
}

impl Weigh for Component {
    fn weight(&self, _: Option<&Self>) -> usize {
        let all = [&self.spec.configuration, &self.status.configuration];
        REST + all.map(configuration).iter().sum::<usize>()
    }
}

impl Weigh for Connector {
    fn weight(&self, _: Option<&Self>) -> usize {
        REST + texts(&self.spec.properties)
    }
}

impl Weigh for Manager {
    fn weight(&self, _: Option<&Self>) -> usize {
        REST + json_size(&self.status)
    }
}

impl Weigh for Node {
    fn weight(&self, _: Option<&Self>) -> usize {
        REST + json_size(&self.status)
    }
}

impl Weigh for Event {
    fn weight(&self, _: Option<&Self>) -> usize {
        REST + self.spec.message.len()
    }
}

fn configuration(configuration: &Configuration) -> usize {
    configuration.sets.values().map(texts).sum()
}

fn texts(map: &BTreeMap<String, String>) -> usize {
    map.iter().map(|(key, value)| key.len() + value.len()).sum()
}
