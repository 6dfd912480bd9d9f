//! The publisher of a connector inside a process: moves samples from its buffer into the in-port, when and as its
//! subscription type and push policy say.

use std::io;
use std::sync::Arc;
use std::time::Instant;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

use super::in_port::InPort;
use super::outbox::Outbox;
use super::source::Source;

/// Moves samples until the connector ends. For a thread of its own.
pub fn publish(outbox: &Outbox, port: &InPort, source: &Arc<Source>) -> io::Result<()> {
    let mut tick = outbox.period().map(|period| Instant::now() + period);
    loop {
        while outbox.closed().is_none()
            && let Some(sample) = outbox.next()
        {
            port.take_in(source, sample, || true);
        }
        if outbox.closed().is_some() || !source.is_open() {
            return Ok(());
        }
        sleep(outbox, tick)?;
        if let (Some(at), Some(period)) = (tick, outbox.period())
            && Instant::now() >= at
        {
            outbox.tick();
            // A tick that was missed is not made up for.
            tick = Some((at + period).max(Instant::now()));
        }
    }
}

/// Waits until there is something to do.
fn sleep(outbox: &Outbox, until: Option<Instant>) -> io::Result<()> {
    let left = until.map(|at| at.saturating_duration_since(Instant::now()));
    let timeout = left.map(|left| Timespec {
        tv_sec: left.as_secs().try_into().unwrap_or(i64::MAX),
        tv_nsec: left.subsec_nanos().into(),
    });
    let filled = outbox.filled();
    match poll(&mut [PollFd::new(&filled, PollFlags::IN)], timeout.as_ref()) {
        Ok(_) | Err(Errno::INTR) => {}
        Err(error) => return Err(error.into()),
    }
    outbox.awake();
    Ok(())
}
