//! Describing a module, in a process that does nothing else: its initialisers may hang or crash.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::sync::mpsc::sync_channel;
use std::thread;
use std::time::Duration;

use crate::log;
use crate::module::{LoadError, Module};

/// An initialiser that runs for longer hangs.
const LIMIT: Duration = Duration::from_secs(10);

/// A module that cannot be described.
#[derive(Debug, thiserror::Error)]
pub enum DescribeError {
    /// It cannot be opened or is not usable.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// Nothing would end it.
    #[error("cannot watch over the module: {0}")]
    Watch(#[source] io::Error),
    /// The description cannot be written.
    #[error("cannot print the description: {0}")]
    Print(#[from] io::Error),
}

/// Opens a module and prints what it says of itself as one JSON object.
pub fn describe(file: &Path, type_name: &str) -> Result<(), DescribeError> {
    // What the library itself prints must not mix with the description.
    let stdout = rustix::io::fcntl_dupfd_cloexec(rustix::stdio::stdout(), 3);
    let mut stdout = File::from(stdout.map_err(io::Error::from)?);
    rustix::stdio::dup2_stdout(rustix::stdio::stderr()).map_err(io::Error::from)?;
    let shown = file.display().to_string();
    let (begun, has_begun) = sync_channel(1);
    let watch = thread::Builder::new().spawn(move || {
        let _ = begun.send(());
        end_late(&shown);
    });
    watch.map_err(DescribeError::Watch)?;
    // A thread that begins while a library is opened waits for that.
    let _ = has_begun.recv();
    // A bare name would be searched in the system's library paths.
    let module = Module::load(&std::path::absolute(file)?, type_name)?;
    let mut json = serde_json::to_vec(&module.info()).map_err(io::Error::from)?;
    json.push(b'\n');
    Ok(stdout.write_all(&json)?)
}

/// Ends the process when the module has taken too long: who asks by hand should not wait for ever.
fn end_late(file: &str) {
    thread::sleep(LIMIT);
    log::plain(format_args!(
        "{file} was not described within {} s: an initialiser of the library hangs",
        LIMIT.as_secs()
    ));
    // Past the exit handlers, which wait for what hangs.
    signal_hook::low_level::exit(1);
}
