//! A connected socket as the way of frames. The receiving end sends single bytes: what it
//! fetches, and its good-bye.

use std::io::{self, IoSlice};
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use bytes::{BufMut, BytesMut};
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use rustix::net::sockopt::{Timeout, set_socket_timeout};
use rustix::net::{RecvFlags, SendAncillaryBuffer, SendFlags, Shutdown};

use crate::ends::Asked;
use crate::signal::timespec;
use crate::stream::{Read, Sink, Source};
use crate::{Ended, Question};

/// What a receiving end sends last.
pub(crate) const GOOD_BYE: u8 = b'B';

/// A connected stream socket.
#[derive(Debug)]
pub struct Socket {
    fd: OwnedFd,
    /// How long a read waits, in microseconds, as the kernel was told last.
    read_timeout: AtomicU64,
    asked: Asked,
}

impl Socket {
    /// Takes a connected socket.
    pub fn new(fd: OwnedFd) -> io::Result<Self> {
        rustix::io::ioctl_fionbio(&fd, false)?;
        set_socket_timeout(&fd, Timeout::Recv, None)?;
        Ok(Self {
            fd,
            read_timeout: AtomicU64::new(0),
            asked: Asked::default(),
        })
    }

    /// One system call waits and reads, so the kernel has to know how long.
    fn set_patience(&self, patience: Duration) -> io::Result<()> {
        // 0 is for ever to the kernel, and so is what it cannot count.
        let micros = u64::try_from(patience.as_micros()).unwrap_or(0);
        let micros = if micros > FOR_EVER { 0 } else { micros.max(1) };
        if self.read_timeout.swap(micros, Ordering::Relaxed) != micros {
            let timeout = (micros > 0).then(|| Duration::from_micros(micros));
            set_socket_timeout(&self.fd, Timeout::Recv, timeout)?;
        }
        Ok(())
    }
}

/// A year.
const FOR_EVER: u64 = 366 * 24 * 3600 * 1_000_000;

/// Reads of one look, so that one who never stops sending holds nobody up: the rest is for the next look.
const READS: u32 = 16;

/// What the receiving end of a connection has said.
pub(crate) fn look(fd: BorrowedFd<'_>, asked: &Asked) -> Option<Ended> {
    for _ in 0..READS {
        let mut bytes = [0; 64];
        return match rustix::net::recv(fd, &mut bytes, RecvFlags::DONTWAIT) {
            Ok((0, _)) => Some(Ended::lost("it closed the connection without a good-bye")),
            Ok((read, _)) if bytes[..read].contains(&GOOD_BYE) => Some(Ended::GoodBye),
            Ok((read, _)) => {
                let last = bytes[..read]
                    .iter()
                    .rev()
                    .find_map(|byte| Question::of(*byte));
                if let Some(question) = last {
                    asked.put(question);
                }
                continue;
            }
            Err(Errno::INTR) => continue,
            Err(Errno::AGAIN) => None,
            Err(error) => Some(Ended::lost(error)),
        };
    }
    None
}

/// True when the other end has closed the connection, whatever is still to be read.
pub(crate) fn has_gone(fd: BorrowedFd<'_>) -> bool {
    let mut fds = [PollFd::from_borrowed_fd(fd, PollFlags::RDHUP)];
    poll(&mut fds, timespec(Duration::ZERO).as_ref()).is_ok_and(|ready| ready > 0)
}

/// Says one byte to the sending end. Next to nothing is ever sent there, so there is room.
pub(crate) fn say(fd: BorrowedFd<'_>, byte: u8) -> bool {
    let flags = SendFlags::DONTWAIT | SendFlags::NOSIGNAL;
    rustix::net::send(fd, &[byte], flags).is_ok()
}

impl Sink for Socket {
    fn write(&self, first: &[u8], then: &[u8]) -> io::Result<usize> {
        let flags = SendFlags::DONTWAIT | SendFlags::NOSIGNAL;
        let parts = [IoSlice::new(first), IoSlice::new(then)];
        loop {
            let mut nothing = SendAncillaryBuffer::default();
            return match rustix::net::sendmsg(&self.fd, &parts, &mut nothing, flags) {
                Ok(written) => Ok(written),
                Err(Errno::AGAIN) => Ok(0),
                Err(Errno::INTR) => continue,
                Err(error) => Err(error.into()),
            };
        }
    }

    fn wait(&self, patience: Duration) -> io::Result<()> {
        let mut fds = [PollFd::new(&self.fd, PollFlags::OUT | PollFlags::IN)];
        match poll(&mut fds, timespec(patience).as_ref()) {
            Ok(_) | Err(Errno::INTR) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    fn look(&self) -> Option<Ended> {
        look(self.fd.as_fd(), &self.asked)
    }

    fn asked(&self) -> Option<Question> {
        self.asked.take()
    }

    fn shut(&self) {
        let _ = rustix::net::shutdown(&self.fd, Shutdown::Both);
    }

    fn fd(&self) -> BorrowedFd<'_> {
        self.fd.as_fd()
    }
}

impl Source for Socket {
    // The only way to read into memory that was not written before.
    #[allow(unsafe_code)]
    fn read(
        &self,
        into: &mut BytesMut,
        limit: usize,
        patience: Option<Duration>,
    ) -> io::Result<Read> {
        let flags = match patience {
            None | Some(Duration::ZERO) => RecvFlags::DONTWAIT,
            Some(patience) => {
                self.set_patience(patience)?;
                RecvFlags::empty()
            }
        };
        let spare = into.spare_capacity_mut();
        let limit = limit.min(spare.len());
        let read = match rustix::net::recv(&self.fd, &mut spare[..limit], flags) {
            Ok(((read, _), _)) => read.len(),
            Err(Errno::AGAIN | Errno::INTR) => return Ok(Read::Nothing),
            Err(error) => return Err(error.into()),
        };
        if read == 0 {
            return Ok(Read::End);
        }
        // SAFETY: the kernel has written so many bytes at the beginning of the spare capacity.
        unsafe { into.advance_mut(read) };
        Ok(Read::Some)
    }

    fn say(&self, byte: u8) -> bool {
        say(self.fd.as_fd(), byte)
    }

    fn has_gone(&self) -> bool {
        has_gone(self.fd.as_fd())
    }

    fn shut(&self) {
        let _ = rustix::net::shutdown(&self.fd, Shutdown::Both);
    }
}
