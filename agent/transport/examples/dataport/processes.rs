//! Rows of two processes.

use std::net::{TcpListener, TcpStream};
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::process::{Child, Command, Stdio};

use rts_transport::Kind;

use crate::bytes_of::Payloads;
use crate::link::{Link, Transported};
use crate::plain::Plain;
use crate::ring::{self, Rings};

/// The other process answers this many samples with one.
pub type Mode = u64;

/// A process that answers.
pub struct Peer {
    pub link: Box<dyn Link>,
    child: Child,
}

impl Peer {
    pub fn start(name: &str, size: usize, mode: Mode) -> Self {
        let (link, [first, second]): (Box<dyn Link>, _) = match name {
            "floor-ring" => {
                let memory = ring::memory();
                let link = Rings::new(&memory, size, false);
                (Box::new(link), [Some(memory), None])
            }
            "floor-uds" => {
                let (ours, theirs) = UnixStream::pair().unwrap();
                (
                    Box::new(Plain::new(ours, size)),
                    [Some(theirs.into()), None],
                )
            }
            "floor-tcp" => {
                let (ours, theirs) = tcp();
                (
                    Box::new(Plain::new(ours, size)),
                    [Some(theirs.into()), None],
                )
            }
            name => {
                let (link, child) = transported(name.parse().unwrap(), size, mode);
                return Self {
                    link: Box::new(link),
                    child,
                };
            }
        };
        let child = start(name, size, mode, [first, second]);
        Self { link, child }
    }
}

/// A process at the other end of a transport.
pub fn transported(kind: Kind, size: usize, mode: Mode) -> (Transported, Child) {
    let (out, theirs) = sockets(kind);
    let (back, their_back) = sockets(kind);
    let sender = kind.sender(out).unwrap();
    let child = start(kind.name(), size, mode, [Some(theirs), Some(their_back)]);
    let link = Transported {
        sender,
        receiver: kind.receiver(back).unwrap(),
        payloads: Payloads::new(size),
    };
    (link, child)
}

impl Drop for Peer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn start(name: &str, size: usize, mode: Mode, fds: [Option<OwnedFd>; 2]) -> Child {
    let [stdin, stdout] = fds.map(|fd| fd.map_or_else(Stdio::null, Stdio::from));
    Command::new(std::env::current_exe().unwrap())
        .args(["child", name, &size.to_string(), &mode.to_string()])
        .stdin(stdin)
        .stdout(stdout)
        .spawn()
        .unwrap()
}

fn sockets(kind: Kind) -> (OwnedFd, OwnedFd) {
    if kind == Kind::Tcp {
        let (ours, theirs) = tcp();
        return (ours.into(), theirs.into());
    }
    let (ours, theirs) = UnixStream::pair().unwrap();
    (ours.into(), theirs.into())
}

fn tcp() -> (TcpStream, TcpStream) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let ours = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
    let theirs = listener.accept().unwrap().0;
    ours.set_nodelay(true).unwrap();
    theirs.set_nodelay(true).unwrap();
    (ours, theirs)
}

/// The other process.
pub fn play(name: &str, size: usize, mode: Mode) {
    let stdin = std::io::stdin().as_fd().try_clone_to_owned().unwrap();
    let stdout = || std::io::stdout().as_fd().try_clone_to_owned().unwrap();
    let mut link: Box<dyn Link> = match name {
        "floor-ring" => Box::new(Rings::new(&stdin, size, true)),
        "floor-uds" => Box::new(Plain::new(UnixStream::from(stdin), size)),
        "floor-tcp" => Box::new(Plain::new(TcpStream::from(stdin), size)),
        name => {
            let kind: Kind = name.parse().unwrap();
            Box::new(Transported {
                sender: kind.sender(stdout()).unwrap(),
                receiver: kind.receiver(stdin).unwrap(),
                payloads: Payloads::new(size),
            })
        }
    };
    let (mut received, mut sent) = (0, 0);
    while link.receive(received) {
        received += 1;
        if received.is_multiple_of(mode) {
            link.send(sent);
            sent += 1;
        }
    }
}
