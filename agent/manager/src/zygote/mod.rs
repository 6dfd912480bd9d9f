//! The zygote: a process with one thread that has started once, and whose copies become managers without starting anew.
//!
//! It holds no state. Its copies are children of the agent, so that nothing of a manager depends on its life: see
//! `copy`. A copy waits for its name (`identity`) with its threads running, and then is what a spawned manager is.

mod copy;
mod identity;
mod title;

use std::ffi::{OsStr, OsString};
use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::process::ExitCode;

use rts_host::identity::boot_id;
use rts_manager_api::passing;
use rts_manager_api::zygote::{Fork, FromZygote, MAX_DATAGRAM, ZYGOTE_VERSION, decode};

use crate::server::{self, Waiting};
use copy::{Copier, Copy};
use identity::Identity;
use title::Title;

/// Serves an agent until its socket ends; in a copy, until that manager ends. `home` is shown only.
pub fn run(home: &OsStr) -> ExitCode {
    let title = Title::find();
    let show = |what: &str, name| title.show(name, [OsStr::new(what), "--home".as_ref(), home]);
    show("--zygote", c"rts-zygote");
    match serve() {
        Ok(Some(copy)) => {
            if copy.waits {
                show("--idle", c"rts-idle");
            }
            crate::finish(live(copy, &title))
        }
        Ok(None) => ExitCode::SUCCESS,
        Err(error) => {
            crate::log::error(format_args!("the zygote ends: {error}"));
            ExitCode::FAILURE
        }
    }
}

/// What a copy knows of itself.
struct Own {
    control: UnixStream,
    /// It is not told at once who it is.
    waits: bool,
}

/// Answers orders. In a copy it gives what that knows of itself, in the zygote nothing, at the end.
fn serve() -> io::Result<Option<Own>> {
    let socket = server::take_stdin()?.ok_or_else(|| bad("standard input is no socket"))?;
    // Read once, for all copies.
    let _ = boot_id();
    let copier = Copier::new()?;
    let version = ZYGOTE_VERSION;
    tell(&socket, &FromZygote::Ready { version }, None)?;
    let mut datagram = [0; MAX_DATAGRAM];
    loop {
        let (length, files) = passing::receive(&socket, &mut datagram)?;
        if length == 0 {
            return Ok(None);
        }
        let order: Fork = decode(&datagram[..length])?;
        let mut files = files.into_iter();
        let (Some(control), cgroup) = (files.next(), files.next().filter(|_| order.cgroup)) else {
            return Err(bad("an order came without its socket"));
        };
        match copier.copy(cgroup.as_ref().map(AsFd::as_fd)) {
            Ok(Copy::Own) => {
                let (control, waits) = (settle(control)?, order.waits);
                return Ok(Some(Own { control, waits }));
            }
            Ok(Copy::Other {
                pid,
                pidfd,
                in_cgroup,
            }) => tell(
                &socket,
                &FromZygote::Forked { pid, in_cgroup },
                Some(&pidfd),
            )?,
            Err(error) => {
                let reason = error.to_string();
                tell(&socket, &FromZygote::Failed { reason }, None)?;
            }
        }
    }
}

fn tell(socket: &UnixStream, what: &FromZygote, file: Option<&OwnedFd>) -> io::Result<()> {
    let files: Vec<_> = file.into_iter().map(AsFd::as_fd).collect();
    passing::send(socket, &serde_json::to_vec(what)?, &files)?;
    Ok(())
}

/// Makes a copy the leader of a process group, as a spawned manager is.
fn settle(control: OwnedFd) -> io::Result<UnixStream> {
    rustix::process::setpgid(None, None)?;
    let control = UnixStream::from(control);
    control.set_nonblocking(false)?;
    Ok(control)
}

/// The life of a copy: it waits to be told who it is, and is that.
fn live(own: Own, title: &Title) -> Result<crate::manager::Leftovers, crate::ServeError> {
    let Own { control, waits } = own;
    let waiting = Waiting::prepare()?;
    if waits {
        waiting.start_threads();
    }
    let named = identity::wait(&control, waiting.ends());
    let Some(Identity { settings, log }) = named.map_err(server::process("learn who it is"))?
    else {
        // Nobody wants it any more.
        return Ok(crate::manager::Leftovers::None);
    };
    identity::take_on(&settings.dir, log).map_err(server::process("take its log and folder"))?;
    let words: Vec<OsString> = settings.words();
    title.show(c"rts-manager", words.iter().map(OsString::as_os_str));
    waiting.serve(settings, Some(control))
}

fn bad(text: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, text)
}
