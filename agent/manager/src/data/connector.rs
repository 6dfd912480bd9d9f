//! A connector at its out-port end.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use std::time::Instant;

use rts_manager_api::control::{ConnectRequest, ConnectorInfo};
use rts_transport::Kind;

use super::choose::name;
use super::in_port::InPort;
use super::outbox::Outbox;
use super::rate::Rate;
use super::sample::{Sample, Written, now};
use super::sender::Sender;
use super::source::Source;
use super::{Parting, Payload};
use crate::sync::lock;

/// A connector. Its counters begin with its connection.
#[derive(Debug)]
pub struct Connector {
    /// As given, without the mark of the person who made it.
    pub request: ConnectRequest,
    by_hand: Mutex<Option<String>>,
    /// The one whose place it takes had lost its other end.
    pub replaces_lost: bool,
    link: Mutex<Link>,
    transport: Mutex<Option<Kind>>,
    /// Number of the last sample; those that were refused have one, too.
    last: AtomicU64,
    sent: AtomicU64,
    bytes: AtomicU64,
    drops: AtomicU64,
    refused: AtomicU64,
    rate: Rate,
}

/// A sample that found no room.
#[derive(Debug)]
pub struct Full {
    link: Link,
    sample: Sample,
}

/// How a connector reaches its target.
#[derive(Debug, Clone)]
pub enum Link {
    /// The other end was not heard yet.
    Connecting,
    /// In this process.
    Direct {
        /// The target.
        port: Arc<InPort>,
        /// This connection there.
        source: Arc<Source>,
        /// Where samples wait for a publisher, or for a reader that fetches; without it they are handed over at once.
        outbox: Option<Arc<Outbox>>,
    },
    /// In another process.
    Between(Arc<Sender>),
    /// It ended, and how.
    Closed(Parting),
}

impl Link {
    fn is_open(&self) -> bool {
        match self {
            Self::Connecting | Self::Closed(_) => false,
            Self::Direct { source, .. } => source.is_open(),
            Self::Between(_) => true,
        }
    }

    fn transport(&self) -> Option<Kind> {
        match self {
            Self::Connecting | Self::Closed(_) => None,
            Self::Direct { .. } => Some(Kind::InProcess),
            Self::Between(sender) => Some(sender.kind),
        }
    }

    fn close(&self, parting: Parting) {
        match self {
            Self::Connecting | Self::Closed(_) => {}
            Self::Direct { port, source, .. } => {
                port.close(source, parting);
            }
            Self::Between(sender) => sender.close(parting),
        }
    }
}

impl Connector {
    /// One that is being connected, with the mark of the person who makes it.
    pub fn new(request: ConnectRequest, by_hand: Option<String>, replaces_lost: bool) -> Self {
        Self {
            by_hand: Mutex::new(by_hand),
            request,
            replaces_lost,
            link: Mutex::new(Link::Connecting),
            transport: Mutex::default(),
            last: AtomicU64::new(0),
            sent: AtomicU64::new(0),
            bytes: AtomicU64::new(0),
            drops: AtomicU64::new(0),
            refused: AtomicU64::new(0),
            rate: Rate::default(),
        }
    }

    /// The other end has agreed. False when the connector was closed meanwhile; the link is then closed as well.
    pub fn establish(&self, link: Link) -> bool {
        let mut current = lock(&self.link);
        if matches!(*current, Link::Connecting) {
            *lock(&self.transport) = link.transport();
            *current = link;
            true
        } else {
            link.close(Parting::GoodBye);
            false
        }
    }

    /// Closes it; true when it was not closed before.
    pub fn close(&self, parting: Parting) -> bool {
        let former = std::mem::replace(&mut *lock(&self.link), Link::Closed(parting));
        former.close(parting);
        !matches!(former, Link::Closed(_))
    }

