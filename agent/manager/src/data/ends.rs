//! Connections for tests.

use std::net::{TcpListener, TcpStream};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;

use rts_transport::{Kind, Receiver};

use super::sender::Agreed;

/// All transports between processes.
pub const BETWEEN: [Kind; 3] = [Kind::SharedMemory, Kind::Unix, Kind::Tcp];

/// Both ends of a transport, as when they have agreed.
pub fn pair(kind: Kind) -> (Agreed, Box<dyn Receiver>) {
    let (ours, theirs): (OwnedFd, OwnedFd) = match kind {
        Kind::Tcp => {
            let listener = TcpListener::bind("127.0.0.1:0").unwrap();
            let ours = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
            (ours.into(), listener.accept().unwrap().0.into())
        }
        _ => {
            let (ours, theirs) = UnixStream::pair().unwrap();
            (ours.into(), theirs.into())
        }
    };
    let agreed = Agreed {
        transport: kind.sender(ours).unwrap(),
        kind,
        is_version_1: false,
        ring: None,
        turn: None,
    };
    (agreed, kind.receiver(theirs).unwrap())
}

/// What the in-port end has agreed on with it.
pub fn agreed() -> super::receive::Agreed {
    super::receive::Agreed {
        has_common_clock: true,
        turn: None,
    }
}
