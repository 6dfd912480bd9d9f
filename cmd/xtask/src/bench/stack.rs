//! A local stack to measure.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use crate::project;

/// A local stack in a folder of its own.
pub struct Stack {
    /// For files of the benchmark.
    pub folder: tempfile::TempDir,
    rtsctl: PathBuf,
    variables: Vec<(String, String)>,
}

impl Stack {
    /// Starts it.
    pub fn start(programs: &Path) -> Result<Self> {
        Self::start_with(programs, &[])
    }

    /// Starts it with these variables in the environment of its daemons.
    pub fn start_with(programs: &Path, variables: &[(&str, &str)]) -> Result<Self> {
        let folder = tempfile::Builder::new().prefix("rtsb").tempdir_in("/tmp")?;
        let stack = Self {
            folder,
            rtsctl: programs.join("rtsctl"),
            variables: variables
                .iter()
                .map(|(name, value)| ((*name).to_owned(), (*value).to_owned()))
                .collect(),
        };
        stack.rtsctl(&["up"])?;
        Ok(stack)
    }

    /// Its `RTSCTL_HOME`.
    pub fn home(&self) -> PathBuf {
        self.folder.path().join("home")
    }

    /// Ends it.
    pub fn stop(self) -> Result<()> {
        self.rtsctl(&["down", "--yes"])
    }

    /// The time of an `rtsctl`, which must succeed.
    pub fn timed(&self, arguments: &[&str]) -> Result<Duration> {
        let start = Instant::now();
        self.rtsctl(arguments)?;
        Ok(start.elapsed())
    }

    /// Runs `rtsctl`, which must succeed.
    pub fn rtsctl(&self, arguments: &[&str]) -> Result<()> {
        self.output(arguments).map(drop)
    }

    /// The same, and what it prints.
    pub fn output(&self, arguments: &[&str]) -> Result<String> {
        let mut command = Command::new(&self.rtsctl);
        command
            .args(arguments)
            .env("RTSCTL_HOME", self.home())
            .envs(self.variables.iter().cloned())
            .stdin(Stdio::null());
        let output = command
            .output()
            .with_context(|| format!("cannot start {}", self.rtsctl.display()))?;
        if !output.status.success() {
            bail!(
                "{} ended with {}: {}",
                project::shown(&command),
                output.status,
                String::from_utf8_lossy(&output.stderr)
            );
        }
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    }
}

impl Drop for Stack {
    fn drop(&mut self) {
        // After an error in the middle; when all went well, nothing runs any more and this does nothing.
        let _ = self.rtsctl(&["down", "--purge", "--yes"]);
    }
}