    /// Sends a sample when it is connected. One that finds no room is given back, to wait for it without holding other
    /// connectors up.
    pub fn offer(&self, payload: &Payload, written: u64) -> Result<Written, Full> {
        let link = lock(&self.link).clone();
        if !link.is_open() {
            return Ok(match self.was_lost(&link) {
                true => Written::Lost,
                false => Written::Taken,
            });
        }
        let size = payload.len() as u64;
        self.bytes.fetch_add(size, Ordering::Relaxed);
        // Before a reader can count it.
        self.sent.fetch_add(1, Ordering::Release);
        let sample = Sample {
            // Only the owner's thread writes, so the number cannot be taken twice.
            sequence: self.last.fetch_add(1, Ordering::Relaxed) + 1,
            time: written,
            payload: payload.clone(),
        };
        let (offered, drops) = match &link {
            Link::Connecting | Link::Closed(_) => (Ok(()), 0),
            Link::Direct {
                outbox: Some(outbox),
                ..
            } => outbox.offer(sample),
            Link::Direct { port, source, .. } => (port.offer(source, sample), 0),
            Link::Between(sender) => sender.offer(sample),
        };
        self.drops.fetch_add(drops, Ordering::Relaxed);
        match offered {
            Ok(()) => {
                self.rate.count(written);
                Ok(Written::Taken)
            }
            Err(sample) => Err(Full { link, sample }),
        }
    }

    /// Waits for room for a sample that found none, as the policy says. One that is refused was not sent.
    pub fn wait(&self, full: Full, began: Instant) -> Written {
        let Full { link, sample } = full;
        let (size, time) = (sample.payload.len() as u64, sample.time);
        let written = match &link {
            Link::Connecting | Link::Closed(_) => Written::Taken,
            Link::Direct {
                port,
                source,
                outbox: None,
            } => port.wait(source, sample, began, || true),
            Link::Direct {
                outbox: Some(outbox),
                ..
            } => outbox.wait(sample, began),
            Link::Between(sender) => sender.outbox.wait(sample, began),
        };
        if written == Written::Taken {
            self.rate.count(time);
        } else {
            self.drops.fetch_add(1, Ordering::Relaxed);
            self.refused.fetch_add(1, Ordering::Relaxed);
            self.sent.fetch_sub(1, Ordering::Release);
            self.bytes.fetch_sub(size, Ordering::Relaxed);
        }
        written
    }

    /// True while its writer waits for room.
    #[cfg(test)]
    pub fn holds_its_writer(&self) -> bool {
        match lock(&self.link).clone() {
            Link::Connecting | Link::Closed(_) => false,
            Link::Direct {
                port, outbox: None, ..
            } => port.has_sleepers(),
            Link::Direct {
                outbox: Some(outbox),
                ..
            } => outbox.has_sleepers(),
            Link::Between(sender) => sender.outbox.has_sleepers(),
        }
    }

    /// Who it belongs to now: a person, by this mark, or a plan.
    pub fn mark(&self, by_hand: Option<String>) {
        *lock(&self.by_hand) = by_hand;
    }

    /// Forgets the mark of the person who made it, if it is still this one.
    pub fn forget_mark(&self, mark: &str) {
        lock(&self.by_hand).take_if(|known| known == mark);
    }

    /// `Connected`, `Connecting` or `Disconnected`.
    pub fn state(&self) -> &'static str {
        match &*lock(&self.link) {
            Link::Connecting => "Connecting",
            Link::Direct { source, .. } if source.is_open() => "Connected",
            Link::Between(_) => "Connected",
            Link::Direct { .. } | Link::Closed(_) => "Disconnected",
        }
    }

    /// True when its other end was lost, until it is connected again.
    pub fn is_lost(&self) -> bool {
        self.was_lost(&lock(&self.link))
    }

    fn was_lost(&self, link: &Link) -> bool {
        match link {
            Link::Connecting => self.replaces_lost,
            Link::Direct { source, .. } => source.is_lost(),
            Link::Between(_) => false,
            Link::Closed(parting) => *parting == Parting::Loss,
        }
    }

    /// True when both ends are, or were, in this process and need no transport.
    pub fn is_direct(&self) -> bool {
        *lock(&self.transport) == Some(Kind::InProcess)
    }

    /// What the inventory shows.
    pub fn info(&self) -> ConnectorInfo {
        let transport = lock(&self.transport).map_or("", name);
        ConnectorInfo {
            name: self.request.connector.clone(),
            port: self.request.port.clone(),
            target_instance: self.request.target_instance.clone(),
            target_port: self.request.target_port.clone(),
            target_incarnation: self.request.target_incarnation.clone(),
            properties: self.request.properties.clone(),
            by_hand: lock(&self.by_hand).clone(),
            state: self.state().to_owned(),
            transport: transport.to_owned(),
            samples_sent: self.sent.load(Ordering::Acquire),
            bytes: self.bytes.load(Ordering::Relaxed),
            drops: self.drops.load(Ordering::Relaxed),
            refused: self.refused.load(Ordering::Relaxed),
            rate: self.rate.at(now()),
        }
    }
}
