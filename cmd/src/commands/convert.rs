//! `rtsctl convert`.

mod profile;
mod set_up;

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use rts_schemas::diagnostic::{Finding, Report, Severity, render};
use rts_schemas::form::Format;
use rts_schemas::{rtc_profile, rts_profile};

use crate::error::CliError;
use crate::exit::Exit;
use crate::local::plural;
use crate::output::Output;
use crate::save::save;
use crate::show::findings;

/// Convert a profile into the other format or another version, or rtc.conf files into a profile
///
/// An RTS or RTC Profile is written as XML or YAML, in its version or another. What that cannot say is an error; with
/// --force it is left out.
///
/// The `rtc.conf` files of a system, one for each manager, become one RTS Profile: components from precreate and their
/// configuration files, connectors from preconnect, the order of activation from preactivation. Which component is in
/// which manager goes into --overlay, or else into the profile. No controller is needed.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A profile (XML or YAML; `-` is standard input), or all rtc.conf files of one system
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// Format to write [default: as --out ends, else that of the file; XML for rtc.conf]
    #[arg(long, value_name = "FORMAT")]
    to: Option<To>,
    /// Version of an RTS Profile to write
    #[arg(long, value_name = "VERSION", conflicts_with = "rtc_version")]
    profile_version: Option<RtsVersion>,
    /// Version of an RTC Profile to write
    #[arg(long, value_name = "VERSION")]
    rtc_version: Option<RtcVersion>,
    /// File to write, which is replaced as a whole; `-` for stdout
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
    /// Overlay to write, with the managers of rtc.conf files
    #[arg(long, value_name = "FILE")]
    overlay: Option<PathBuf>,
    /// Folder with the RTC Profiles of the components in rtc.conf files
    #[arg(long, value_name = "DIR")]
    rtc: Option<PathBuf>,
    /// Name of the system in rtc.conf files [default: that of their folder]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Leave out what cannot be said
    #[arg(long)]
    force: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum To {
    /// XML
    Xml,
    /// YAML
    Yaml,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum RtsVersion {
    /// Connectors in their ports, order of start in the components
    #[value(name = "0.1")]
    V01,
    /// The usual one
    #[value(name = "0.2")]
    V02,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum RtcVersion {
    /// The oldest
    #[value(name = "0.1")]
    V01,
    /// The usual one
    #[value(name = "0.2")]
    V02,
    /// With event ports
    #[value(name = "0.3")]
    V03,
}

impl From<RtsVersion> for rts_profile::versions::Version {
    fn from(version: RtsVersion) -> Self {
        match version {
            RtsVersion::V01 => Self::V01,
            RtsVersion::V02 => Self::V02,
        }
    }
}

impl From<RtcVersion> for rtc_profile::versions::Version {
    fn from(version: RtcVersion) -> Self {
        match version {
            RtcVersion::V01 => Self::V01,
            RtcVersion::V02 => Self::V02,
            RtcVersion::V03 => Self::V03,
        }
    }
}

/// What came of it.
struct Made {
    text: String,
    overlay: Option<String>,
    report: Report,
}

/// Converts.
pub fn run(args: &Args, out: &Output) -> Result<Exit, CliError> {
    args.agree()?;
    let made = if args.files.iter().any(|file| is_conf(file)) {
        set_up::convert(args, out)?
    } else {
        profile::convert(args, out)?
    };
    let refused = tell(made.report, args.force, out);
    if refused > 0 {
        let files: Vec<String> = args
            .files
            .iter()
            .map(|file| file.display().to_string())
            .collect();
        return Err(CliError::NotConverted {
            files: files.join(", "),
            errors: plural("error", refused),
        });
    }
    if let (Some(path), Some(overlay)) = (&args.overlay, &made.overlay) {
        save(path, overlay)?;
        out.say(&format!("the managers are in {}", path.display()));
    }
    if args.out == Path::new("-") {
        out.document(&made.text)?;
    } else {
        save(&args.out, &made.text)?;
        out.result(&format!("written to {}", args.out.display()))?;
    }
    Ok(Exit::Ok)
}

/// Prints all that was found, and gives the number of errors that stand in the way.
fn tell(mut report: Report, force: bool, out: &Output) -> usize {
    if force {
        let errors = report.findings.iter_mut();
        let errors = errors.filter(|finding| finding.severity == Severity::Error);
        errors.for_each(|finding| finding.severity = Severity::Warning);
    }
    let (notes, others): (Vec<_>, Vec<_>) = report
        .findings
        .into_iter()
        .partition(|finding| finding.severity == Severity::Note);
    let is_error = |finding: &&Finding| finding.severity == Severity::Error;
    let errors = others.iter().filter(is_error).count();
    findings::print(&Report { findings: others }, out);
    // Nothing is left out without a word.
    notes.iter().for_each(|note| out.say(&render(note)));
    errors
}

impl Args {
    /// The format that is asked for.
    fn format(&self) -> Option<Format> {
        self.to.or(self.by_name()).map(|to| match to {
            To::Xml => Format::Xml,
            To::Yaml => Format::Yaml,
        })
    }

    /// The format that the name of the result says.
    fn by_name(&self) -> Option<To> {
        match self.out.extension()?.to_str()? {
            "xml" | "rtsys" | "rts" => Some(To::Xml),
            "yaml" | "yml" => Some(To::Yaml),
            _ => None,
        }
    }

    /// A file whose name says another format than it has misleads everybody after.
    fn agree(&self) -> Result<(), CliError> {
        match (self.to, self.by_name()) {
            (Some(to), Some(by_name)) if to != by_name => {
                let name = |to| match to {
                    To::Xml => "xml",
                    To::Yaml => "yaml",
                };
                let message = format!(
                    "--to says {}, but --out {} ends as {}",
                    name(to),
                    self.out.display(),
                    name(by_name)
                );
                let help = "leave out --to, or name the file after its format";
                Err(CliError::usage_help(message, help))
            }
            _ => Ok(()),
        }
    }
}

/// `rtc.conf`, `rtc_cpp.conf`, `rtc.conf.sample`.
fn is_conf(path: &Path) -> bool {
    let name = path
        .file_name()
        .map(|name| name.to_string_lossy().to_lowercase());
    name.is_some_and(|name| name.ends_with(".conf") || name.contains(".conf."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn configuration_files_are_known_by_their_names() {
        for name in ["rtc.conf", "a/RTC_cpp.CONF", "rtc.conf.sample"] {
            assert!(is_conf(Path::new(name)), "{name}");
        }
        for name in ["system.xml", "conf.yaml", "-", "a.conf/system.xml"] {
            assert!(!is_conf(Path::new(name)), "{name}");
        }
    }
}
