//! Events pushed to all control connections.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, OnceLock, Weak};
use std::thread;

use rts_manager_api::control::{Changed, FromManager};

use crate::connection::Connection;
use crate::log;
use crate::sync::lock;

/// Events that wait to be sent. Receivers ask for the inventory anyway, so a lost one only costs time.
const QUEUE: usize = 1024;

/// The way out for events. A clone leads to the same receivers.
#[derive(Clone, Default)]
pub struct Events(Arc<Shared>);

#[derive(Default)]
struct Shared {
    receivers: Mutex<Vec<Weak<Connection>>>,
    queue: OnceLock<SyncSender<Changed>>,
}

impl Events {
    /// Adds a receiver; it leaves when it is dropped.
    pub fn subscribe(&self, connection: &Arc<Connection>) {
        let mut receivers = lock(&self.0.receivers);
        receivers.retain(|receiver| receiver.strong_count() > 0);
        receivers.push(Arc::downgrade(connection));
    }

    /// Starts the thread that sends, before there is anything to send.
    pub fn prepare(&self) {
        self.0.queue.get_or_init(|| self.start());
    }

    /// Tells everyone that something changed by itself. Never blocks: any thread may call it.
    pub fn changed(&self, target: String, message: String) {
        self.push(target, message, None);
    }

    /// The same, for what people should see as an event.
    pub fn told(&self, target: String, reason: &str, message: String) {
        self.push(target, message, Some(reason.to_owned()));
    }

    fn push(&self, target: String, message: String, reason: Option<String>) {
        let queue = self.0.queue.get_or_init(|| self.start());
        let changed = Changed {
            target,
            message,
            reason,
        };
        if queue.try_send(changed).is_err() {
            log::warn(format_args!("an event was lost: too many wait to be sent"));
        }
    }

    /// The thread that sends starts with the first event.
    fn start(&self) -> SyncSender<Changed> {
        let (sender, receiver) = sync_channel(QUEUE);
        let shared = Arc::clone(&self.0);
        let spawned = thread::Builder::new()
            .name("events".to_owned())
            .spawn(move || shared.send(&receiver));
        if let Err(error) = spawned {
            log::error(format_args!("no events will be sent: {error}"));
        }
        sender
    }
}

impl Shared {
    fn send(&self, queue: &Receiver<Changed>) {
        while let Ok(changed) = queue.recv() {
            let message = FromManager::Changed(changed);
            let receivers: Vec<_> = lock(&self.receivers)
                .iter()
                .filter_map(Weak::upgrade)
                .collect();
            for receiver in receivers {
                receiver.send(&message);
            }
        }
    }
}
