//! `cargo xtask demo`: the main job on a real local stack, each command shown as it runs.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use crate::project;

/// Arguments of `cargo xtask demo`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Use what is built already.
    #[arg(long)]
    no_build: bool,
}

/// A command line and the exit code that it must have.
struct Line(&'static str, i32);

const LINES: [Line; 11] = [
    Line("rtsctl up", 0),
    Line("rtsctl apply manifests/hello/system.xml", 0),
    Line("rtsctl get components", 0),
    Line("sleep 1", 0),
    Line("rtsctl get connectors", 0),
    Line("rtsctl apply manifests/hello/system.xml", 0),
    Line("rtsctl diff manifests/hello/changed.xml", 1),
    Line("rtsctl logs Printer0 --tail 5", 0),
    Line("rtsctl teardown hello --yes", 0),
    Line("rtsctl get components", 0),
    Line("rtsctl down --purge", 0),
];

/// Builds, runs the lines, and looks for anything left behind.
pub fn run(args: &Args) -> Result<()> {
    if !args.no_build {
        println!("$ cargo build --workspace");
        project::run(project::cargo().args(["build", "--workspace"]))?;
    }
    // Short, because a Unix socket path may have 107 bytes.
    let home = tempfile::Builder::new()
        .prefix("rts")
        .tempdir_in("/tmp")
        .context("cannot make a folder in /tmp")?
        .keep();
    println!("$ export RTSCTL_HOME={}", home.display());
    let shown = LINES.iter().try_for_each(|line| show(line, &home));
    if shown.is_err() {
        // Whatever went wrong, a demo leaves nothing running.
        let _ = line("rtsctl down --purge --yes", &home)
            .stdin(Stdio::null())
            .status();
    }
    shown?;
    nothing_left(&home)
}

fn show(Line(text, expected): &Line, home: &Path) -> Result<()> {
    println!("\n$ {text}");
    let status = line(text, home)
        .stdin(Stdio::null())
        .status()
        .with_context(|| format!("cannot start `{text}`"))?;
    if status.code() != Some(*expected) {
        bail!("`{text}` ended with {status} instead of exit code {expected}");
    }
    if *expected != 0 {
        println!("(exit code {expected})");
    }
    Ok(())
}

fn line(text: &str, home: &Path) -> Command {
    let mut words = text.split_whitespace();
    let programs = project::programs("dev");
    let program = words.next().unwrap_or_default();
    let mut command = match program {
        // Never another one that is installed.
        "rtsctl" => project::command(programs.join(program)),
        _ => project::command(program),
    };
    command.args(words).env("RTSCTL_HOME", home);
    command
}

/// Fails when a process still works with the folder, or the folder is still there.
fn nothing_left(home: &Path) -> Result<()> {
    let deadline = Instant::now() + Duration::from_secs(5);
    loop {
        let processes = processes_of(home)?;
        let folder = home.exists();
        if processes.is_empty() && !folder {
            println!("\nNothing is left: no process, no socket, no file.");
            return Ok(());
        }
        if Instant::now() > deadline {
            bail!(
                "left behind: processes {processes:?}{}",
                if folder {
                    format!(", folder {}", home.display())
                } else {
                    String::new()
                }
            );
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Live processes whose command line names the folder.
fn processes_of(home: &Path) -> Result<Vec<u32>> {
    let needle = home.as_os_str().as_encoded_bytes();
    let own = std::process::id();
    let mut found = Vec::new();
    for entry in std::fs::read_dir("/proc").context("cannot read /proc")? {
        let entry = entry?;
        let Some(pid) = entry
            .file_name()
            .to_str()
            .and_then(|n| n.parse::<u32>().ok())
        else {
            continue;
        };
        // A process may end between the listing and the reading: then it is not left behind.
        let Ok(line) = std::fs::read(entry.path().join("cmdline")) else {
            continue;
        };
        if pid != own && line.windows(needle.len()).any(|window| window == needle) {
            found.push(pid);
        }
    }
    Ok(found)
}
