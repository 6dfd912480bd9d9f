//! About how many bytes a change holds on to: what people write may be large, all else is small.

use std::collections::BTreeMap;
use std::io;
use std::sync::Arc;

use rts_controller_api::objects::{Component, Connector, Event, Manager, Node, System};
use rts_schemas::system::Configuration;

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
            false => written(&self.spec),
        };
        REST + spec + written(&self.status)
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
        REST + written(&self.status)
    }
}

impl Weigh for Node {
    fn weight(&self, _: Option<&Self>) -> usize {
        REST + written(&self.status)
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

/// Bytes as JSON.
fn written(value: &impl serde::Serialize) -> usize {
    struct Count(usize);

    impl io::Write for Count {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0 += bytes.len();
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    let mut count = Count(0);
    // Nothing of an object can fail to become JSON, and counting cannot fail.
    let _ = serde_json::to_writer(&mut count, value);
    count.0
}
