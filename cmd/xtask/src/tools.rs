//! Programs that the tests need: found on the machine, else installed.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::project;

/// What is needed: how to see that it is there, and the Debian package that has it.
const NEEDS: [(&[&str], &str); 7] = [
    (&["cc", "--version"], "gcc"),
    (&["c++", "--version"], "g++"),
    (&["python3", "-c", "import ensurepip"], "python3-venv"),
    (&["flock", "--version"], "util-linux"),
    (&["omniidl", "-V"], "omniidl"),
    (&["ssh", "-V"], "openssh-client"),
    // It is on the path of root alone, and says of itself no more than that it does not know the flag.
    (&["test", "-x", "/usr/sbin/sshd"], "openssh-server"),
];

/// Installs missing system packages when running as root on Debian; otherwise says what to install.
pub fn packages() -> Result<()> {
    let missing: Vec<&str> = NEEDS
        .iter()
        .filter(|(probe, _)| !answers(project::command(probe[0]).args(&probe[1..])))
        .map(|(_, package)| *package)
        .collect();
    install(&missing)?;
    for component in ["fmt", "clippy"] {
        if !has_cargo(component) {
            bail!("`cargo {component}` is missing: run `rustup component add rustfmt clippy`");
        }
    }
    Ok(())
}

/// Installs Debian packages, where that can be done.
fn install(packages: &[&str]) -> Result<()> {
    if packages.is_empty() {
        return Ok(());
    }
    if !rustix::process::geteuid().is_root() || find("apt-get").is_none() {
        bail!(
            "these packages are needed and cannot be installed from here: {}",
            packages.join(" ")
        );
    }
    project::run(project::command("apt-get").args(["update", "-q"]))?;
    project::run(
        project::command("apt-get")
            .args(["install", "-y", "-q"])
            .args(packages),
    )
}

/// Makes sure that there is an SSH server.
pub fn sshd() -> Result<()> {
    match rts_test_sshd::program() {
        Some(_) => Ok(()),
        None => install(&["openssh-server"]),
    }
}

fn answers(command: &mut Command) -> bool {
    command
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

/// A cargo subcommand: on the path, else from PyPI into the target folder, else by `cargo install` there.
pub fn cargo_tool(name: &str) -> Result<PathBuf> {
    let program = format!("cargo-{name}");
    let home = project::target().join("tools").join(name);
    let installed = home.join("bin").join(&program);
    if let Some(found) = find(&program) {
        return Ok(found);
    }
    if !installed.exists() && from_pypi(name, &home).is_err() {
        project::run(
            project::cargo()
                .args(["install", "--locked", "--root"])
                .arg(&home)
                .arg(&program),
        )
        .with_context(|| format!("cannot install {program}"))?;
    }
    Ok(installed)
}

fn from_pypi(name: &str, home: &Path) -> Result<()> {
    project::run(
        project::command("python3")
            .args(["-m", "venv"])
            .arg(home)
            .stderr(Stdio::null()),
    )?;
    let package = format!("astral-dev-toolchain-cargo-{name}");
    project::run(project::command(home.join("bin/pip")).args(["install", "-q", &package]))
}

/// What the Python of the reference library needs.
const REFERENCE: [&str; 3] = ["rtsprofile-aist==4.1.6", "pyyaml", "lxml"];

/// What has omniORB for Python. There are wheels for few machines.
const OMNIORB: [&str; 2] = ["--only-binary=:all:", "jeteve-omniorb==4.3.3.post7"];

/// A Python with the reference library for RTS Profiles, and omniORB if it can be had: that of `RTSCTL_REFERENCE`, else one of our own in the target
/// folder. `None`, and said so, where PyPI cannot be reached.
pub fn reference() -> Result<Option<PathBuf>> {
    if let Some(python) = std::env::var_os("RTSCTL_REFERENCE") {
        return Ok(Some(python.into()));
    }
    let home = project::target().join("tools/reference");
    let python = home.join("bin/python");
    let has = |modules: &str| {
        let probe = format!("import {modules}");
        answers(project::command(&python).args(["-c", &probe]))
    };
    let install = |what: &[&str]| {
        let mut pip = project::command(home.join("bin/pip"));
        pip.args(["install", "-q", "--retries", "1"]);
        project::run(pip.args(what)).is_ok()
    };
    const LIBRARY: &str = "rtsprofile, yaml, lxml.etree";
    if !has(LIBRARY) {
        project::run(project::command("python3").args(["-m", "venv"]).arg(&home))?;
        if !install(&REFERENCE) || !has(LIBRARY) {
            println!("the reference library cannot be had from PyPI: its tests are SKIPPED");
            return Ok(None);
        }
    }
    if !has("omniORB") && !install(&OMNIORB) {
        println!("omniORB cannot be had from PyPI: its tests are SKIPPED");
    }
    Ok(Some(python))
}

/// A program on the path.
pub fn find(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path)
        .map(|folder| folder.join(program))
        .find(|file| file.is_file())
}

/// True when a cargo subcommand answers.
pub fn has_cargo(subcommand: &str) -> bool {
    answers(project::cargo().args([subcommand, "--version"]))
}
