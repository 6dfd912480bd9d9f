//! Reads the files that a verb names into one system, and prints everything that was found on the way.

use std::io::Read;
use std::path::{Path, PathBuf};

use rts_controller_api::requests::ApplyRequest;
use rts_schemas::diagnostic::{Report, Severity};
use rts_schemas::overlay;
use rts_schemas::rts_profile;
use rts_schemas::system::SystemSpec;

use crate::error::CliError;
use crate::local::plural;
use crate::output::Output;
use crate::show::findings;

/// Largest file that is read, in bytes.
const MAX_FILE: u64 = 64 * 1024 * 1024;

/// Which files describe the system.
#[derive(Debug, Clone, clap::Args)]
pub struct InputArgs {
    /// The RTS Profile (XML or YAML); `-` is standard input
    #[arg(value_name = "FILE", required_unless_present = "files")]
    file: Option<PathBuf>,
    /// The same, then deployment overlays (YAML, `kind: Deployment`); a later one wins
    #[arg(short = 'f', long = "file", value_name = "FILE", id = "files")]
    files: Vec<PathBuf>,
    /// Name of the system [default: the profile's]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Take the place of a system of the same name but another identity
    #[arg(long)]
    replace: bool,
}

impl InputArgs {
    /// Reads and checks the files. Findings are printed; with errors among them this fails.
    pub fn load(&self, out: &Output) -> Result<ApplyRequest, CliError> {
        let mut files = self.file.iter().chain(&self.files);
        let Some(profile) = files.next() else {
            return Err(CliError::usage("no file is named"));
        };
        let overlays: Vec<_> = files.collect();
        if overlays.iter().filter(|p| is_stdin(p)).count() + usize::from(is_stdin(profile)) > 1 {
            return Err(CliError::usage("standard input can be read only once"));
        }
        Ok(ApplyRequest {
            spec: self.spec(profile, &overlays, out)?,
            replace: self.replace,
        })
    }

    fn spec(
        &self,
        profile: &Path,
        overlays: &[&PathBuf],
        out: &Output,
    ) -> Result<SystemSpec, CliError> {
        let bytes = read(profile)?;
        let mut read_overlays = Vec::new();
        for path in overlays {
            let overlay = overlay::read(&shown(path), &read(path)?);
            read_overlays.push(overlay.map_err(|report| refuse(path, &report, out))?);
        }
        let name = self.name.as_deref();
        match rts_profile::load(&shown(profile), &bytes, name, &read_overlays) {
            Ok((spec, report)) => {
                findings::print(&report, out);
                Ok(spec)
            }
            Err(report) => Err(refuse(profile, &report, out)),
        }
    }
}

fn refuse(path: &Path, report: &Report, out: &Output) -> CliError {
    findings::print(report, out);
    let is_error = |severity| severity == Severity::Error;
    let errors = report
        .findings
        .iter()
        .filter(|f| is_error(f.severity))
        .count();
    CliError::Invalid {
        file: shown(path),
        errors: plural("error", errors),
    }
}

fn is_stdin(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// The file's name in messages.
fn shown(path: &Path) -> String {
    if is_stdin(path) {
        "<stdin>".to_owned()
    } else {
        path.display().to_string()
    }
}

/// A whole file, within bounds.
fn read(path: &Path) -> Result<Vec<u8>, CliError> {
    let failed = |source| CliError::Read {
        path: PathBuf::from(shown(path)),
        source,
    };
    let mut bytes = Vec::new();
    let count = if is_stdin(path) {
        let stdin = std::io::stdin().lock();
        stdin.take(MAX_FILE + 1).read_to_end(&mut bytes)
    } else {
        let file = std::fs::File::open(path).map_err(failed)?;
        file.take(MAX_FILE + 1).read_to_end(&mut bytes)
    };
    if count.map_err(failed)? as u64 > MAX_FILE {
        let text = format!("it has more than {MAX_FILE} bytes");
        return Err(failed(std::io::Error::new(
            std::io::ErrorKind::FileTooLarge,
            text,
        )));
    }
    Ok(bytes)
}
