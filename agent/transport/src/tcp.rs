//! Between machines: frames on TCP. A peer that is gone without a word, with its machine or its cable, is lost after
//! some seconds; one whose process has died, at once.

use std::io;
use std::net::TcpStream;
use std::time::Duration;

use rustix::net::sockopt;

use crate::frame::Framing;
use crate::socket::Socket;
use crate::stream::{StreamReceiver, StreamSender};
use crate::{Receiver, Sender};

/// An idle connection asks the other end so often whether it is there.
const PROBE: Duration = Duration::from_secs(1);
/// So many questions may stay without an answer.
const PROBES: u32 = 3;
/// What was sent may stay without an answer so long, in milliseconds.
const SILENCE: u32 = 4000;

/// The sending end of a connection whose other end has agreed.
pub fn sender(stream: TcpStream) -> io::Result<impl Sender + use<>> {
    Ok(StreamSender::new(socket(stream)?, Framing::Timed))
}

/// The receiving end of a connection whose other end has agreed.
pub fn receiver(stream: TcpStream) -> io::Result<impl Receiver + use<>> {
    Ok(StreamReceiver::new(socket(stream)?, Framing::Timed))
}

fn socket(stream: TcpStream) -> io::Result<Socket> {
    sockopt::set_tcp_nodelay(&stream, true)?;
    sockopt::set_socket_keepalive(&stream, true)?;
    sockopt::set_tcp_keepidle(&stream, PROBE)?;
    sockopt::set_tcp_keepintvl(&stream, PROBE)?;
    sockopt::set_tcp_keepcnt(&stream, PROBES)?;
    sockopt::set_tcp_user_timeout(&stream, SILENCE)?;
    Socket::new(stream.into())
}
