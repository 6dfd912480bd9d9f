//! Reads the files that a verb names into one system, and prints everything that was found on the way.

mod stand_ins;

use std::io::Read;
use std::path::{Path, PathBuf};

use rts_controller_api::ClientError;
use rts_controller_api::requests::{ApplyRequest, Expect};
use rts_schemas::diagnostic::{Finding, Report, Severity};
use rts_schemas::overlay;
use rts_schemas::rts_profile::{self, Loaded, Places};

use crate::error::CliError;
use crate::local::plural;
use crate::output::Output;
use crate::saved::SavedPlan;
use crate::show::findings;

pub use self::stand_ins::StandInArgs;

/// Largest file that is read, in bytes.
pub const MAX_FILE: u64 = 128 * 1024 * 1024;

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
    /// Only this component or connector, and what it cannot be without; the rest stays as it is stored (may be repeated)
    #[arg(long = "target", value_name = "TARGET")]
    targets: Vec<String>,
    /// Stand-ins.
    #[command(flatten)]
    stand_ins: StandInArgs,
}

impl InputArgs {
    /// The same from another verb's arguments.
    pub fn of(
        file: PathBuf,
        overlays: Vec<PathBuf>,
        name: Option<String>,
        targets: Vec<String>,
    ) -> Self {
        Self {
            file: Some(file),
            files: overlays,
            name,
            replace: false,
            targets,
            stand_ins: StandInArgs::default(),
        }
    }

    /// Reads and checks the files. Findings are printed; with errors among them this fails.
    pub fn load(&self, out: &Output) -> Result<Input, CliError> {
        match self.load_any(out)? {
            Source::System(input) => Ok(*input),
            Source::Saved(_) => Err(CliError::usage_help(
                "the file is a saved plan, not a system",
                "`rtsctl apply PLAN` carries it out, `rtsctl explain PLAN` shows it",
            )),
        }
    }

    /// The same, or a saved plan.
    pub fn load_any(&self, out: &Output) -> Result<Source, CliError> {
        let mut files = self.file.iter().chain(&self.files);
        let Some(profile) = files.next() else {
            return Err(CliError::usage("no file is named"));
        };
        let overlays: Vec<_> = files.collect();
        if overlays.iter().filter(|p| is_stdin(p)).count() + usize::from(is_stdin(profile)) > 1 {
            return Err(CliError::usage("standard input can be read only once"));
        }
        let bytes = read(profile)?;
        if let Some(saved) = SavedPlan::read(&shown(profile), &bytes)? {
            self.alone(!overlays.is_empty())?;
            return Ok(Source::Saved(Box::new(saved)));
        }
        let mut loaded = self.files(profile, &bytes, &overlays, out)?;
        self.stand_ins.lay(&mut loaded.spec, out)?;
        Ok(Source::System(Box::new(Input {
            request: ApplyRequest {
                spec: loaded.spec,
                replace: self.replace,
                targets: self.targets.clone(),
                expect: self.stand_ins.expect(),
            },
            places: loaded.places,
        })))
    }

    /// A saved plan says all that these options could say.
    fn alone(&self, overlays: bool) -> Result<(), CliError> {
        let options = [
            ("overlays (-f)", overlays),
            ("--target", !self.targets.is_empty()),
            ("--name", self.name.is_some()),
            ("--replace", self.replace),
            ("--stand-ins", self.stand_ins.stand_ins),
            ("--rtc", !self.stand_ins.rtc.is_empty()),
        ];
        match options.iter().find(|(_, given)| *given) {
            None => Ok(()),
            Some((option, _)) => Err(CliError::usage_help(
                format!("a saved plan is applied as it is: it takes no {option}"),
                "give it to `rtsctl plan`, and save that plan",
            )),
        }
    }

    fn files(
        &self,
        profile: &Path,
        bytes: &[u8],
        overlays: &[&PathBuf],
        out: &Output,
    ) -> Result<Loaded, CliError> {
        let mut read_overlays = Vec::new();
        for path in overlays {
            let overlay = overlay::read_any(&shown(path), &read(path)?);
            read_overlays.push(overlay.map_err(|report| refuse(path, &report, out))?);
        }
        let name = self.name.as_deref();
        match rts_profile::load_with_places(&shown(profile), bytes, name, &read_overlays) {
            Ok(loaded) => {
                findings::print(&loaded.report, out);
                Ok(loaded)
            }
            Err(report) => Err(refuse(profile, &report, out)),
        }
    }
}

/// What a file holds.
#[derive(Debug, Clone)]
pub enum Source {
    /// A system.
    System(Box<Input>),
    /// A plan that `plan --out` wrote.
    Saved(Box<SavedPlan>),
}

