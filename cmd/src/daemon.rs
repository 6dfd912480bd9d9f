//! What controller and agent have in common as programs.

use std::io::{self, Write};

use rts_host::timing::{self, Recorder};
use tracing_subscriber::filter::{EnvFilter, FilterExt, filter_fn};
use tracing_subscriber::prelude::*;

/// Standard error. Whoever read it may have gone, which is no reason to end.
struct Log;

impl Write for Log {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let _ = io::stderr().write_all(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Logs to stderr, as `RTSCTL_LOG` says, and keeps where the time goes.
pub fn observe() {
    let level = EnvFilter::try_from_env("RTSCTL_LOG").unwrap_or_else(|_| EnvFilter::new("info"));
    let logged = level.and(filter_fn(|metadata| !timing::is_kept(metadata)));
    let log = tracing_subscriber::fmt::layer()
        .with_writer(|| Log)
        .with_ansi(false);
    tracing_subscriber::registry()
        .with(log.with_filter(logged))
        .with(Recorder.with_filter(filter_fn(timing::is_kept)))
        .init();
}
