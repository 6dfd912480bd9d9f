//! The writing side of the ring.

use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use super::layout::{READER, TAKEN, WRITER, WRITTEN};
use super::map::Map;
use super::sleep::Sleep;
use crate::ends::Asked;
use crate::socket::look;
use crate::spin::Spin;
use crate::stream::Sink;
use crate::{Ended, Question};

/// The reader is told after so many bytes, so that it copies out while more is copied in.
const PIECE: usize = 32 * 1024;

/// Puts bytes into the ring. Written to by one thread at a time, which its owner sees to.
#[derive(Debug)]
pub struct Writer {
    map: Map,
    control: UnixStream,
    /// Bytes written: what is in the shared memory is for the reader only.
    written: AtomicU64,
    /// Bytes that the reader had taken when last looked at.
    taken: AtomicU64,
    spin: Spin,
    asked: Asked,
}

impl Writer {
    /// Of an empty ring.
    pub fn new(map: Map, control: UnixStream) -> Self {
        Self {
            map,
            control,
            written: AtomicU64::new(0),
            taken: AtomicU64::new(0),
            spin: Spin::default(),
            asked: Asked::default(),
        }
    }

    /// Room for so many bytes. Also looked at by a thread that waits while another writes.
    fn room(&self) -> io::Result<usize> {
        // First, so that the other count is not an older one.
        let known = self.taken.load(Ordering::Acquire);
        let taken = self.map.count(TAKEN).load(Ordering::Acquire);
        self.taken.store(taken, Ordering::Release);
        let written = self.written.load(Ordering::Relaxed);
        let has_shrunk = written.wrapping_sub(taken) > written.wrapping_sub(known);
        let room = self.room_after(taken).filter(|_| !has_shrunk);
        room.ok_or_else(|| {
            let text = "it says that it has read what was not written";
            io::Error::new(io::ErrorKind::InvalidData, text)
        })
    }

    fn room_after(&self, taken: u64) -> Option<usize> {
        let waiting = self.written.load(Ordering::Relaxed).wrapping_sub(taken);
        let waiting = usize::try_from(waiting).ok()?;
        self.map.ring().checked_sub(waiting)
    }

    /// Copies what there is room for and tells nobody.
    fn put(&self, count: u64, bytes: &[u8], room: usize) -> usize {
        let length = bytes.len().min(room);
        self.map.copy_in(count, &bytes[..length]);
        length
    }

    fn reader(&self) -> Sleep<'_> {
        Sleep {
            word: self.map.word(READER),
            control: self.control.as_fd(),
            spin: &self.spin,
        }
    }

    fn here(&self) -> Sleep<'_> {
        Sleep {
            word: self.map.word(WRITER),
            control: self.control.as_fd(),
            spin: &self.spin,
        }
    }
}

impl Sink for Writer {
    fn write(&self, first: &[u8], then: &[u8]) -> io::Result<usize> {
        let wanted = (first.len() + then.len()).min(PIECE);
        // The reader's line of memory is read only when what is known of it is not enough.
        let known = self.room_after(self.taken.load(Ordering::Relaxed));
        let room = match known {
            Some(room) if room >= wanted => room,
            _ => self.room()?,
        };
        if room == 0 {
            return Ok(0);
        }
        let begin = self.written.load(Ordering::Relaxed);
        let mut length = self.put(begin, first, room);
        let rest = &then[..then.len().min(PIECE.saturating_sub(length))];
        length += self.put(begin + length as u64, rest, room - length);
        let written = begin + length as u64;
        self.written.store(written, Ordering::Relaxed);
        self.reader().tell(self.map.count(WRITTEN), written);
        Ok(length)
    }

    fn wait(&self, patience: Duration) -> io::Result<()> {
        let enough = enough(&self.map);
        // A count that cannot be is one to look at.
        self.here()
            .wait(patience, || self.room().is_ok_and(|room| room >= enough))
    }

    fn look(&self) -> Option<Ended> {
        look(self.control.as_fd(), &self.asked)
    }

    fn asked(&self) -> Option<Question> {
        self.asked.take()
    }

    fn shut(&self) {
        let _ = self.control.shutdown(std::net::Shutdown::Both);
        self.here().wake_here();
    }

    fn fd(&self) -> BorrowedFd<'_> {
        self.control.as_fd()
    }
}

/// A writer that waits for room is woken for so much at least, and not for each sample that is taken.
fn enough(map: &Map) -> usize {
    map.ring() / 4
}
