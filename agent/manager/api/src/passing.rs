//! Messages with open files, over Unix sockets.

use std::io::{self, IoSlice, IoSliceMut};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

use rustix::io::retry_on_intr;
use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, ReturnFlags, SendAncillaryBuffer,
    SendAncillaryMessage, SendFlags,
};

/// Most files of one message.
pub const MAX_FILES: usize = 4;

/// Sends bytes, and files with the first of them. Gives how many bytes were taken: of a datagram all, of a stream perhaps
/// fewer. Whether it waits is a matter of the socket.
pub fn send(socket: impl AsFd, bytes: &[u8], files: &[BorrowedFd<'_>]) -> io::Result<usize> {
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(MAX_FILES))];
    let mut message = SendAncillaryBuffer::new(&mut space);
    let fits = files.len() <= MAX_FILES;
    if !fits || (!files.is_empty() && !message.push(SendAncillaryMessage::ScmRights(files))) {
        let text = "too many files for one message";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, text));
    }
    let bytes = [IoSlice::new(bytes)];
    let sent =
        retry_on_intr(|| rustix::net::sendmsg(&socket, &bytes, &mut message, SendFlags::NOSIGNAL))?;
    Ok(sent)
}

/// Receives into `bytes`. Gives how many there were, 0 at the end, and the files that came with them. What does not fit
/// is an error.
pub fn receive(socket: impl AsFd, bytes: &mut [u8]) -> io::Result<(usize, Vec<OwnedFd>)> {
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(MAX_FILES))];
    let mut message = RecvAncillaryBuffer::new(&mut space);
    let mut bytes = [IoSliceMut::new(bytes)];
    let got = retry_on_intr(|| {
        rustix::net::recvmsg(&socket, &mut bytes, &mut message, RecvFlags::CMSG_CLOEXEC)
    })?;
    // All of them, so that none stays open.
    let mut files = Vec::new();
    for message in message.drain() {
        if let RecvAncillaryMessage::ScmRights(passed) = message {
            files.extend(passed);
        }
    }
    // The space is rounded up: one more than the most may have come.
    let cut = ReturnFlags::CTRUNC | ReturnFlags::TRUNC;
    if files.len() > MAX_FILES || got.flags.intersects(cut) {
        let text = "a message is longer than it may be";
        return Err(io::Error::new(io::ErrorKind::InvalidData, text));
    }
    Ok((got.bytes, files))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Read, Write};
    use std::os::unix::net::UnixStream;

    #[test]
    fn a_file_comes_with_the_bytes_it_was_sent_with() {
        let (a, b) = UnixStream::pair().unwrap();
        let (mut kept, passed) = UnixStream::pair().unwrap();
        assert_eq!(send(&a, b"take this", &[passed.as_fd()]).unwrap(), 9);
        drop(passed);
        let mut bytes = [0; 4];
        let (count, files) = receive(&b, &mut bytes).unwrap();
        assert_eq!((count, &bytes, files.len()), (4, b"take", 1));
        let (count, none) = receive(&b, &mut bytes).unwrap();
        assert_eq!((count, none.len()), (4, 0));
        kept.write_all(b"x").unwrap();
        let mut read = [0];
        let mut came = UnixStream::from(files.into_iter().next().unwrap());
        came.read_exact(&mut read).unwrap();
        assert_eq!(read, *b"x");
        drop(a);
        assert_eq!(receive(&b, &mut bytes).unwrap().0, 1);
        assert_eq!(receive(&b, &mut bytes).unwrap().0, 0);
    }

    #[test]
    fn too_many_files_are_refused_and_none_stays_open() {
        let (a, b) = UnixStream::pair().unwrap();
        let many = [a.as_fd(); MAX_FILES + 1];
        assert!(send(&a, b"x", &many).is_err());
        // Somebody else sends more than is expected.
        let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(8))];
        let mut message = SendAncillaryBuffer::new(&mut space);
        let eight = [a.as_fd(); 8];
        assert!(message.push(SendAncillaryMessage::ScmRights(&eight)));
        let flags = SendFlags::empty();
        rustix::net::sendmsg(&a, &[IoSlice::new(b"x")], &mut message, flags).unwrap();
        assert!(receive(&b, &mut [0; 8]).is_err());
    }
}
