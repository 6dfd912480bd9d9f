//! Standard input and output as streams.

use std::io;
use std::os::fd::OwnedFd;

use rustix::stdio::{stdin, stdout};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::unix::pipe;

/// What can be read from.
pub(super) type Input = Box<dyn AsyncRead + Send + Unpin>;
/// What can be written to.
pub(super) type Output = Box<dyn AsyncWrite + Send + Unpin>;

/// Those of this process: pipes, as `sshd` gives them, are waited for; anything else is read and written by threads.
pub(super) fn own() -> (Input, Output) {
    (
        input().unwrap_or_else(|_| Box::new(tokio::io::stdin())),
        output().unwrap_or_else(|_| Box::new(tokio::io::stdout())),
    )
}

fn input() -> io::Result<Input> {
    let pipe: OwnedFd = rustix::io::dup(stdin())?;
    Ok(Box::new(pipe::Receiver::from_owned_fd(pipe)?))
}

fn output() -> io::Result<Output> {
    let pipe: OwnedFd = rustix::io::dup(stdout())?;
    Ok(Box::new(pipe::Sender::from_owned_fd(pipe)?))
}
