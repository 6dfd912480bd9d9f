//! `rtsctl smoke`.

mod again;
mod apply;
mod budget;
mod check;
mod clean;
mod context;
mod evidence;
mod export;
mod failure;
mod heal;
mod junit;
mod nodes;
mod processes;
mod report;
mod samples;
mod sequence;
mod snapshot;
mod stack;
mod steady;
mod teardown;

use std::path::PathBuf;
use std::time::Duration;

use clap::ValueEnum;

use self::budget::{Budget, Budgets};
use self::context::Context;
use self::report::Report;
pub use self::snapshot::Snapshot;
use self::stack::Stack;
use super::{duration, or_interrupted};
use crate::cli::Globals;
use crate::error::CliError;
use crate::exit::Exit;
use crate::input::InputArgs;
use crate::output::Output;
use crate::save::save;
use crate::session::Session;

/// Try a system out on a throw-away stack: start it, see that data flows, break it, and see that nothing is left
///
/// Starts a controller, and an agent for each host of the profile, in a folder of its own; the stack of RTSCTL_HOME is not
/// touched. The checks are: start, apply, samples (every data connector carries some), again (a second apply changes
/// nothing), export (what `rtsctl export` writes changes nothing), steady (nothing dies for a while), heal (a manager that
/// is killed comes back, and nothing else is touched), teardown and clean (no process, socket, file or shared memory is
/// left). Several smoke tests may run at a time.
#[derive(Debug, clap::Args)]
#[command(
    override_usage = "rtsctl smoke [OPTIONS] FILE [-f OVERLAY]...\n       rtsctl smoke [OPTIONS] -f FILE [-f OVERLAY]..."
)]
pub struct Args {
    /// The system.
    #[command(flatten)]
    input: InputArgs,
    /// How long all of it may take; taking the stack down comes on top
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = duration)]
    timeout: Duration,
    /// A check, or `total`, fails when it takes longer (`apply=2s`); may be repeated
    #[arg(long = "budget", value_name = "CHECK=TIME")]
    budgets: Vec<Budget>,
    /// How long everything must run, before something is killed, without a component that dies or leaves its state
    #[arg(long, value_name = "TIME", default_value = "500ms", value_parser = duration)]
    steady: Duration,
    /// Kill nothing: leave out the check `heal`
    #[arg(long)]
    no_faults: bool,
    /// How to print the report
    #[arg(short, long, value_name = "FORMAT", default_value = "table")]
    output: Format,
    /// Write a JUnit file: a test suite with a test case for each check
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Write a picture of the system as it was before it was taken down
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
}

/// How to print the report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Columns
    Table,
    /// JSON
    Json,
    /// YAML
    Yaml,
}

/// Refuses options that mean another stack.
pub fn own_stack(globals: &Globals) -> Result<(), CliError> {
    if globals.home.is_none() && globals.controller.is_none() {
        return Ok(());
    }
    Err(CliError::usage_help(
        "a smoke test has a stack of its own",
        "leave out --home and --controller",
    ))
}

/// Runs the checks, takes everything down, and reports.
pub async fn run(args: Args, out: &Output) -> Result<Exit, CliError> {
    let input = args.input.load(out)?;
    if !input.request.targets.is_empty() {
        return Err(CliError::usage_help(
            "a smoke test is of a whole system",
            "leave out --target",
        ));
    }
    let stack = Stack::make(nodes::of(&input.request.spec)?, *out)?;
    let mut context = Context::new(&input, &stack, args.timeout, args.steady);
    let mut report = Report::new(&input.request.spec, Budgets(args.budgets.clone()));
    let checks = sequence::run(&mut context, &mut report, !args.no_faults);
    let interrupted = interrupted(checks, &stack.session).await;
    sequence::end(&mut context, &mut report);
    if interrupted {
        return Err(CliError::Interrupted);
    }
    report.print(args.output, out)?;
    if let Some(path) = &args.junit {
        save(path, &junit::render(&report)?)?;
    }
    if let Some(path) = &args.svg {
        save(path, &context.picture())?;
    }
    Ok(report.exit())
}

/// Waits, and says whether somebody ended it before: by Ctrl-C, or by SIGTERM.
async fn interrupted(checks: impl Future<Output = ()>, session: &Session) -> bool {
    use tokio::signal::unix::{SignalKind, signal};
    let terminated = async {
        match signal(SignalKind::terminate()) {
            Ok(mut signal) => drop(signal.recv().await),
            Err(_) => std::future::pending().await,
        }
        session.out.stderr("rtsctl: taking the stack down");
    };
    let checks = async {
        tokio::select! {
            biased;
            () = terminated => Err(CliError::Interrupted),
            () = checks => Ok(()),
        }
    };
    let home = session.home.path().display();
    let said = format!(
        "taking the stack down; a second Ctrl-C ends this at once, then `rtsctl --home {home} down --purge --yes` does it"
    );
    or_interrupted(checks, session, &said).await.is_err()
}
