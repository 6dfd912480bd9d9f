//! Bytes on their way into a socket that may be full.

use std::io::{self, IoSlice};
use std::os::unix::net::UnixStream;

use bytes::{Buf, Bytes, BytesMut};
use rustix::io::Errno;
use rustix::net::{SendAncillaryBuffer, SendFlags, sendmsg};

use super::sample::Sample;

/// Small samples are gathered into writes of about this size.
const GATHER: usize = 64 * 1024;

/// What was begun and is not sent yet.
#[derive(Debug)]
pub struct Wire {
    /// Whether the time of writing goes with a sample.
    stamped: bool,
    head: BytesMut,
    /// A large payload behind it, which is not copied.
    tail: Bytes,
}

impl Wire {
    /// With nothing on it.
    pub fn new(stamped: bool) -> Self {
        Self {
            stamped,
            head: BytesMut::new(),
            tail: Bytes::new(),
        }
    }

    /// True when all was sent.
    pub fn is_empty(&self) -> bool {
        self.head.is_empty() && self.tail.is_empty()
    }

    /// True when more should be sent before more is put.
    pub fn is_full(&self) -> bool {
        !self.tail.is_empty() || self.head.len() >= GATHER
    }

    /// Puts a sample behind the rest, which must not be full.
    pub fn put(&mut self, sample: &Sample) {
        let extra = if self.stamped { 16 } else { 8 };
        let length = sample.payload.len() as u32 + extra;
        self.head.extend_from_slice(&length.to_be_bytes());
        self.head.extend_from_slice(&sample.sequence.to_be_bytes());
        if self.stamped {
            self.head.extend_from_slice(&sample.written.to_be_bytes());
        }
        if sample.payload.len() < GATHER / 2 {
            self.head.extend_from_slice(&sample.payload);
        } else {
            self.tail = sample.payload.clone();
        }
    }

    /// Puts a mark behind the rest, which must not be full.
    pub fn mark(&mut self, mark: [u8; 4]) {
        self.head.extend_from_slice(&mark);
    }

    /// Sends what the socket takes now; true when that was all.
    pub fn flush(&mut self, stream: &UnixStream) -> io::Result<bool> {
        let flags = SendFlags::DONTWAIT | SendFlags::NOSIGNAL;
        while !self.is_empty() {
            let parts = [IoSlice::new(&self.head), IoSlice::new(&self.tail)];
            match sendmsg(stream, &parts, &mut SendAncillaryBuffer::default(), flags) {
                Ok(sent) => self.advance(sent),
                Err(Errno::AGAIN) => return Ok(false),
                Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(true)
    }

    fn advance(&mut self, sent: usize) {
        let head = sent.min(self.head.len());
        self.head.advance(head);
        self.tail.advance(sent - head);
        if self.head.is_empty() {
            // Gives the room back that was read over.
            self.head.clear();
        }
    }
}
