//! Where text goes: results to stdout, messages and errors to stderr, colour only where it is wanted.

use std::io::{self, IsTerminal, Write};
use std::os::fd::AsFd;
use std::time::Duration;

use anstream::{AutoStream, ColorChoice};
use anstyle::{AnsiColor, Style};
use rts_schemas::diagnostic::Severity;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::cli::{Color, Globals};
use crate::error::CliError;
use crate::exit::Exit;

const ERROR: Style = AnsiColor::Red.on_default().bold();
const HELP: Style = AnsiColor::Cyan.on_default().bold();
const WARNING: Style = AnsiColor::Yellow.on_default().bold();

/// Time between two looks whether somebody still reads.
const LOOK: Duration = Duration::from_millis(100);

/// True when the reader of a stream went away. Files, and terminals that are there, are always read.
fn is_unread(stream: impl AsFd) -> bool {
    let mut polled = [PollFd::new(&stream, PollFlags::empty())];
    let looked = poll(&mut polled, Some(&Timespec::default()));
    let ends = PollFlags::ERR | PollFlags::HUP | PollFlags::NVAL;
    looked.is_ok() && polled[0].revents().intersects(ends)
}

/// How a severity looks.
pub fn severity_style(severity: Severity) -> Style {
    match severity {
        Severity::Error => ERROR,
        Severity::Warning => WARNING,
        Severity::Note => HELP,
    }
}

/// The program's two streams and how much is said.
#[derive(Debug, Clone, Copy)]
pub struct Output {
    stdout: ColorChoice,
    stderr: ColorChoice,
    quiet: bool,
    verbose: u8,
}

impl Output {
    /// As the global options say.
    pub fn new(globals: &Globals) -> Self {
        let choice = match globals.color {
            Color::Auto => ColorChoice::Auto,
            Color::Always => ColorChoice::Always,
            Color::Never => ColorChoice::Never,
        };
        let settle = |auto| {
            if choice == ColorChoice::Auto {
                auto
            } else {
                choice
            }
        };
        Self {
            stdout: settle(AutoStream::choice(&io::stdout())),
            stderr: settle(AutoStream::choice(&io::stderr())),
            quiet: globals.quiet,
            verbose: globals.verbose,
        }
    }

    /// Results are coloured.
    pub fn stdout_color(&self) -> bool {
        self.stdout != ColorChoice::Never
    }

    /// Progress may be drawn over itself.
    pub fn animated(&self) -> bool {
        let dumb = std::env::var_os("TERM").is_some_and(|t| t == "dumb");
        !self.quiet && !dumb && io::stderr().is_terminal()
    }

    /// Ends when nobody can read stdout any more; what is written to it would only tell so later.
    pub async fn unread(&self) -> CliError {
        while !is_unread(io::stdout()) {
            tokio::time::sleep(LOOK).await;
        }
        CliError::Stdout(io::ErrorKind::BrokenPipe.into())
    }

    /// A result. Ends the line if the text does not.
    pub fn result(&self, text: &str) -> Result<(), CliError> {
        let mut stdout = AutoStream::new(io::stdout().lock(), self.stdout);
        stdout.write_all(text.as_bytes())?;
        if !text.ends_with('\n') && !text.is_empty() {
            stdout.write_all(b"\n")?;
        }
        Ok(stdout.flush()?)
    }

    /// What is drawn on a terminal, with the codes that move about on it.
    pub fn screen(&self, text: &str) -> Result<(), CliError> {
        let mut stdout = io::stdout().lock();
        stdout.write_all(text.as_bytes())?;
        Ok(stdout.flush()?)
    }

    /// A file that is printed: to the byte what it would be on disk, unless a terminal shows it.
    pub fn document(&self, text: &str) -> Result<(), CliError> {
        let mut stdout = io::stdout().lock();
        // A terminal would obey what is meant as text.
        if stdout.is_terminal() {
            drop(stdout);
            return self.result(text);
        }
        stdout.write_all(text.as_bytes())?;
        Ok(stdout.flush()?)
    }

    /// A message, unless `--quiet`.
    pub fn say(&self, text: &str) {
        if !self.quiet {
            self.stderr(text);
        }
    }

    /// A message for `--verbose`.
    pub fn detail(&self, text: &str) {
        if self.verbose > 0 && !self.quiet {
            self.stderr(text);
        }
    }

    /// A message that `--quiet` does not silence.
    pub fn stderr(&self, text: &str) {
        let mut stderr = AutoStream::new(io::stderr().lock(), self.stderr);
        // Nobody can be told that stderr is closed.
        let _ = writeln!(stderr, "{}", text.trim_end_matches('\n'));
    }

    /// `warning: text`.
    pub fn warn(&self, text: &str) {
        self.stderr(&format!("{WARNING}warning{WARNING:#}: {text}"));
    }

    /// `error: text`, for one of several faults.
    pub fn fault(&self, code: &str, text: &str, help: Option<&str>) {
        let code = if code.is_empty() {
            String::new()
        } else {
            format!("[{code}]")
        };
        self.stderr(&format!("{ERROR}error{code}{ERROR:#}: {text}"));
        if let Some(help) = help {
            self.stderr(&format!("{HELP}help{HELP:#}: {help}"));
        }
    }

    /// The error that ends the program, with its causes and what helps.
    pub fn error(&self, error: &CliError, help: Option<&str>) {
        // Of these everything has been said, or nobody listens.
        if matches!(error.exit(), Exit::BrokenPipe | Exit::Interrupted) {
            return;
        }
        if let CliError::Refused { findings, .. } = error {
            crate::show::findings::print(findings, self);
        }
        for fault in error.faults() {
            self.fault(&fault.code, &fault.detail, fault.help.as_deref());
        }
        self.fault("", &error.line(), help);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_that_goes_away_is_seen_without_writing() {
        let (reader, writer) = io::pipe().unwrap();
        assert!(!is_unread(&writer));
        drop(reader);
        assert!(is_unread(&writer));
        assert!(!is_unread(std::fs::File::create("/dev/null").unwrap()));
    }
}
