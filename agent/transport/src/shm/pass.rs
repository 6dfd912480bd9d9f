//! Passing the memory to the other process.

use std::io::{self, IoSlice, IoSliceMut};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, ReturnFlags, SendAncillaryBuffer,
    SendAncillaryMessage, SendFlags,
};

use super::layout::PASSES;
use crate::signal::timespec;

/// The sender passes the memory at once, so this is for a slow machine.
const PATIENCE: Duration = Duration::from_secs(2);

/// Passes memory as the first message.
pub fn send(control: &UnixStream, memory: &OwnedFd) -> io::Result<()> {
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut message = SendAncillaryBuffer::new(&mut space);
    let passed = [memory.as_fd()];
    message.push(SendAncillaryMessage::ScmRights(&passed));
    let flags = SendFlags::DONTWAIT | SendFlags::NOSIGNAL;
    rustix::net::sendmsg(control, &[IoSlice::new(&[PASSES])], &mut message, flags)?;
    Ok(())
}

/// The memory that the other end passes.
pub fn receive(control: &UnixStream) -> io::Result<OwnedFd> {
    let refused = |text: &str| io::Error::new(io::ErrorKind::InvalidData, text);
    wait(control)?;
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(4))];
    let mut message = RecvAncillaryBuffer::new(&mut space);
    let mut byte = [0];
    let flags = RecvFlags::DONTWAIT | RecvFlags::CMSG_CLOEXEC;
    let got = rustix::net::recvmsg(
        control,
        &mut [IoSliceMut::new(&mut byte)],
        &mut message,
        flags,
    )?;
    // All of them first, so that none stays open.
    let mut passed: Vec<OwnedFd> = Vec::new();
    for message in message.drain() {
        if let RecvAncillaryMessage::ScmRights(fds) = message {
            passed.extend(fds);
        }
    }
    if got.bytes == 0 {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    if byte != [PASSES] {
        return Err(refused("the other end passes memory of another layout"));
    }
    match passed.pop() {
        Some(memory) if passed.is_empty() && !got.flags.contains(ReturnFlags::CTRUNC) => Ok(memory),
        _ => Err(refused("the other end did not pass one memory")),
    }
}

fn wait(control: &UnixStream) -> io::Result<()> {
    let until = Instant::now() + PATIENCE;
    loop {
        let left = until.saturating_duration_since(Instant::now());
        let mut fds = [PollFd::new(control, PollFlags::IN)];
        match poll(&mut fds, timespec(left).as_ref()) {
            Ok(0) => {
                let text = "the other end passed no memory in time";
                return Err(io::Error::new(io::ErrorKind::TimedOut, text));
            }
            Ok(_) => return Ok(()),
            Err(Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
    }
}
