//! Standard input and output as streams: pipes or sockets, as SSH servers give them.

use std::io;
use std::os::fd::OwnedFd;

use rustix::stdio::{stdin, stdout};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::UnixStream;
use tokio::net::unix::pipe;

/// What can be read from.
pub(super) type Input = Box<dyn AsyncRead + Send + Unpin>;
/// What can be written to.
pub(super) type Output = Box<dyn AsyncWrite + Send + Unpin>;

/// Those of this process. A file or a terminal is an error: whoever runs this by hand means something else.
pub(super) fn own() -> io::Result<(Input, Output)> {
    let (from, to) = (rustix::io::dup(stdin())?, rustix::io::dup(stdout())?);
    let input: Input = match pipe::Receiver::from_owned_fd(rustix::io::dup(&from)?) {
        Ok(pipe) => Box::new(pipe),
        Err(_) => Box::new(socket(from)?),
    };
    let output: Output = match pipe::Sender::from_owned_fd(rustix::io::dup(&to)?) {
        Ok(pipe) => Box::new(pipe),
        Err(_) => Box::new(socket(to)?),
    };
    Ok((input, output))
}

fn socket(fd: OwnedFd) -> io::Result<UnixStream> {
    let socket = std::os::unix::net::UnixStream::from(fd);
    let no_socket = |_| io::Error::other("standard input and output are neither pipes nor sockets");
    socket.local_addr().map_err(no_socket)?;
    socket.set_nonblocking(true)?;
    UnixStream::from_std(socket)
}
