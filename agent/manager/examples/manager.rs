//! The manager as a program, for the tests of this crate.

use std::process::ExitCode;

fn main() -> ExitCode {
    rts_manager::main(std::env::args_os().skip(1))
}
