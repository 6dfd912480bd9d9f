//! The reading side of the ring.

use std::io;
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use bytes::BytesMut;

use super::layout::{READER, TAKEN, WRITER, WRITTEN};
use super::map::Map;
use super::sleep::Sleep;
use crate::ends::Asked;
use crate::socket::{has_gone, look, say};
use crate::spin::Spin;
use crate::stream::{Read, Source};

/// Bytes that are copied out at a time.
const PIECE: usize = 32 * 1024;

/// Takes bytes out of the ring. Read by one thread at a time, which its owner sees to.
#[derive(Debug)]
pub struct Reader {
    map: Map,
    control: UnixStream,
    /// Bytes taken: what is in the shared memory is for the writer only.
    taken: AtomicU64,
    /// The writer knows of these: it is told before this side waits, or when it may need the room.
    told: AtomicU64,
    spin: Spin,
    /// A sender asks for nothing.
    nothing: Asked,
}

impl Reader {
    /// Of a ring that nobody has read.
    pub fn new(map: Map, control: UnixStream) -> Self {
        Self {
            map,
            control,
            taken: AtomicU64::new(0),
            told: AtomicU64::new(0),
            spin: Spin::default(),
            nothing: Asked::default(),
        }
    }

    /// Bytes that wait; none when the writer says what cannot be.
    fn waiting(&self) -> Option<usize> {
        let written = self.map.count(WRITTEN).load(Ordering::Acquire);
        let waiting = written.wrapping_sub(self.taken.load(Ordering::Relaxed));
        let waiting = usize::try_from(waiting).ok();
        waiting.filter(|waiting| *waiting <= self.map.ring())
    }

    /// Takes what is there, of so many bytes; false when there is nothing.
    fn take(&self, into: &mut BytesMut, limit: usize) -> io::Result<bool> {
        let waiting = self.waiting().ok_or_else(|| {
            let text = "it says that it has written more than the ring holds";
            io::Error::new(io::ErrorKind::InvalidData, text)
        })?;
        let room = into.capacity() - into.len();
        let length = waiting.min(limit).min(room).min(PIECE);
        if length == 0 {
            return Ok(false);
        }
        let begin = self.taken.load(Ordering::Relaxed);
        self.map.copy_out(begin, length, into);
        let taken = begin.wrapping_add(length as u64);
        self.taken.store(taken, Ordering::Relaxed);
        if taken.wrapping_sub(self.told.load(Ordering::Relaxed)) >= untold(&self.map) {
            self.tell();
        }
        Ok(true)
    }

    /// Tells the writer what was taken.
    fn tell(&self) {
        let taken = self.taken.load(Ordering::Relaxed);
        if self.told.swap(taken, Ordering::Relaxed) != taken {
            self.writer().tell(self.map.count(TAKEN), taken);
        }
    }

    fn writer(&self) -> Sleep<'_> {
        Sleep {
            word: self.map.word(WRITER),
            control: self.control.as_fd(),
            spin: &self.spin,
        }
    }

    fn here(&self) -> Sleep<'_> {
        Sleep {
            word: self.map.word(READER),
            control: self.control.as_fd(),
            spin: &self.spin,
        }
    }
}

/// So much may be taken without telling the writer.
fn untold(map: &Map) -> u64 {
    map.ring() as u64 / 8
}

impl Source for Reader {
    fn read(
        &self,
        into: &mut BytesMut,
        limit: usize,
        patience: Option<Duration>,
    ) -> io::Result<Read> {
        if self.take(into, limit)? {
            return Ok(Read::Some);
        }
        self.tell();
        if let Some(patience) = patience.filter(|patience| !patience.is_zero()) {
            // A count that cannot be is one to look at.
            let ready = || self.waiting() != Some(0);
            self.here().wait(patience, ready)?;
            if self.take(into, limit)? {
                return Ok(Read::Some);
            }
        }
        let has_gone = look(self.control.as_fd(), &self.nothing).is_some();
        // What was written before its end is still there.
        match (self.take(into, limit)?, has_gone) {
            (true, _) => Ok(Read::Some),
            (false, true) => Ok(Read::End),
            (false, false) => Ok(Read::Nothing),
        }
    }

    fn say(&self, byte: u8) -> bool {
        say(self.control.as_fd(), byte)
    }

    fn has_gone(&self) -> bool {
        has_gone(self.control.as_fd())
    }

    fn shut(&self) {
        let _ = self.control.shutdown(std::net::Shutdown::Both);
        self.here().wake_here();
    }
}
