//! `rtsctl idl generate`.

use std::path::PathBuf;

use rts_schemas::diagnostic::{Report, Severity};
use rts_schemas::idl::{self, rust};

use super::files::Files;
use crate::error::CliError;
use crate::exit::Exit;
use crate::input::{read, shown};
use crate::local::plural;
use crate::output::Output;
use crate::save::save;
use crate::show::findings;

/// Write Rust types for the definitions of IDL files
///
/// The source is a module, or a part of one, of a crate that depends on `rts-runtime`. Included definitions are written
/// where they are needed; types that `rts_runtime::types` has are used from there. What ports cannot carry is left out, and
/// said. A component's build script can do the same: see docs/idl.md.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The files.
    #[command(flatten)]
    files: Files,
    /// File to write, which is replaced as a whole; `-` for stdout
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

/// Reads the files as one, and writes what they define.
pub(super) fn run(args: &Args, out: &Output) -> Result<Exit, CliError> {
    let names: Vec<String> = args.files.files.iter().map(|path| shown(path)).collect();
    let bytes: Vec<Vec<u8>> = args
        .files
        .files
        .iter()
        .map(|path| read(path))
        .collect::<Result<_, _>>()?;
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let files: Vec<(&str, &[u8])> = names
        .iter()
        .copied()
        .zip(bytes.iter().map(Vec::as_slice))
        .collect();
    let read = match idl::read_all(&files, &args.files.folders) {
        Ok(read) => read,
        Err(report) => return Err(refused(&names, &report, out)),
    };
    findings::print(&read.findings, out);
    let code = rust::generate(&read.unit, &names);
    for left_out in &code.left_out {
        let name = read.unit.definitions[left_out.definition].name();
        out.warn(&format!("`{name}` is left out: {}", left_out.reason));
    }
    match args.out.to_str() {
        Some("-") => out.result(&code.text)?,
        _ => save(&args.out, &code.text)?,
    }
    Ok(Exit::Ok)
}

fn refused(names: &[&str], report: &Report, out: &Output) -> CliError {
    findings::print(report, out);
    let errors = report
        .findings
        .iter()
        .filter(|found| found.severity == Severity::Error);
    CliError::NotConverted {
        files: names.join(", "),
        errors: plural("error", errors.count()),
    }
}