/// A system that was read, and where its parts stand in its file.
#[derive(Debug, Clone)]
pub struct Input {
    /// What to ask of the controller.
    pub request: ApplyRequest,
    places: Places,
}

impl Input {
    /// What a saved plan asks for.
    pub fn saved(plan: &SavedPlan) -> Self {
        Self {
            request: plan.request(),
            places: Places::default(),
        }
    }

    /// The request without expectations of what runs, to be planned.
    pub fn planned(&self) -> ApplyRequest {
        ApplyRequest {
            expect: Expect {
                max_stand_ins: self.request.expect.max_stand_ins,
                ..Expect::default()
            },
            ..self.request.clone()
        }
    }

    /// For `map_err` behind a request with this input: the controller's faults are shown at their lines.
    pub fn failed(&self, what: impl Into<String>) -> impl FnOnce(ClientError) -> CliError + '_ {
        let what = what.into();
        move |error| match error {
            ClientError::Problem(mut problem) if !problem.errors.is_empty() => {
                let faults = std::mem::take(&mut problem.errors);
                let findings = faults.into_iter().map(|fault| Finding {
                    severity: Severity::Error,
                    place: self.place(&fault.pointer),
                    code: fault.code,
                    message: fault.detail,
                    help: fault.help,
                });
                let findings = Report {
                    findings: findings.collect(),
                };
                CliError::Refused {
                    what,
                    problem: Box::new(problem),
                    findings,
                }
            }
            other => CliError::request(what)(other),
        }
    }

    /// Of a JSON pointer into the request.
    fn place(&self, pointer: &str) -> Option<rts_schemas::diagnostic::Place> {
        self.places.find(pointer.strip_prefix("/spec")?).cloned()
    }
}

fn refuse(path: &Path, report: &Report, out: &Output) -> CliError {
    findings::print(report, out);
    let (file, errors) = blame(&shown(path), report);
    CliError::Invalid {
        file,
        errors: plural("error", errors),
    }
}

/// The file that the errors are in, which may be an overlay, and their number.
fn blame(profile: &str, report: &Report) -> (String, usize) {
    let findings = report.findings.iter();
    let errors: Vec<_> = findings.filter(|f| f.severity == Severity::Error).collect();
    let file = |finding: &&Finding| finding.place.as_ref().map(|place| place.file.clone());
    let first = errors.first().and_then(file);
    let same = errors.iter().all(|error| file(error) == first);
    let file = first.filter(|_| same);
    (file.unwrap_or_else(|| profile.to_owned()), errors.len())
}

pub(crate) fn is_stdin(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// The file's name in messages.
pub(crate) fn shown(path: &Path) -> String {
    if is_stdin(path) {
        "<stdin>".to_owned()
    } else {
        path.display().to_string()
    }
}

/// A whole file, within bounds.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, CliError> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use rts_controller_api::{Problem, ProblemError};

    const HELLO: &str = include_str!("../../manifests/hello/system.xml");

    fn input() -> Input {
        let loaded = rts_profile::load_with_places("hello.xml", HELLO.as_bytes(), None, &[]);
        let loaded = loaded.unwrap();
        Input {
            request: ApplyRequest::of(loaded.spec),
            places: loaded.places,
        }
    }

    #[test]
    fn the_controllers_faults_are_shown_at_their_lines() {
        let fault = |pointer: &str| ProblemError {
            pointer: pointer.to_owned(),
            code: "module-not-found".to_owned(),
            detail: "no module of type Printer".to_owned(),
            help: None,
        };
        let faults = vec![fault("/spec/components/2/type"), fault("")];
        let problem = Problem::invalid("module-not-found", "x").with_errors(faults);
        let error = input().failed("apply system/hello")(problem.into());
        assert_eq!(error.exit().code(), 3);
        assert_eq!(error.line(), "cannot apply system/hello: 2 errors");
        let CliError::Refused { findings, .. } = error else {
            panic!("{error:?}");
        };
        let place = findings.findings[0].place.as_ref().unwrap();
        assert!(place.text.contains("Printer:1.0"), "{place:?}");
        assert_eq!(findings.findings[1].place, None);
    }

    #[test]
    fn the_file_with_the_errors_is_blamed() {
        let overlay = "apiVersion: rtsctl.dev/v1\nkind: Deployment\nspec: {components: {X: {}}}\n";
        let overlay = overlay::read("lab.yaml", overlay.as_bytes()).unwrap();
        let report = rts_profile::load("hello.xml", HELLO.as_bytes(), None, &[overlay]);
        let blamed = blame("hello.xml", &report.unwrap_err());
        assert_eq!(blamed, ("lab.yaml".to_owned(), 1));
        let report = rts_profile::load("x.xml", b"<a/>", None, &[]).unwrap_err();
        assert_eq!(blame("x.xml", &report), ("x.xml".to_owned(), 1));
    }
}
