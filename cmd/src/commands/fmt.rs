//! `rtsctl fmt`.

use std::path::{Path, PathBuf};

use rts_schemas::canonical::{Canonical, canonical};
use rts_schemas::diagnostic::{Report, Severity};

use crate::error::CliError;
use crate::exit::Exit;
use crate::input;
use crate::local::plural;
use crate::output::Output;
use crate::save;
use crate::show::findings;

mod unified;

/// Bring profiles into canonical form: one element or key a line, in UTF-8
///
/// Prints the result; `--write` puts it back into the files. RTS and RTC Profiles are formatted, in XML and in YAML. In XML
/// everything stays that the file says: elements and attributes in their order, comments, processing instructions, prefixes,
/// and whatever no schema knows. YAML with comments and deployment overlays are refused, since they would lose something.
/// A file that is refused stays as it is.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:\n  \
    1    with --check: a file is not in canonical form\n  \
    3    a file cannot be read, or would lose something")]
pub struct Args {
    /// RTS or RTC Profiles (XML or YAML); `-` is standard input
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// Put the result back into each file, and print the names of those that changed
    #[arg(short, long, conflicts_with_all = ["check", "diff", "out"])]
    write: bool,
    /// Put the result into this file
    #[arg(long, value_name = "FILE", conflicts_with_all = ["check", "diff"])]
    out: Option<PathBuf>,
    /// Change nothing; print the names of files that are not in canonical form, and exit 1 if there are any
    #[arg(long)]
    check: bool,
    /// Change nothing; show what would change
    #[arg(long)]
    diff: bool,
}

/// Formats.
pub fn run(args: &Args, out: &Output) -> Result<Exit, CliError> {
    let one_by_one = args.write || args.check || args.diff;
    if args.files.len() > 1 && !one_by_one {
        return Err(CliError::usage_help(
            "several files cannot be printed as one",
            "`--write` puts each result back into its file; `--check` and `--diff` change nothing",
        ));
    }
    let stdin = args
        .files
        .iter()
        .filter(|path| input::is_stdin(path))
        .count();
    if stdin > 0 && args.write {
        let help = "leave out --write: the result is printed";
        return Err(CliError::usage_help(
            "standard input cannot be written to",
            help,
        ));
    }
    if stdin > 1 {
        return Err(CliError::usage("standard input can be read only once"));
    }
    let (mut different, mut refused) = (0, 0);
    for path in &args.files {
        match file(path, args, out) {
            Ok(changes) => different += usize::from(changes),
            // Of the other files each is formatted all the same.
            Err(Refused::Findings(report)) => {
                findings::print(&errors(report), out);
                refused += 1;
            }
            Err(Refused::Error(error @ CliError::Read { .. })) if args.files.len() > 1 => {
                out.error(&error, error.help().as_deref());
                refused += 1;
            }
            Err(Refused::Error(error)) => return Err(error),
        }
    }
    match refused {
        0 if args.check && different > 0 => Ok(Exit::Different),
        0 => Ok(Exit::Ok),
        _ => Err(CliError::NotFormatted {
            files: plural("file", refused),
        }),
    }
}

/// Why a file was not formatted.
enum Refused {
    /// It cannot be read, or would lose something.
    Findings(Report),
    /// The program cannot go on.
    Error(CliError),
}

impl From<CliError> for Refused {
    fn from(error: CliError) -> Self {
        Self::Error(error)
    }
}

/// One file; true when it is not in canonical form.
fn file(path: &Path, args: &Args, out: &Output) -> Result<bool, Refused> {
    let name = input::shown(path);
    let bytes = input::read(path)?;
    let made = canonical(&name, &bytes).map_err(Refused::Findings)?;
    let changes = made.text.as_bytes() != bytes;
    if args.check || args.diff {
        if changes && args.check {
            out.result(&name)?;
        }
        if changes && args.diff {
            out.result(&unified::diff(&name, made.source.text(), &made.text))?;
        }
    } else if args.write {
        if changes {
            save::rewrite(path, &made.text)?;
            out.result(&name)?;
        }
    } else if let Some(target) = &args.out {
        save::save(target, &made.text)?;
    } else {
        out.document(&made.text)?;
    }
    if changes {
        encoding(&name, &bytes, &made, out);
    }
    Ok(changes)
}

/// Says what the eye does not see in the text.
fn encoding(name: &str, bytes: &[u8], made: &Canonical, out: &Output) {
    if made.encoding != "UTF-8" {
        out.say(&format!("{name}: {} becomes UTF-8", made.encoding));
    } else if bytes.starts_with(b"\xef\xbb\xbf") {
        out.say(&format!("{name}: the byte order mark goes"));
    }
}

/// Warnings are for `check`: what they speak of is kept.
fn errors(mut report: Report) -> Report {
    report
        .findings
        .retain(|finding| finding.severity == Severity::Error);
    report
}
