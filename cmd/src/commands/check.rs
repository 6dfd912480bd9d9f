//! `rtsctl check`.

mod cycles;
mod explain;
mod files;
mod reached;

use std::path::PathBuf;

use clap::ValueEnum;
use rts_host::error::chain;
use rts_schemas::diagnostic::{Finding, Report, Severity};

use self::files::Files;
use crate::error::CliError;
use crate::exit::Exit;
use crate::local::home::Home;
use crate::local::nodes::Nodes;
use crate::local::plural;
use crate::output::Output;
use crate::show::findings;
use crate::show::sarif;

/// Find every mistake in a profile and its overlays; nothing is contacted or changed
///
/// FILE is an RTS Profile, or an RTC Profile, which is checked on its own. With --rtc the components of an RTS Profile are
/// held against the RTC Profiles of their types. Exits 0 without an error, 1 when something is wrong in a file, and 3 when
/// a file cannot be opened and read.
#[derive(Debug, clap::Args)]
#[command(
    override_usage = "rtsctl check [OPTIONS] FILE [-f OVERLAY]...\n       rtsctl check --explain [CODE]"
)]
pub struct Args {
    /// The profile (XML or YAML); `-` is standard input
    #[arg(value_name = "FILE", required_unless_present_any = ["files", "explain"])]
    file: Option<PathBuf>,
    /// The same, then deployment overlays (YAML, `kind: Deployment`); a later one wins
    #[arg(short = 'f', long = "file", value_name = "FILE", id = "files")]
    files: Vec<PathBuf>,
    /// RTC Profiles of the components: a file, or a folder that is searched for them (may be repeated)
    #[arg(long, value_name = "DIR")]
    rtc: Vec<PathBuf>,
    /// A node, or a host that is one: required components of other hosts are errors then (may be repeated)
    #[arg(long = "node", value_name = "NAME")]
    nodes: Vec<String>,
    /// Name of the system [default: the profile's]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// What else counts as an error
    #[arg(long, value_name = "WHAT")]
    deny: Option<Deny>,
    /// How to print
    #[arg(short, long, value_name = "FORMAT", default_value = "text")]
    output: Format,
    /// Say what a code means and how to mend it; without CODE list all codes
    #[arg(long, value_name = "CODE", num_args = 0..=1, conflicts_with_all = ["file", "files", "rtc", "nodes", "name", "deny", "output"])]
    explain: Option<Option<String>>,
}

/// What else counts as an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Deny {
    /// Warnings
    Warnings,
}

/// How to print what was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For people
    Text,
    /// JSON
    Json,
    /// SARIF 2.1.0, as code hosts read it
    Sarif,
}

/// Checks. Needs no home; where there is one, its nodes are known.
pub fn run(args: &Args, home: Option<&Home>, out: &Output) -> Result<Exit, CliError> {
    if let Some(code) = &args.explain {
        out.result(&explain::explain(code.as_deref())?)?;
        return Ok(Exit::Ok);
    }
    let mut named = args.file.iter().chain(&args.files);
    let Some(profile) = named.next() else {
        return Err(CliError::usage("no file is named"));
    };
    let files = Files {
        profile,
        overlays: named.collect(),
        rtc: &args.rtc,
        name: args.name.as_deref(),
        nodes: args.nodes.iter().map(String::as_str).collect(),
        home: home.and_then(|home| known(home, out)),
    };
    let (report, unreadable) = files.check(out)?;
    tell(report, unreadable, args.output, args.deny, out)
}

/// The nodes of a home; what cannot be read is no fault of the files that are checked.
fn known(home: &Home, out: &Output) -> Option<Nodes> {
    let nodes = Nodes::of(home);
    if let Err(e) = &nodes {
        out.warn(&format!(
            "the nodes of this home are not known: {}",
            chain(e)
        ));
    }
    nodes.ok()
}

/// Prints what was found, and says how the check ends.
pub(super) fn tell(
    mut report: Report,
    unreadable: Option<CliError>,
    output: Format,
    deny: Option<Deny>,
    out: &Output,
) -> Result<Exit, CliError> {
    if let Some(error) = unreadable.as_ref().filter(|_| output != Format::Text) {
        // Who reads only this must not take what could not be read for what is right.
        let help = "name a file that is there and can be read; what is said of the others holds";
        report.push(Finding::error("unreadable-file", error.line()).help(help));
    }
    let count = Count::of(&report);
    match output {
        Format::Text => out.result(&findings::text(&report))?,
        Format::Json => out.result(&format!("{:#}", count.document(&report)))?,
        Format::Sarif => out.result(&format!("{:#}", sarif::document(&report)))?,
    }
    if unreadable.is_none() || !report.findings.is_empty() {
        out.say(&count.line());
    }
    if let Some(error) = unreadable {
        return Err(error);
    }
    let denied = deny == Some(Deny::Warnings) && count.warnings > 0;
    Ok(match report.has_errors() || denied {
        true => Exit::Different,
        false => Exit::Ok,
    })
}

/// How many there are of each severity.
struct Count {
    errors: usize,
    warnings: usize,
    notes: usize,
    /// There are more, which are not shown.
    more: bool,
}

/// Stands for all findings that are not shown, and is none itself.
const MORE: &str = "too-many-problems";

impl Count {
    fn of(report: &Report) -> Self {
        let of = |severity| {
            let findings = report.findings.iter().filter(|f| f.code != MORE);
            findings.filter(|f| f.severity == severity).count()
        };
        Self {
            more: report.findings.iter().any(|f| f.code == MORE),
            errors: of(Severity::Error),
            warnings: of(Severity::Warning),
            notes: of(Severity::Note),
        }
    }

    fn line(&self) -> String {
        let counts = [
            ("error", self.errors),
            ("warning", self.warnings),
            ("note", self.notes),
        ];
        let said = counts.iter().filter(|(_, count)| *count > 0);
        let said: Vec<String> = said.map(|(noun, count)| plural(noun, *count)).collect();
        match said.as_slice() {
            [] => "no problem was found".to_owned(),
            said if self.more => format!("{}, and more that are not shown", said.join(", ")),
            said => said.join(", "),
        }
    }

    fn document(&self, report: &Report) -> serde_json::Value {
        serde_json::json!({
            "apiVersion": "rtsctl.dev/v1",
            "kind": "Report",
            "errors": self.errors,
            "warnings": self.warnings,
            "notes": self.notes,
            "findings": report.findings,
        })
    }
}
