//! The manager: the process that loads modules and holds components.
//!
//! It does what its control connections say (`requests`) and decides nothing. Each component has one thread, its
//! execution context (`component`), which alone calls into the module; everything else talks to that thread over a
//! bounded channel with a deadline, so that a component that hangs stops nobody but itself. Samples flow through
//! `data` without passing the control side. It is spawned, or a copy of a process that is warm (`zygote`).

mod args;
mod component;
mod connection;
mod data;
mod describe;
mod events;
mod failure;
mod log;
mod log_file;
mod manager;
mod module;
mod own_log;
mod pool;
mod requests;
mod run_dir;
mod server;
mod slots;
mod stand_in;
mod sync;
mod tap;
mod text;
mod zygote;

use std::ffi::OsString;
use std::process::ExitCode;

use self::manager::Leftovers;
use self::server::ServeError;

/// Runs a manager until it is told to end. `args` come without the program's name. Exit code 2 is wrong usage, 1 a
/// manager that cannot start.
pub fn main(args: impl IntoIterator<Item = OsString>) -> ExitCode {
    let settings = match args::parse(args) {
        Ok(args::Parsed::Run(settings)) => settings,
        Ok(args::Parsed::Describe(file, type_name)) => {
            let described = describe::describe(&file, &type_name);
            if let Err(error) = &described {
                log::plain(format_args!("{error}"));
            }
            // Past the exit handlers of the library, which may hang or crash as its initialisers may.
            signal_hook::low_level::exit(i32::from(described.is_err()));
        }
        Ok(args::Parsed::Zygote(home)) => return zygote::run(&home),
        Ok(args::Parsed::Print(text)) => {
            log::print(&text);
            return ExitCode::SUCCESS;
        }
        Err(error) => {
            log::error(format_args!("{error} (see --help)"));
            return ExitCode::from(2);
        }
    };
    finish(server::run(settings))
}

/// The exit of a manager that has ended.
fn finish(ended: Result<Leftovers, ServeError>) -> ExitCode {
    match ended {
        Ok(Leftovers::None) => ExitCode::SUCCESS,
        Ok(Leftovers::Running) => signal_hook::low_level::exit(0),
        Err(error) => {
            log::error(format_args!("{error}"));
            ExitCode::FAILURE
        }
    }
}
