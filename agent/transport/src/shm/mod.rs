//! Between processes of a machine: frames in a ring of shared memory.
//!
//! The sending end makes the ring as a memfd without a name, seals its size, and passes it over the Unix socket that
//! both ends have agreed on. The socket stays open: it carries the receiver's good-bye, wakes an end that has slept for
//! long, and tells the death of the other process. Nothing is left behind, however the processes end.
//!
//! The other process may write anything into the ring at any time. So nothing there is read twice, bytes are copied
//! out before they are looked at, and counts are checked against what they can be; who lies is lost.

pub mod layout;
mod map;
mod pass;
mod reader;
mod sleep;
mod writer;

use std::io;
use std::os::unix::net::UnixStream;

use crate::frame::Framing;
use crate::stream::{StreamReceiver, StreamSender};
use crate::{Receiver, Sender};
use map::Map;
use reader::Reader;
use writer::Writer;

/// Bytes of the ring, if nothing else is asked for. A larger sample travels in pieces.
pub const RING: usize = 1024 * 1024;

/// The sending end of a connection whose other end has agreed.
pub fn sender(control: UnixStream) -> io::Result<impl Sender + use<>> {
    sender_with(control, RING)
}

/// The sending end with a ring of so many bytes: a power of two within [`layout::SIZES`].
pub fn sender_with(control: UnixStream, ring: usize) -> io::Result<impl Sender + use<>> {
    let (map, memory) = Map::create(ring)?;
    control.set_nonblocking(false)?;
    pass::send(&control, &memory)?;
    Ok(StreamSender::new(Writer::new(map, control), Framing::Timed))
}

/// The receiving end of a connection whose other end has agreed.
pub fn receiver(control: UnixStream) -> io::Result<impl Receiver + use<>> {
    control.set_nonblocking(false)?;
    let memory = pass::receive(&control)?;
    let map = Map::open(&memory)?;
    Ok(StreamReceiver::new(
        Reader::new(map, control),
        Framing::Timed,
    ))
}
