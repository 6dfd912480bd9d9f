//! Agents for a real controller: one line of JSON when they serve, or why they do not.

use std::error::Error;
use std::io::{self, Write};
use std::process::ExitCode;

use serde_json::json;

use crate::served::{self, Served};

/// Serves until standard input is closed. Fails (2) when that cannot be.
pub(super) fn run(served: &Served) -> ExitCode {
    rts_host::limits::raise_open_files();
    match served::serve(served, || say(&json!({"ready": true}))) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let mut text = error.to_string();
            let mut source = error.source();
            while let Some(error) = source {
                text.push_str(&format!(": {error}"));
                source = error.source();
            }
            say(&json!({"ready": false, "error": text}));
            ExitCode::from(2)
        }
    }
}

fn say(line: &serde_json::Value) {
    // Whoever started this may have gone: then standard input is closed, too.
    let _ = writeln!(io::stdout().lock(), "{line}");
}
