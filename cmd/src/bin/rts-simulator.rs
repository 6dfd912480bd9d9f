//! Plays a change through for the controller, which starts one process for each `rtsctl plan --simulate`. Everything it does is
//! in `rts_simulation`.

use std::io::{BufReader, stdin, stdout};
use std::process::ExitCode;

use clap::Parser;

/// Simulates a cluster for rts-controller: a scenario as a line of JSON on standard input, what happened on standard output
#[derive(Debug, Parser)]
#[command(name = "rts-simulator", version)]
struct Args {}

fn main() -> ExitCode {
    let Args {} = Args::parse();
    match rts_simulation::user::answer(BufReader::new(stdin()), stdout()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("rts-simulator: {error}");
            ExitCode::FAILURE
        }
    }
}
