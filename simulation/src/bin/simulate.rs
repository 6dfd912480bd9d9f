//! Runs seeds of the simulation, on all cores; makes what fails small.

use std::process::ExitCode;

fn main() -> ExitCode {
    rts_simulation::program::main()
}
