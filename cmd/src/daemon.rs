//! What controller and agent have in common as programs.

use std::io::{self, Write};

use rts_host::timing::{self, Recorder};
use tracing_subscriber::filter::{FilterExt, LevelFilter, Targets, filter_fn};
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

/// Logs to stderr, as `RTSCTL_LOG` says (`debug`, or `info,rts_agent=trace`), and keeps where the time goes.
pub fn observe() {
    let said = std::env::var("RTSCTL_LOG").ok();
    let said = said.and_then(|said| said.parse::<Targets>().ok());
    let level = said.unwrap_or_else(|| Targets::new().with_default(LevelFilter::INFO));
    let logged = level.and(filter_fn(|metadata| !timing::is_kept(metadata)));
    let log = tracing_subscriber::fmt::layer()
        .with_writer(|| Log)
        .with_ansi(false);
    tracing_subscriber::registry()
        .with(log.with_filter(logged))
        .with(Recorder.with_filter(filter_fn(timing::is_kept)))
        .init();
}
