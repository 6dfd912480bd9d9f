//! A connector inside a process.

use std::sync::Arc;
use std::thread;

use rts_manager_api::control::Failure;
use rts_schemas::connector::{ConnectorSettings, Dataflow, Subscription};

use super::Parting;
use super::binding::End;
use super::connector::Link;
use super::in_port::InPort;
use super::outbox::Outbox;
use super::publisher::publish;
use super::source::Source;
use crate::events::Events;
use crate::failure::{conflict, internal};
use crate::slots::Slots;

/// Connects to an in-port end of this process. What flushes is a function call; what has a publisher gets a thread.
pub fn link(
    end: &End,
    settings: ConnectorSettings,
    threads: &Slots,
    events: &Events,
) -> Result<Link, Failure> {
    let pulls = settings.dataflow == Dataflow::Pull;
    let publishes = !pulls && settings.subscription != Subscription::Flush;
    let outbox = (pulls || publishes)
        .then(|| Outbox::new(&settings).map(Arc::new))
        .transpose()
        .map_err(|e| internal(format!("no buffer for a connector: {e}")))?;
    let source = end.open(None, settings, outbox.clone(), events)?;
    if let Some(outbox) = outbox.as_ref().filter(|_| publishes) {
        let started = publisher(&end.port, &source, outbox, threads);
        if started.is_err() {
            end.port.close(&source, Parting::GoodBye);
        }
        started?;
    }
    Ok(Link::Direct {
        port: Arc::clone(&end.port),
        source,
        outbox,
    })
}

/// Starts the thread that publishes. It ends with the connection.
fn publisher(
    port: &Arc<InPort>,
    source: &Arc<Source>,
    outbox: &Arc<Outbox>,
    threads: &Slots,
) -> Result<(), Failure> {
    let slot = threads.take().ok_or_else(|| {
        conflict("there are too many connectors with a thread of their own already")
    })?;
    let (port, source, outbox) = (Arc::clone(port), Arc::clone(source), Arc::clone(outbox));
    let run = move || {
        let mut publisher = Publisher {
            port,
            source,
            has_failed: true,
        };
        publisher.has_failed = publish(&outbox, &publisher.port, &publisher.source).is_err();
        drop(slot);
    };
    let spawned = thread::Builder::new()
        .name("publisher".to_owned())
        .spawn(run);
    spawned
        .map(drop)
        .map_err(|e| internal(format!("no thread to publish: {e}")))
}

/// A thread that publishes. However it ends, nobody takes its connector for one that works.
struct Publisher {
    port: Arc<InPort>,
    source: Arc<Source>,
    has_failed: bool,
}

impl Drop for Publisher {
    fn drop(&mut self) {
        if self.has_failed {
            self.port.close(&self.source, Parting::Loss);
        }
    }
}
