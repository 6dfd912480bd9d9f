//! The manager program: see the crate `rts-manager`.

use std::process::ExitCode;

fn main() -> ExitCode {
    rts_manager::main(std::env::args_os().skip(1))
}
