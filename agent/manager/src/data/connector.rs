//! A connector at its out-port end.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use rts_manager_api::control::{ConnectRequest, ConnectorInfo};

use super::in_port::InPort;
use super::outbox::Outbox;
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
    sent: AtomicU64,
    bytes: AtomicU64,
    drops: AtomicU64,
}

/// How a connector reaches its target.
#[derive(Debug)]
pub enum Link {
    /// The other end was not heard yet.
    Connecting,
    /// In this process.
    Direct {
        /// The target.
        port: Arc<InPort>,
        /// This connection there.
        source: Arc<Source>,
    },
    /// Over a socket.
    Socket(Arc<Outbox>),
    /// It ended, and how.
    Closed(Parting),
}

impl Link {
    fn close(&self, parting: Parting) {
        match self {
            Self::Connecting | Self::Closed(_) => {}
            Self::Direct { port, source } => {
                port.close(source, parting);
            }
            Self::Socket(outbox) => outbox.close(parting),
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
            sent: AtomicU64::new(0),
            bytes: AtomicU64::new(0),
            drops: AtomicU64::new(0),
        }
    }

    /// The other end has agreed. False when the connector was closed meanwhile; the link is then closed as well.
    pub fn establish(&self, link: Link) -> bool {
        let mut current = lock(&self.link);
        if matches!(*current, Link::Connecting) {
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

    /// Sends a sample when it is connected.
    pub fn push(&self, payload: &Payload) {
        let size = payload.len() as u64;
        // Only the owner's thread pushes, so the number cannot be taken twice.
        let sequence = self.sent.load(Ordering::Relaxed) + 1;
        let count = || {
            self.bytes.fetch_add(size, Ordering::Relaxed);
            self.sent.store(sequence, Ordering::Release);
        };
        match &*lock(&self.link) {
            Link::Direct { port, source } => {
                port.push(source, sequence, payload.clone(), count);
            }
            Link::Socket(outbox) => {
                let drops = outbox.push(sequence, payload.clone(), count);
                self.drops.fetch_add(drops, Ordering::Relaxed);
            }
            Link::Connecting | Link::Closed(_) => {}
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
            Link::Socket(_) => "Connected",
            Link::Direct { .. } | Link::Closed(_) => "Disconnected",
        }
    }

    /// True when its other end was lost, until it is connected again.
    pub fn is_lost(&self) -> bool {
        match &*lock(&self.link) {
            Link::Connecting => self.replaces_lost,
            Link::Direct { source, .. } => source.is_lost(),
            Link::Socket(_) => false,
            Link::Closed(parting) => *parting == Parting::Loss,
        }
    }

    /// What the inventory shows.
    pub fn info(&self) -> ConnectorInfo {
        let transport = match self.request.target_socket {
            None => "direct",
            Some(_) => "uds",
        };
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
        }
    }
}
