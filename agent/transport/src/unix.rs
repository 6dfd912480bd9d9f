//! Between processes of a machine: frames on a Unix socket. The kernel closes it with its process, so a death is seen
//! at once.

use std::io;
use std::os::unix::net::UnixStream;

use crate::frame::Framing;
use crate::socket::Socket;
use crate::stream::{StreamReceiver, StreamSender};
use crate::{Receiver, Sender};

/// The sending end of a connection whose other end has agreed.
pub fn sender(stream: UnixStream) -> io::Result<impl Sender + use<>> {
    Ok(StreamSender::new(
        Socket::new(stream.into())?,
        Framing::Timed,
    ))
}

/// The receiving end of a connection whose other end has agreed.
pub fn receiver(stream: UnixStream) -> io::Result<impl Receiver + use<>> {
    Ok(StreamReceiver::new(
        Socket::new(stream.into())?,
        Framing::Timed,
    ))
}

/// The sending end of a connection to who knows the frames of the manager protocol's version 1 only.
pub fn plain_sender(stream: UnixStream) -> io::Result<impl Sender + use<>> {
    let socket = Socket::new(stream.into())?;
    Ok(StreamSender::new(socket, Framing::Plain))
}

/// The receiving end of a connection from who knows the frames of the manager protocol's version 1 only.
pub fn plain_receiver(stream: UnixStream) -> io::Result<impl Receiver + use<>> {
    let socket = Socket::new(stream.into())?;
    Ok(StreamReceiver::new(socket, Framing::Plain))
}
