//! How a copy learns which manager it is: the first frame of its control connection, with which its log file comes.

use std::env;
use std::io::{self, Read};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::Duration;

use rts_manager_api::frame;
use rts_manager_api::passing;
use rts_manager_api::zygote::{Become, MAX_BECOME};
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;

use crate::args::Settings;

/// Time for the rest of a frame that has begun: it is sent at once.
const REST: Duration = Duration::from_secs(5);

/// Who it is.
pub struct Identity {
    /// As on a command line.
    pub settings: Settings,
    /// For standard output and error.
    pub log: OwnedFd,
}

/// Waits for it; none when the connection ends before, or a signal wants the end.
pub fn wait(control: &UnixStream, ends: &UnixStream) -> io::Result<Option<Identity>> {
    loop {
        let mut fds = [
            PollFd::new(control, PollFlags::IN),
            PollFd::new(ends, PollFlags::IN),
        ];
        match poll(&mut fds, None) {
            Ok(_) => {}
            Err(Errno::INTR) => continue,
            Err(error) => return Err(error.into()),
        }
        let [named, ended] = fds.map(|fd| !fd.revents().is_empty());
        if ended {
            return Ok(None);
        }
        if named {
            return read(control);
        }
    }
}

fn read(control: &UnixStream) -> io::Result<Option<Identity>> {
    let bad = |text: &str| io::Error::new(io::ErrorKind::InvalidData, text);
    let mut header = [0; 4];
    let (count, files) = passing::receive(control, &mut header)?;
    if count == 0 {
        return Ok(None);
    }
    control.set_read_timeout(Some(REST))?;
    let mut reader = control;
    reader.read_exact(&mut header[count..])?;
    let length = u32::from_be_bytes(header) as usize;
    if length > MAX_BECOME {
        return Err(bad("it is longer than it may be"));
    }
    let mut body = vec![0; length];
    reader.read_exact(&mut body)?;
    control.set_read_timeout(None)?;
    let named: Become = frame::decode(&body).map_err(io::Error::other)?;
    let log = files.into_iter().next();
    Ok(Some(Identity {
        settings: named.into(),
        log: log.ok_or_else(|| bad("no log file came along"))?,
    }))
}

/// Takes its place: log and working folder.
pub fn take_on(dir: &Path, log: OwnedFd) -> io::Result<()> {
    rustix::stdio::dup2_stdout(&log)?;
    rustix::stdio::dup2_stderr(&log)?;
    env::set_current_dir(dir)
}
