//! `cargo xtask mutants`: a law that no mutation can break is no law.
//!
//! Each patch in `mutants/` breaks one rule of the code and names the test that must fail for it. The patch is applied
//! to a copy of the sources; the test must pass there without it, build with it, and then fail.

mod copy;
mod patch;

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context, Result, bail};

use self::copy::Copy;
use self::patch::Patch;
use crate::project;

/// What the tests run: one rule of order, one of minimal change.
const SHORT: [&str; 2] = ["order-sync-is-ignored", "settled-is-made-again"];

/// A mutant is built more often than it is run.
const BUILT_FAST: [&str; 1] = ["profile.dev.package.rts-plan.opt-level=0"];

/// Arguments of `cargo xtask mutants`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Only these patches, by their file names without `.patch`.
    #[arg(value_name = "PATCH")]
    only: Vec<String>,
}

/// Tries every patch. Fails when one of them is not noticed.
pub fn run(args: &Args) -> Result<()> {
    let patches = patch::all(&project::root().join("mutants"))?;
    let known = |name: &String| patches.iter().any(|patch| patch.name == *name);
    if let Some(unknown) = args.only.iter().find(|name| !known(name)) {
        bail!("there is no mutants/{unknown}.patch");
    }
    let wanted = |patch: &&Patch| args.only.is_empty() || args.only.contains(&patch.name);
    let copy = Copy::new(&project::target().join("mutants"))?;
    // First all that must pass: what is built for it serves every patch.
    copy.refresh()?;
    for patch in patches.iter().filter(wanted) {
        if !test(copy.folder(), patch, false)? {
            bail!("{} fails without {} already", patch.test(), patch.name);
        }
    }
    let mut unnoticed = Vec::new();
    for patch in patches.iter().filter(wanted) {
        let start = Instant::now();
        let noticed = is_noticed(&copy, patch)?;
        let verdict = if noticed { "caught" } else { "NOT CAUGHT" };
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "{verdict:<10} {:<40} by {} ({seconds:.0} s)",
            patch.name,
            patch.test()
        );
        if !noticed {
            unnoticed.push(patch.name.as_str());
        }
    }
    if unnoticed.is_empty() {
        return Ok(());
    }
    bail!("no test noticed: {}", unnoticed.join(", "))
}

/// The part that the tests run.
pub fn short() -> Result<()> {
    run(&Args {
        only: SHORT.map(str::to_owned).to_vec(),
    })
}

/// True when the test that the patch names fails with it.
fn is_noticed(copy: &Copy, patch: &Patch) -> Result<bool> {
    copy.refresh()?;
    copy.apply(&patch.path)?;
    let noticed = build(copy.folder(), patch).and_then(|()| test(copy.folder(), patch, true));
    copy.refresh()?;
    Ok(!noticed?)
}

/// A mutant that does not build proves nothing.
fn build(folder: &Path, patch: &Patch) -> Result<()> {
    let mut command = cargo(folder, patch);
    project::run(command.arg("--no-run").arg("--quiet"))
        .with_context(|| format!("{} does not build; mend the patch", patch.name))
}

/// True when the test passes. What a failing one prints is expected, and kept back.
fn test(folder: &Path, patch: &Patch, mutated: bool) -> Result<bool> {
    let mut command = cargo(folder, patch);
    command
        .arg("--quiet")
        .args(["--", "--exact", &patch.name_of_test]);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let shown = project::shown(&command);
    let output = command
        .output()
        .with_context(|| format!("cannot start {shown}"))?;
    let text = String::from_utf8_lossy(&output.stdout);
    // A name that fits nothing passes too.
    if !text.contains("1 passed") && !text.contains("1 failed") {
        let errors = String::from_utf8_lossy(&output.stderr);
        let state = if mutated { "with" } else { "without" };
        bail!(
            "{shown}, {state} {}, ran no test:\n{text}{errors}",
            patch.name
        );
    }
    Ok(output.status.success())
}

fn cargo(folder: &Path, patch: &Patch) -> Command {
    let mut command = project::cargo();
    command.current_dir(folder);
    command.env("CARGO_TARGET_DIR", project::target());
    // The lock file knows the packages by another version.
    command.args(["test", "--offline"]);
    for settings in BUILT_FAST {
        command.args(["--config", settings]);
    }
    // Of all packages, as the tests were built: cargo would give a package alone other features of what it stands on, and
    // build all of that anew.
    match &patch.file {
        Some(file) => command.args(["--workspace", "--test", file]),
        None => command.args(["-p", &patch.package, "--lib"]),
    };
    // A mutant must not rewrite what snapshots say.
    command
        .env("INSTA_UPDATE", "no")
        .env("INSTA_FORCE_PASS", "0");
    command
}
