//! Where things are, and running programs there.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

/// The folder of the workspace.
pub fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here).to_owned()
}

/// The folder of built files.
pub fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from)
}

/// The folder of programs and modules of the given cargo profile (`dev` builds into `debug`).
pub fn programs(profile: &str) -> PathBuf {
    target().join(if profile == "dev" { "debug" } else { profile })
}

/// `cargo`, in the workspace.
pub fn cargo() -> Command {
    command(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

/// A program, in the workspace.
pub fn command(program: impl AsRef<std::ffi::OsStr>) -> Command {
    let mut command = Command::new(program);
    command.current_dir(root());
    command
}

/// What is built together with a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Build {
    /// The programs and modules of the workspace.
    Programs,
    /// The same, for speed.
    Release,
    /// The tests too, as the suite `build` has done it.
    Everything,
}

/// A program of the workspace, built. All of the workspace is built with it: cargo would give a package that is built alone,
/// or without its tests, other features of what it stands on, and build all of that a second time.
pub fn program(name: &str, build: Build) -> Result<Command> {
    let mut command = cargo();
    command.args(["build", "--quiet", "--workspace", "--locked"]);
    let profile = match build {
        Build::Programs => "dev",
        Build::Release => {
            command.arg("--release");
            "release"
        }
        Build::Everything => {
            command.arg("--all-targets");
            "dev"
        }
    };
    run(&mut command)?;
    Ok(self::command(programs(profile).join(name)))
}

/// Runs to the end; anything but success is an error that shows the command.
pub fn run(command: &mut Command) -> Result<()> {
    let status = command
        .status()
        .with_context(|| format!("cannot start {}", shown(command)))?;
    if !status.success() {
        bail!("{} ended with {status}", shown(command));
    }
    Ok(())
}

/// A command as a person would type it.
pub fn shown(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    words
        .map(|w| w.to_string_lossy().into_owned())
        .collect::<Vec<_>>()
        .join(" ")
}
