//! `chaos`: random faults against real processes. `cargo xtask chaos` builds what it starts, and runs it.

use std::io::Error;
use std::os::unix::process::CommandExt;
use std::process::{Command, ExitCode};
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use clap::Parser;
use clap::builder::PossibleValuesParser;
use rts_tests::chaos::{INSIDE, Options, Sabotage, may_mount, run};
use signal_hook::consts::{SIGINT, SIGTERM};

/// Random kills, stops, deletions and full disks against real processes
#[derive(Debug, Parser)]
struct Args {
    /// How long.
    #[arg(long, default_value_t = 1.0)]
    minutes: f64,
    /// What is done follows from it; another one each time when it is not given.
    #[arg(long)]
    seed: Option<u64>,
    /// Breaks an invariant after the second round: this must be noticed.
    #[arg(long, value_parser = PossibleValuesParser::new(Sabotage::ALL.map(|(name, _)| name)))]
    sabotage: Option<String>,
}

fn main() -> ExitCode {
    let args = Args::parse();
    if std::env::var_os(INSIDE).is_none() && may_mount() {
        let error = inside();
        eprintln!("chaos: cannot start in a mount namespace: {error}");
        return ExitCode::FAILURE;
    }
    let signal = Arc::new(AtomicUsize::new(0));
    for number in [SIGINT, SIGTERM] {
        let value = usize::try_from(number).unwrap_or_default();
        if let Err(error) = signal_hook::flag::register_usize(number, Arc::clone(&signal), value) {
            eprintln!("chaos: cannot listen for signals: {error}");
            return ExitCode::FAILURE;
        }
    }
    let wanted = args.sabotage.as_deref();
    let all = Sabotage::ALL.into_iter();
    let mut wanted = all.filter(|(name, _)| Some(*name) == wanted);
    let options = Options {
        time: Duration::try_from_secs_f64(args.minutes * 60.0).unwrap_or_default(),
        seed: args.seed.unwrap_or_else(any_seed),
        sabotage: wanted.next().map(|(_, what)| what),
        signal,
    };
    ExitCode::from(run(&options))
}

/// This program again, with mounts of its own. Comes back only when that fails.
fn inside() -> Error {
    let own = match std::env::current_exe() {
        Ok(own) => own,
        Err(error) => return error,
    };
    let mut command = Command::new("unshare");
    command
        .args(["-m", "--propagation", "private", "--"])
        .arg(own);
    command.args(std::env::args_os().skip(1)).env(INSIDE, "1");
    command.exec()
}

fn any_seed() -> u64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    now.map_or(1, |since| since.subsec_nanos().into())
}
