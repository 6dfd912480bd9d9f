//! What `ps` shows of this process: its name, and its command line, which is written anew where the kernel has put it.

#![allow(unsafe_code)]

use std::ffi::{CStr, OsStr};
use std::os::unix::ffi::OsStrExt;
use std::ptr;

/// Where the command line lies, and how much room there is. Nothing is shown where the kernel does not tell.
pub struct Title {
    place: Option<(usize, usize)>,
    program: Vec<u8>,
}

impl Title {
    /// Of this process.
    pub fn find() -> Self {
        let program = std::env::args_os().next().unwrap_or_default();
        Self {
            place: place(),
            program: program.as_bytes().to_vec(),
        }
    }

    /// Shows a name (`ps -o comm`), and the program with these arguments, as far as there is room.
    pub fn show<'a>(&self, name: &CStr, arguments: impl IntoIterator<Item = &'a OsStr>) {
        // A name that cannot be set is no reason not to run.
        let _ = rustix::thread::set_name(name);
        let Some((start, room)) = self.place else {
            return;
        };
        let text = text(&self.program, arguments, room);
        // SAFETY: `start` and `room` are the argument strings of this process, as the kernel tells: writable memory at the bottom
        // of the first thread's stack, as long as the process lives. The C library, Rust and modules have only pointers
        // to C strings in there; the last byte stays 0, so that reading any of them ends within it. No other thread
        // reads them: managers look at their arguments once, before this, and modules are opened after it.
        unsafe {
            let place = ptr::with_exposed_provenance_mut::<u8>(start);
            ptr::copy_nonoverlapping(text.as_ptr(), place, room);
        }
    }
}

/// The program and its arguments, each with a 0 behind it, cut and filled up to `room` bytes of which the last is 0: the
/// kernel then shows all of them as a command line.
fn text<'a>(
    program: &[u8],
    arguments: impl IntoIterator<Item = &'a OsStr>,
    room: usize,
) -> Vec<u8> {
    let mut text = [program, b"\0"].concat();
    for argument in arguments {
        text.extend_from_slice(argument.as_bytes());
        text.push(0);
    }
    text.truncate(room.saturating_sub(1));
    text.resize(room, 0);
    text
}

/// Fields 48 and 49 of `/proc/self/stat`.
fn place() -> Option<(usize, usize)> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(45);
    let mut next = || fields.next()?.parse::<usize>().ok();
    let (start, end) = (next()?, next()?);
    let room = end.checked_sub(start).filter(|room| *room > 0)?;
    // The command line as it can be read is what lies there.
    let shown = std::fs::read("/proc/self/cmdline").ok()?;
    (start > 0 && shown.len() == room).then_some((start, room))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_line_fills_its_room_and_ends_with_nothing() {
        let words = || ["--dir".as_ref(), OsStr::new("/a")];
        let show = |room| text(b"m", words(), room);
        assert_eq!(show(14), b"m\0--dir\0/a\0\0\0\0");
        assert_eq!(show(11), b"m\0--dir\0/a\0");
        assert_eq!(show(10), b"m\0--dir\0/\0");
        assert_eq!(show(1), b"\0");
        assert_eq!(show(0), b"");
    }
}
