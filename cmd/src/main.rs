//! The program `rtsctl`.

use std::process::ExitCode;

fn main() -> ExitCode {
    rtsctl::main()
}
