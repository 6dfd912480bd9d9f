//! `cargo xtask bench read`: how fast generated profiles of 10 MB and 100 MB are read, checked and written, and how fast the
//! reference library reads the XML one of 10 MB, in one run.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};

use crate::{project, tools};

/// Megabytes of the profiles.
const SIZES: [u64; 2] = [10, 100];

/// Reads the file once, and prints the seconds.
const REFERENCE: &str = "
import re, sys, time
from rtsprofile.rts_profile import RtsProfile
text = re.sub(r'^<[?]xml.*?[?]>', '', open(sys.argv[1], encoding='utf-8').read())
start = time.monotonic()
profile = RtsProfile(xml_spec=text)
print(time.monotonic() - start)
";

/// Arguments of `cargo xtask bench read`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Runs of each row; the median is shown.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    runs: u32,
    /// Only up to so many megabytes.
    #[arg(long, default_value_t = 100)]
    up_to: u64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// One row: megabytes a second.
#[derive(Debug, Serialize)]
struct Row {
    format: &'static str,
    megabytes: f64,
    components: u64,
    read: f64,
    read_check_lower: f64,
    read_write: f64,
    /// Reading by the reference library, where it was measured.
    reference_read: Option<f64>,
}

/// What the measuring program prints.
#[derive(Debug, Deserialize)]
struct Measured {
    bytes: u64,
    components: u64,
    read: f64,
    load: f64,
    write: f64,
}

/// Measures all rows and prints them.
pub fn run(args: &Args) -> Result<()> {
    let example = [
        "build",
        "--release",
        "--quiet",
        "-p",
        "rts-schemas",
        "--example",
        "read_profile",
    ];
    project::run(project::cargo().args(example))?;
    let program = project::programs("release").join("examples/read_profile");
    let reference = tools::reference()?;
    let folder = tempfile::tempdir().context("cannot make a folder")?;
    let mut rows = Vec::new();
    for megabytes in SIZES.into_iter().filter(|size| *size <= args.up_to) {
        for format in ["xml", "yaml"] {
            let file = folder.path().join(format!("{megabytes}.{format}"));
            generate(&program, format, megabytes * 1_000_000, &file)?;
            // Its YAML parser takes minutes for that.
            let measured = megabytes == SIZES[0] && format == "xml";
            let python = reference.as_ref().filter(|_| measured);
            rows.push(row(&program, format, &file, args.runs, python)?);
        }
    }
    print(&rows, args.json)
}

fn generate(program: &Path, format: &str, bytes: u64, file: &Path) -> Result<()> {
    let out =
        std::fs::File::create(file).with_context(|| format!("cannot make {}", file.display()))?;
    let mut command = project::command(program);
    command.args(["generate", format, &bytes.to_string()]);
    project::run(command.stdout(out))
}

fn row(
    program: &Path,
    format: &'static str,
    file: &Path,
    runs: u32,
    python: Option<&PathBuf>,
) -> Result<Row> {
    let mut command = project::command(program);
    command.arg("measure").arg(file).arg(runs.to_string());
    let measured: Measured = serde_json::from_str(&output(&mut command)?)?;
    let reference = match python {
        None => None,
        Some(python) => {
            let mut command = project::command(python);
            let seconds = output(command.args(["-c", REFERENCE]).arg(file))?;
            Some(seconds.trim().parse::<f64>().context("seconds")?)
        }
    };
    let megabytes = measured.bytes as f64 / 1e6;
    Ok(Row {
        format,
        megabytes,
        components: measured.components,
        read: megabytes / measured.read,
        read_check_lower: megabytes / measured.load,
        read_write: megabytes / measured.write,
        reference_read: reference.map(|seconds| megabytes / seconds),
    })
}

fn output(command: &mut std::process::Command) -> Result<String> {
    let shown = project::shown(command);
    let output = command
        .output()
        .with_context(|| format!("cannot start {shown}"))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        bail!("{shown} ended with {}: {said}", output.status);
    }
    String::from_utf8(output.stdout).context("its output")
}

fn print(rows: &[Row], json: bool) -> Result<()> {
    if json {
        let rows = serde_json::json!({ "rows": rows });
        println!("{}", serde_json::to_string_pretty(&rows)?);
        return Ok(());
    }
    println!(
        "{:<7} {:>7} {:>11} {:>8} {:>12} {:>12} {:>11}   (MB/s)",
        "FORMAT", "MB", "COMPONENTS", "READ", "CHECK+LOWER", "READ+WRITE", "REFERENCE"
    );
    for row in rows {
        let reference = row.reference_read;
        println!(
            "{:<7} {:>7.1} {:>11} {:>8.1} {:>12.1} {:>12.1} {:>11}",
            row.format,
            row.megabytes,
            row.components,
            row.read,
            row.read_check_lower,
            row.read_write,
            reference.map_or("-".to_owned(), |speed| format!("{speed:.2}"))
        );
    }
    Ok(())
}
