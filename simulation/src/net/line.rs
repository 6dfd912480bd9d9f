//! A connection on which one side goes on telling: its messages arrive in order, or not at all.

use std::time::Duration;

use tokio::sync::mpsc;
use tokio::time::{Instant, sleep_until};

use super::{Net, Reset};
use crate::life::Life;

/// The receiving end.
pub struct Line<T> {
    net: Net,
    from: String,
    to: Life,
    /// A message that comes into a cut comes after it, as sent again; else nothing more comes.
    pub(super) resumes: bool,
    broken: bool,
    messages: mpsc::UnboundedReceiver<(Instant, T)>,
    teller: Life,
    last: Instant,
}

/// Says things to the receiving end. Dropped, it says that there is no more.
pub struct Teller<T> {
    net: Net,
    from: String,
    to: String,
    last: Instant,
    sender: mpsc::UnboundedSender<(Instant, T)>,
}

/// A connection from a program to another.
pub fn line<T>(net: &Net, from: &Life, to: &Life) -> (Teller<T>, Line<T>) {
    let (sender, messages) = mpsc::unbounded_channel();
    let (host, now) = (from.host().to_owned(), Instant::now());
    let teller = Teller {
        net: net.clone(),
        from: host.clone(),
        to: to.host().to_owned(),
        last: now,
        sender,
    };
    let line = Line {
        net: net.clone(),
        resumes: net.chance(&host, to.host()),
        from: host,
        to: to.clone(),
        broken: false,
        messages,
        teller: from.clone(),
        last: now,
    };
    (teller, line)
}

impl<T> Teller<T> {
    /// Says something. False when nobody listens any more.
    pub fn say(&mut self, message: T) -> bool {
        let fate = self.net.fate(&self.from, &self.to);
        // A lost packet of a connection is sent again: it, and all behind it, come later.
        let again = if fate.lost {
            RETRANSMIT
        } else {
            Duration::ZERO
        };
        self.last = self.last.max(Instant::now() + fate.after + again);
        self.sender.send((self.last, message)).is_ok()
    }
}

/// Time until a lost packet of a connection is sent again.
const RETRANSMIT: Duration = Duration::from_millis(200);

impl<T> Line<T> {
    /// The next message: none at the orderly end, [`Reset`] when the teller's program has crashed. Does not return where
    /// the connection is cut, or the teller's machine has lost its power.
    pub async fn next(&mut self) -> Option<Result<T, Reset>> {
        self.to.pass().await;
        if self.broken {
            return std::future::pending().await;
        }
        tokio::select! {
            biased;
            message = self.messages.recv() => {
                let Some((at, message)) = message else {
                    self.arrive(Instant::now()).await;
                    return if self.teller.is_over() { Some(Err(Reset)) } else { None };
                };
                self.last = self.last.max(at);
                self.arrive(at).await;
                Some(Ok(message))
            }
            () = self.teller.over() => {
                let fate = self.net.fate(&self.from, self.to.host());
                self.arrive(self.last.max(Instant::now()) + fate.after).await;
                Some(Err(Reset))
            }
        }
    }

    async fn arrive(&mut self, at: Instant) {
        sleep_until(at).await;
        if self.net.is_open(&self.from, self.to.host()) {
            return;
        }
        if self.resumes {
            self.net.until_open(&self.from, self.to.host()).await;
            return;
        }
        self.broken = true;
        std::future::pending::<()>().await;
    }
}
