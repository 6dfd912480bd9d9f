//! `rtsctl idl check`.

use rts_schemas::diagnostic::Report;
use rts_schemas::idl;

use super::files::Files;
use crate::commands::check::{Format, tell};
use crate::error::CliError;
use crate::exit::Exit;
use crate::input::{read, shown};
use crate::output::Output;

/// Find every mistake in IDL files and in what they include; nothing is changed
///
/// What is accepted, `omniidl` of omniORB accepts too. Exits 0 without an error, 1 when something is wrong in a file, and 3
/// when a file cannot be opened and read.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The files.
    #[command(flatten)]
    files: Files,
    /// How to print
    #[arg(short, long, value_name = "FORMAT", default_value = "text")]
    output: Format,
}

/// Checks each file on its own.
pub(super) fn run(args: &Args, out: &Output) -> Result<Exit, CliError> {
    let mut report = Report::default();
    let mut unreadable = None;
    for path in &args.files.files {
        let found = match read(path) {
            Ok(bytes) => idl::read(&shown(path), &bytes, &args.files.folders),
            Err(error) => {
                unreadable.get_or_insert(error);
                continue;
            }
        };
        let found = found.map_or_else(|report| report, |read| read.findings);
        // Several files may include the same one.
        for finding in found.findings {
            if !report.findings.contains(&finding) {
                report.push(finding);
            }
        }
    }
    tell(report, unreadable, args.output, None, out)
}
