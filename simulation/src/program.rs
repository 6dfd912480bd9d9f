//! The program `simulate`.

mod args;
mod one;
mod seeds;
mod serve;
mod show;

use std::process::ExitCode;

use self::args::{Args, Mode};

/// Runs it with the arguments of the process. Fails when an invariant did not hold (1), or when it cannot run (2).
pub fn main() -> ExitCode {
    let args = match args::parse(std::env::args().skip(1)) {
        Ok(Args { help: true, .. }) => {
            println!("{}", args::HELP);
            return ExitCode::SUCCESS;
        }
        Ok(args) => args,
        Err(why) => {
            eprintln!("error: {why}\n\n{}", args::HELP);
            return ExitCode::from(2);
        }
    };
    let done = match args.mode() {
        Mode::One(seed) => one::run(&args, seed),
        Mode::Many => seeds::run(&args),
        Mode::Serve(served) => return serve::run(&served),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(e) => {
            eprintln!("error: cannot run the simulation: {e}");
            ExitCode::from(2)
        }
    }
}
