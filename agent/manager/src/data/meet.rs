//! Meeting over TCP. Both ends have agreed over a Unix socket, where they know each other; there the in-port end names
//! a place where it waits for this one connection, and a word by which it knows its peer.

use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::time::{Duration, Instant};

use rts_manager_api::data::Meeting;
use rts_manager_api::net::left;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

/// Who connects says the word at once; a stranger who says nothing is not waited for.
const WORD: Duration = Duration::from_millis(500);

/// A place where one connection is waited for.
pub struct Place {
    listener: TcpListener,
    /// What the other end is told.
    pub meeting: Meeting,
}

impl Place {
    /// A new one, on this machine, as nobody on a network is to be trusted without encryption.
    pub fn new() -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
        listener.set_nonblocking(true)?;
        let meeting = Meeting {
            address: listener.local_addr()?.to_string(),
            word: uuid::Uuid::new_v4().to_string(),
        };
        Ok(Self { listener, meeting })
    }

    /// Waits for the one who knows the word.
    pub fn wait(&self, until: Instant) -> io::Result<TcpStream> {
        loop {
            let left = left(until).ok_or(io::ErrorKind::TimedOut)?;
            let timeout = Timespec::try_from(left).ok();
            let mut fds = [PollFd::new(&self.listener, PollFlags::IN)];
            match poll(&mut fds, timeout.as_ref()) {
                Ok(_) | Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
            if let Ok((stream, _)) = self.listener.accept()
                && self.is_meant(&stream, left.min(WORD)).unwrap_or(false)
            {
                return Ok(stream);
            }
        }
    }

    fn is_meant(&self, mut stream: &TcpStream, patience: Duration) -> io::Result<bool> {
        stream.set_nonblocking(false)?;
        stream.set_read_timeout(Some(patience))?;
        let mut said = vec![0; self.meeting.word.len()];
        stream.read_exact(&mut said)?;
        Ok(said == self.meeting.word.as_bytes())
    }
}

/// Goes where the in-port end waits.
pub fn go(meeting: &Meeting, until: Instant) -> io::Result<TcpStream> {
    let invalid = |error| io::Error::new(io::ErrorKind::InvalidData, error);
    let address: SocketAddr = meeting.address.parse().map_err(invalid)?;
    let patience = left(until).ok_or(io::ErrorKind::TimedOut)?;
    let mut stream = TcpStream::connect_timeout(&address, patience)?;
    stream.set_write_timeout(Some(patience))?;
    stream.write_all(meeting.word.as_bytes())?;
    Ok(stream)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread;

    #[test]
    fn only_who_knows_the_word_is_met() {
        let place = Place::new().unwrap();
        let until = Instant::now() + Duration::from_secs(10);
        let meeting = place.meeting.clone();
        let stranger = Meeting {
            word: uuid::Uuid::new_v4().to_string(),
            ..meeting.clone()
        };
        let silent = TcpStream::connect(&meeting.address).unwrap();
        let _stranger = go(&stranger, until).unwrap();
        let met = thread::spawn(move || go(&meeting, until).unwrap());
        let theirs = place.wait(until).unwrap();
        let ours = met.join().unwrap();
        assert_eq!(theirs.peer_addr().unwrap(), ours.local_addr().unwrap());
        drop(silent);
        assert!(place.wait(Instant::now()).is_err(), "nobody else comes");
    }
}
