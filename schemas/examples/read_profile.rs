//! Makes profiles of any size, and measures how fast they are read; for `cargo xtask bench read`.
//!
//! `read_profile generate xml|yaml BYTES` prints a profile; `read_profile measure FILE RUNS` prints medians as JSON.

#![allow(clippy::disallowed_methods)] // A program, not the library: it reads files and the clock.

#[path = "../tests/generated/mod.rs"]
#[allow(dead_code)]
mod generated;

use std::error::Error;
use std::io::Write;
use std::time::Instant;

use rts_schemas::form::Format;
use rts_schemas::rts_profile::{self, load_with_places, read};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["generate", kind, bytes] => generate(kind, bytes.parse()?),
        ["measure", file, runs] => measure(file, runs.parse()?),
        _ => Err("usage: read_profile generate xml|yaml BYTES | measure FILE RUNS".into()),
    }
}

fn generate(kind: &str, bytes: usize) -> Result<(), Box<dyn Error>> {
    let text = match kind {
        "xml" => generated::of_size(bytes),
        // The same system is shorter in YAML.
        _ => in_yaml(bytes + bytes / 20)?,
    };
    Ok(std::io::stdout().write_all(text.as_bytes())?)
}

fn in_yaml(bytes: usize) -> Result<String, Box<dyn Error>> {
    let xml = generated::of_size(bytes);
    let read = read("generated.xml", xml.as_bytes()).map_err(|report| format!("{report:?}"))?;
    Ok(rts_profile::format(&read.shape, &read.around, Format::Yaml))
}

fn measure(file: &str, runs: usize) -> Result<(), Box<dyn Error>> {
    let bytes = std::fs::read(file)?;
    let readable = read(file, &bytes).map_err(|report| format!("{report:?}"))?;
    let components = readable.profile.components.len();
    let findings = readable.findings.findings.len();
    drop(readable);
    let reading = median(runs, || drop(read(file, &bytes)));
    let loading = median(runs, || drop(load_with_places(file, &bytes, None, &[])));
    let writing = median(runs, || {
        if let Ok(read) = read(file, &bytes) {
            drop(rts_profile::format(&read.shape, &read.around, read.format));
        }
    });
    println!(
        "{{\"bytes\": {}, \"components\": {components}, \"findings\": {findings}, \"read\": {reading}, \"load\": {loading}, \"write\": {writing}}}",
        bytes.len()
    );
    Ok(())
}

/// Median of the seconds of some runs.
fn median(runs: usize, run: impl Fn()) -> f64 {
    let mut seconds: Vec<f64> = (0..runs.max(1))
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}
