//! Between processes of a machine: frames on a Unix socket. The kernel closes it with its process, so a death is seen
//! at once.

use std::io;
use std::os::unix::net::UnixStream;

use crate::socket::Socket;
use crate::stream::{StreamReceiver, StreamSender};
use crate::{Receiver, Sender};

/// The sending end of a connection whose other end has agreed.
pub fn sender(stream: UnixStream) -> io::Result<impl Sender + use<>> {
    Ok(StreamSender::new(Socket::new(stream.into())?))
}

/// The receiving end of a connection whose other end has agreed.
pub fn receiver(stream: UnixStream) -> io::Result<impl Receiver + use<>> {
    Ok(StreamReceiver::new(Socket::new(stream.into())?))
}
